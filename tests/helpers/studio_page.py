"""The studio's page in Debian's Chromium, driven by Playwright with real mouse and keyboard."""

import contextlib

from tests.helpers.browser import expect, page_in

# The page of somebody who has last run the thesis's robot, under its own motion model.
_USED = """() => {
  const get = Storage.prototype.getItem;
  Storage.prototype.getItem = function (name) {
    const kept = get.call(this, name);
    const isFirst = kept === null && this === localStorage && name.startsWith("worldgen-studio-kept-play-");
    return isFirst ? '{"motion":"stepped","chosen":["thesis-2"],"named":[]}' : kept;
  };
}"""
SECONDS = 180  # the first run on a machine compiles its kernels
CAMPAIGN = 180_000  # ms for a campaign, because its process has to start and to compile


@contextlib.contextmanager
def opened(browser, gate, **how):
    """The page of a studio, in a fresh browser.

    Yield it with its console output.
    """
    with opened_at(browser, gate.address, **how) as page:
        yield page


@contextlib.contextmanager
def opened_at(browser, address, *, until="#proof.good, #proof.bad", is_new=False, **how):
    """Do the same for the address that a studio printed.

    Its user has last run the thesis's robot, unless ``is_new`` is set.
    """
    with page_in(browser, **({"viewport": {"width": 1280, "height": 720}} | how)) as page:
        page.set_default_timeout(SECONDS * 1000)
        if not is_new:
            page.add_init_script(f"({_USED})()")
        page.goto(address)
        if until:
            page.wait_for_selector(until)
        yield page


def place(page, x, y):
    """Return where a point of the world, in cells, is in the window, if all of it is shown."""
    box = page.locator("#board").bounding_box()
    columns, rows = (
        int(page.get_by_label(name).first.input_value()) for name in ("Columns", "Rows")
    )
    scale = min((box["width"] - 108) / columns, (box["height"] - 68) / rows)
    return (
        box["x"] + box["width"] / 2 + (x - columns / 2) * scale,
        box["y"] + box["height"] / 2 - (y - rows / 2) * scale,
    )


def drag(page, first, last, *, button="left"):
    """Drags from the middle of one cell to the middle of another."""
    page.mouse.move(*place(page, first[0] + 0.5, first[1] + 0.5))
    page.mouse.down(button=button)
    page.mouse.move(*place(page, last[0] + 0.5, last[1] + 0.5), steps=5)
    page.mouse.up(button=button)


def solid_cells(page):
    """Return how many cells are solid, according to the text below the board."""
    words = _about_the_world(page)
    words.filter(has_text="solid").wait_for()
    return int(words.inner_text().split(" cells, ")[1].split(" solid")[0].replace(",", ""))


def expect_solid_cells(page, count):
    """Wait until so many cells are solid, according to the text below the board."""
    expect(_about_the_world(page)).to_contain_text(f" cells, {count:,} solid")


def _about_the_world(page):
    """Move the mouse off the board, so that the text below it is about the whole world."""
    page.mouse.move(*place(page, 1, 1))
    page.mouse.move(640, 20)
    return page.locator(".status .place")
