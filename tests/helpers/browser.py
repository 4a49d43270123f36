"""Debian's Chromium without a window, driven by Playwright."""

import contextlib
import shutil
import time
from importlib.util import find_spec

WAIT = 180_000  # ms until a wait is given up; long, because the machine may be busy
EXPECTED = 60_000  # ms until an expectation has failed
_WINDOW = {"viewport": {"width": 1280, "height": 900}}


def chromium():
    """Return the path of the browser, or None if there is none.

    Without the parts that draw windows it takes about half of the processor time.
    """
    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    return next(filter(None, map(shutil.which, names)), None)


def missing_browser():
    """Return what this machine lacks for the browser tests; empty if it has everything."""
    if chromium() is None:
        return "no Chromium: pages are not tested in a browser (apt-get install chromium-headless-shell)"
    if find_spec("playwright") is None:
        return "no Playwright: pages are not tested in a browser (pip install 'worldgen[test]')"
    return ""


@contextlib.contextmanager
def chromium_browser():
    """Start a browser; many pages can share it, because each has a profile of its own."""
    from playwright.sync_api import expect, sync_playwright  # other tests run without it

    expect.set_options(timeout=EXPECTED)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium(), args=["--no-sandbox", "--disable-gpu"]
        )
        yield browser
        browser.close()


@contextlib.contextmanager
def page_in(browser, **how):
    """Open an empty page in a fresh profile.

    The page collects what it writes to the console as ``complaints`` and the addresses it asks for
    as ``requested``.
    """
    with browser.new_context(**(_WINDOW | how)) as context:
        page = context.new_page()
        page.set_default_timeout(WAIT)
        page.complaints = []
        page.requested = []
        page.on("console", lambda message: page.complaints.append(message.text))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("request", lambda request: page.requested.append(request.url))
        yield page


def expect(subject):
    """Return Playwright's assertions about a page or a part of it, which wait until they hold.

    A page answers later than the mouse and the keyboard, so an ``assert`` about what it shows at
    one moment fails on a busy machine.
    """
    from playwright import sync_api  # other tests run without it

    return sync_api.expect(subject)


def eventually(page, read, accepts=bool):
    """Wait until a state that only Python can judge, such as pixels, is accepted; return it."""
    until = time.monotonic() + EXPECTED / 1000
    while not accepts(state := read()):
        assert time.monotonic() < until, f"still {str(state)[:500]}"
        page.wait_for_timeout(50)
    return state
