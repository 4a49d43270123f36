"""The browser shared by all files in this folder, and a page of the studio that a file serves as
``gate``.
"""

import pytest

from tests.helpers.browser import chromium_browser, missing_browser


@pytest.fixture(scope="package")
def browser():
    """One process for each worker.

    It ends with the last test of this folder: while it runs, no other test in the worker can have
    an event loop.
    """
    if missing := missing_browser():
        pytest.skip(missing)
    with chromium_browser() as browser:
        yield browser


@pytest.fixture
def page(browser, gate):
    from tests.helpers.studio_page import opened

    with opened(browser, gate) as page:
        yield page
