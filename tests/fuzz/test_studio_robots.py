"""Robots whose options are their own, beside others: the command line's words on the page."""

from pathlib import Path

import pytest

from sim import simulate
from sim.scenario import Scenario
from tests.helpers.browser import missing_browser
from tests.helpers.studio import page_of, studio_of
from worldgen.grid_file import read_world

pytest.importorskip("playwright", reason="no playwright here: the studio is not tested in a browser")
in_a_browser = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

from fuzz.studio.messages import message_of  # noqa: E402
from tests.helpers.studio_page import opened  # noqa: E402

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    (folder / "config-05.grid").write_bytes(CONFIG_5.read_bytes())
    (folder / "evil.py").write_text(f"open({str(folder / 'ran')!r}, 'w')\n")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder, file="config-05.grid") as gate:
        yield gate


def run(page, controllers, **changes):
    message = {"world": message_of(read_world(CONFIG_5)), "motion": "stepped", "time_step": 0.015, "seed": 0}
    message |= {"controllers": controllers, "steps": 500, "options": {}}
    return page.ask("run", **(message | changes))["parts"][1:]


def digest(label):
    world, scenario = read_world(CONFIG_5), Scenario.parse(label, motion="stepped", time_step=0.015)
    return simulate(world, scenario.controller, scenario.options(world, 500)).trace_digest


def test_robots_with_and_without_options_of_their_own_drive_at_once(gate):
    labels = ["thesis-1", "thesis-1+repaired", "thesis-1+slip=0.2"]
    with page_of(gate) as page:
        found = [part["digest"] for part in run(page, labels)]
    assert found == [digest(label) for label in labels] and len(set(found)) > 1


def test_a_robot_s_own_option_counts_more_than_that_of_all(gate):
    with page_of(gate) as page:
        parts = run(page, ["thesis-1", "thesis-1+slip=0.3"], options={"slip": 0.2})
    assert [part["digest"] for part in parts] == [digest("thesis-1+slip=0.2"), digest("thesis-1+slip=0.3")]


def test_what_is_wrong_with_one_robot_s_options_is_told_and_the_others_drive(gate):
    with page_of(gate) as page:
        wrong, right = run(page, ["thesis-1+slop=0.3", "thesis-1"])
    assert "slop" in wrong["error"] and right["digest"] == digest("thesis-1")


@pytest.mark.parametrize(
    "name", ["{}:Robot+noise", "turn-left+motion={}:Motion", "turn-left+motion={}:Motion+slip=0.1"]
)
def test_options_bring_no_code_of_a_file_along(gate, folder, name):
    with page_of(gate) as page:
        (part,) = run(page, [name.format(folder / "evil.py")])
    assert "error" in part and "run" not in part and not (folder / "ran").exists()


@in_a_browser
def test_a_robot_with_options_is_added_by_its_words(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("300")
        page.get_by_label("Another robot, with options").fill("thesis-2+repaired")
        page.keyboard.press("Enter")
        assert page.get_by_role("checkbox", name="thesis-2+repaired").is_checked()
        page.keyboard.press("Control+Enter")
        page.locator(".result").nth(1).wait_for()
        assert [name.split()[1] for name in page.locator(".result").all_inner_texts()] == [
            "thesis-2",
            "thesis-2+repaired",
        ]
        assert page.complaints == []


@in_a_browser
def test_run_can_be_pressed_whenever_a_robot_is_chosen(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.locator(".robots input:checked").click()
        assert page.locator("#run").is_disabled()
        page.get_by_label("Motion model").first.select_option("swept")  # one of this model's is chosen
        assert page.locator(".robots input:checked").count() == 1 and page.locator("#run").is_enabled()


@pytest.mark.parametrize("wrong", ["nope", "thesis-1+foo=3", "./evil.py:X", "thesis-1+motion=./evil.py:X"])
def test_what_is_no_robot_is_refused_when_it_is_added(gate, wrong):
    ask = {"motion": "stepped", "time_step": 0.015, "seed": 0, "options": {}}
    with page_of(gate) as page:
        assert "error" in page.ask("check", controller=wrong, **ask)
        assert page.ask("check", controller="thesis-1+repaired", **ask)["answer"] == {}
        assert page.ask("check", controller="turn-right+slip=0.1", **ask | {"motion": "swept"})["answer"] == {}


@in_a_browser
def test_numbers_and_robots_that_cannot_be_are_refused_at_their_fields(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.get_by_label("Another robot, with options").fill("nope")
        page.keyboard.press("Enter")
        page.locator("#another-fault", has_text="'nope'").wait_for()
        assert page.get_by_role("checkbox", name="nope").count() == 0
        page.locator(".result").first.wait_for()
        before = page.locator(".result").all_inner_texts()
        for name, values in (("Steps", ["0", "-5", "1.5"]), ("Seed", ["", "1e30"]), ("Time step s", ["", "0"])):
            field = page.locator("#play").get_by_label(name, exact=True)
            for value in values:
                field.fill(value)
                page.keyboard.press("Tab")
                page.locator(f"#{field.get_attribute('id')}-fault").wait_for()
            field.fill("1")
        assert page.locator(".result").all_inner_texts() == before
