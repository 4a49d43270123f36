"""Body, goal and waypoints of the robot on the page Draw: by the texts of the command line's options."""

import re
from pathlib import Path

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened

pytestmark = pytest.mark.gate


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder: Path = tmp_path_factory.mktemp("goal")
    with studio_of(folder) as gate:
        yield gate


def fill(page, name, words):
    page.get_by_label(name).fill(words)
    page.get_by_label(name).press("Enter")


def test_a_body_a_heading_and_waypoints_are_given_proved_drawn_and_undone(browser, gate):
    with opened(browser, gate) as page:
        page.locator("#goal summary").click()
        # What is typed while the answer about another field is on its way stays.
        page.get_by_label("Footprint").evaluate(
            """footprint => {
              const waypoints = document.querySelector("#goal input[placeholder^=none]");
              waypoints.value = "1.0,2.0 2.0,1.0";
              waypoints.dispatchEvent(new Event("change"));
              footprint.focus();
              footprint.value = "0.3x0.2";
            }"""
        )
        expect(page.locator("#undo")).to_be_enabled()
        expect(page.get_by_label("Footprint")).to_have_value("0.3x0.2")
        fill(page, "Footprint", "0.3x0.2")
        fill(page, "Heading at the target", "1.57:0.2")
        page.get_by_label("To arrive").select_option("stop")
        page.locator("#proof.good", has_text="reachable").wait_for()
        expect(page.get_by_label("Footprint")).to_have_value("0.3x0.2")
        fill(page, "Footprint", "wide")
        page.locator("#goal .bad", has_text="footprint").wait_for()
        fill(page, "Footprint", "")
        page.locator("#goal .bad").wait_for(state="hidden")
        expect(page.get_by_label("Waypoints")).to_have_value(re.compile(r"^1\.0,2\.0"))
        assert page.complaints == []
