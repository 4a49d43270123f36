"""The loop of editing and running: the page runs the current file, and shows where it fails."""

import pytest

from tests.helpers.browser import expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import opened

ARRIVES = """
import math

class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return (1.0, 0.0), memory
"""
TURNS = ARRIVES.replace("(1.0, 0.0)", "(0.0, 1.0)")
BROKEN = ARRIVES.replace("memory):", "memory:")
CRASHES = ARRIVES.replace("(1.0, 0.0)", "(1.0 / len(memory), 0.0)")


@pytest.mark.gate
def test_an_edited_controller_runs_at_once_and_a_fault_is_shown_where_it_is(browser, tmp_path):
    robot = tmp_path / "mine.py"
    robot.write_text(TURNS)
    with studio_of(tmp_path, named=[f"{robot}:Robot"]) as gate, opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator(".result", has_text="loop").wait_for()

        # An edit triggers a run; a syntax error replaces the earlier result.
        robot.write_text(BROKEN)
        page.locator(".failed .frame", has_text="mine.py:8").wait_for()
        expect(page.locator(".frame code")).to_contain_text("def act(self, observation, memory:")
        expect(page.locator(".result")).to_have_count(0)
        expect(page.locator("#scrub")).to_have_count(0)

        # A broken file is still broken after a reload; fixing it needs no reload.
        page.reload()
        page.locator("#gone", has_text="mine.py").wait_for()
        robot.write_text(CRASHES)
        page.locator(".result .frame", has_text="1.0 / len(memory)").wait_for()
        page.locator("#gone").wait_for(state="hidden")

        # If the box is not ticked, the page only reports the edit.
        page.get_by_label("Run again when its code is edited").uncheck()
        robot.write_text(TURNS)
        page.locator("#code-note", has_text="run again.").wait_for()
        expect(page.locator(".stage.stale")).to_have_count(1)
        page.locator("#run-edited").click()
        page.locator(".result", has_text="loop").wait_for()
        page.locator("#code-note", has_text="the current code").wait_for()
        assert page.complaints == []
