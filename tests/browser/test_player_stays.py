"""The player keeps its place while a run plays, and its verdicts can be read."""

from pathlib import Path

import pytest

from fuzz.player import drawn_world, replay_page
from fuzz.report import write_report
from sim.verdict import Verdict
from tests.browser.test_player_page import driven, open_replay, room, thesis_failure
from tests.helpers.accessibility import complaints
from tests.helpers.browser import page_in
from tests.helpers.campaign_folder import campaign_folder
from tests.helpers.layout_shift import shifts

AXE = Path(__file__).parents[2] / "node_modules" / "axe-core" / "axe.min.js"
NUMBERS = ("mapper", "bug2", "three-layer", "scan-mapper")  # controllers that show their memory


@pytest.mark.gate
@pytest.mark.parametrize("width", [1280, 900, 400])
@pytest.mark.parametrize("controller", ["mapper", "thesis-1"])
def test_nothing_moves_while_a_run_plays(browser, tmp_path, controller, width):
    world, name, settings = room(2.0), controller, {}
    if controller == "thesis-1":  # a loop, whose words change in its period
        world, name, settings = thesis_failure("thesis-1-loop-104.grid")
    robot, _ = driven(world, name, **settings)
    with page_in(browser, viewport={"width": width, "height": 1000}) as page:
        open_replay(page, tmp_path, world, robot)
        page.wait_for_selector("#scrub")
        moved = shifts(page)
        assert moved["moved"] == [] and len(moved["heights"]) == 1


@pytest.mark.nightly
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("controller", NUMBERS)
def test_axe_finds_nothing_in_a_player_that_shows_numbers(browser, tmp_path, controller, scheme):
    robot, _ = driven(room(2.0), controller)
    with page_in(browser, color_scheme=scheme, viewport={"width": 1280, "height": 1000}) as page:
        open_replay(page, tmp_path, room(2.0), robot)
        page.wait_for_selector("#scrub")
        assert shifts(page)["moved"] == []
        assert axe(page) == [] and complaints(page) == []


@pytest.mark.nightly
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_for_any_verdict(browser, tmp_path, scheme):
    robot, _ = driven(room(2.0), "bug2")
    path = tmp_path / "replay.html"
    robots = [robot | {"verdict": one.value, "name": f"robot-{one.value}"} for one in Verdict]
    path.write_bytes(replay_page("verdicts", drawn_world(room(2.0)), robots))
    with page_in(browser, color_scheme=scheme) as page:
        page.goto(path.as_uri())
        page.locator(".robots button").nth(len(robots) - 1).wait_for()
        assert axe(page) == [] and complaints(page) == []


def axe(page):
    """Return what axe finds, as sentences."""
    if not AXE.exists():
        pytest.skip("no axe-core: npm ci")
    page.evaluate(AXE.read_text("utf-8"))
    found = page.evaluate("axe.run().then((result) => result.violations)")
    return [
        f"{one['id']}: {one['nodes'][0]['html']} {one['nodes'][0]['failureSummary']}"
        for one in found
    ]


@pytest.mark.nightly
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_report_s_headline_can_be_read_for_every_verdict(browser, tmp_path, scheme):
    write_report([campaign_folder(tmp_path / "failures")], tmp_path / "report.html")
    with page_in(browser, color_scheme=scheme) as page:
        page.goto((tmp_path / "report.html").as_uri())
        found = {}
        for verdict in Verdict:
            page.locator(".headline").first.evaluate(
                "(line, verdict) => (line.dataset.verdict = verdict)", verdict.value
            )
            found[verdict.value] = axe(page) + complaints(page)
        assert {verdict: said for verdict, said in found.items() if said} == {}
