"""A browser for the tests of pages, and a page of the studio that the test's module serves as ``gate``."""

import pytest


@pytest.fixture(scope="module")
def browser():
    from tests.helpers.studio_page import chromium_browser  # there may be no playwright, for other tests

    with chromium_browser() as browser:
        yield browser


@pytest.fixture
def page(browser, gate):
    from tests.helpers.studio_page import opened

    with opened(browser, gate) as page:
        yield page
