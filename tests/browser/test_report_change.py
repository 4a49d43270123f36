"""Changing a failure's world in a report that is opened from disk: the core in the page judges it."""

from dataclasses import replace

import numpy as np
import pytest

from fuzz.failure import Failure
from fuzz.player.live import live_core
from fuzz.report import write_report
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.scenario import Scenario
from tests.helpers.accessibility import complaints
from tests.helpers.browser import expect, page_in
from worldgen.files.grid import read_world
from worldgen.reach import check_certificate, decide
from worldgen.world import Pose, Robot, Target, World

pytestmark = [
    pytest.mark.gate,
    pytest.mark.skipif(live_core() is None, reason="this installation has no core for pages"),
]

# A wall between start and target, and a closed room in the upper right corner.
ROWS = """
...........#..
...........#..
...........#..
...........###
..............
......###.....
........#.....
..S.....#...G.
........#.....
......###.....
..............
"""
WALL = (8, 3)  # without this cell, the robot arrives
ROOM = (12, 9)

# Counts workers from the start, and how far the page has jumped.
WATCH = """
  globalThis.workers = 0;
  globalThis.Worker = class extends Worker { constructor(...given) { super(...given); workers += 1; } };
  globalThis.shift = 0;
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) shift += entry.value;
  }).observe({ type: "layout-shift", buffered: true });
"""

PYTHON = """
from sim import Command

class Slow:
    def reset(self):
        return (0.0,)
    def act(self, observation, memory):
        return Command(observation.top_speed / 2, 0.0), memory
"""


def room():
    walls = np.array([[letter == "#" for letter in row] for row in reversed(ROWS.split())])
    world = World(
        walls, Pose(0.25, 0.35, 0.0), Target(1.25, 0.35, 0.05), cell_size=0.1, robot_radius=0.04
    )
    return replace(world, certificate=decide(world).certificate)


def write_failure(folder, controller, world=None):
    failure = failure_of(world or room(), Scenario.parse(controller))
    failure.write(folder / "loop.grid")
    write_report([folder], folder / "report.html")
    return (folder / "report.html").as_uri(), failure


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return write_failure(tmp_path_factory.mktemp("change"), "turn-right")


@pytest.fixture
def page(browser, report):
    """The failure in the report, just opened."""
    with failure_in(browser, *report) as page:
        yield page


def failure_in(browser, address, failure, script="", **how):
    context = page_in(browser, accept_downloads=True, **how)

    class Opened:
        def __enter__(self):
            page = context.__enter__()
            page.add_init_script(WATCH + script)
            page.goto(f"{address}#{failure.digest[:12]}")
            page.locator("#stage").wait_for()
            return page

        def __exit__(self, *given):
            return context.__exit__(*given)

    return Opened()


def begin(page, verdict="loop"):
    page.locator("#change").click()
    page.locator("#change-verdict b", has_text=verdict).wait_for()
    page.locator("#board").wait_for()


def place(page, x, y, size=(14, 11)):
    """Return where a point of the world, in cells, is in the window."""
    box = page.locator("#board").bounding_box()
    edge, bar = 16, 18
    width, height = size
    scale = min((box["width"] - 2 * edge) / width, (box["height"] - 2 * edge - bar) / height)
    return (
        box["x"] + box["width"] / 2 + (x - width / 2) * scale,
        box["y"] + box["height"] / 2 - (y - (height / 2 - bar / 2 / scale)) * scale,
    )


def drag(page, first, last, size=(14, 11)):
    page.mouse.move(*place(page, first[0] + 0.5, first[1] + 0.5, size))
    page.mouse.down()
    page.mouse.move(*place(page, last[0] + 0.5, last[1] + 0.5, size), steps=12)
    page.mouse.up()


def saved(page, tmp_path):
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as .grid").click()
    path = tmp_path / download.value.suggested_filename
    download.value.save_as(path)
    return read_world(path)


def copied(page):
    """The text of the changed world's test; a page from disk has no clipboard that it may read."""
    page.evaluate("navigator.clipboard.writeText = async (text) => { globalThis.text = text; }")
    page.locator(".change").get_by_role("button", name="Copy test").click()
    page.locator(".change").get_by_text("Copied").wait_for()
    return page.evaluate("text")


def outcome(text):
    """Return what a copied test says: nothing if it passes."""
    module = {}
    exec(compile(text, "copied", "exec"), module)
    (test,) = [value for name, value in module.items() if name.startswith("test_")]
    try:
        test()
    except AssertionError as error:
        return str(error) or "failed"
    return ""


def test_without_a_wall_the_robot_arrives_and_the_copied_test_passes(page, tmp_path):
    begin(page)
    drag(page, WALL, WALL)
    page.locator("#change-verdict b", has_text="reached").wait_for()
    page.locator("#change-proof.good").wait_for()
    world = saved(page, tmp_path)
    walls = room().walls.copy()
    walls[WALL[1], WALL[0]] = False
    assert (world.walls == walls).all() and world.failure is None
    assert check_certificate(world).valid
    assert outcome(copied(page)) == ""
    assert page.complaints == []


def test_the_copied_test_of_a_robot_that_still_fails_fails(page, tmp_path):
    begin(page)
    drag(page, (8, 2), (8, 2))
    page.locator("#change-verdict", has_text="loop forever").wait_for()
    assert outcome(copied(page)) == "failed"


def test_a_changed_world_in_which_the_robot_stalls_is_saved_as_a_failure_that_replays(
    browser, tmp_path
):
    address, failure = write_failure(tmp_path, "turn-right+slip=0.1")
    with failure_in(browser, address, failure) as page:
        begin(page, failure.verdict)
        drag(page, (4, 8), (4, 8))
        page.locator("#change-verdict b", has_text="stalled").wait_for()
        world = saved(page, tmp_path)
    assert replay(Failure.of(world)).confirmed


def test_a_target_in_a_closed_room_is_proved_to_be_out_of_reach(page, tmp_path):
    begin(page)
    page.locator("#change-proof.good").wait_for()
    before = page.evaluate("shift")
    drag(page, (12, 3), ROOM)
    page.locator("#change-proof.bad", has_text="blocked").wait_for()
    page.locator("#detail .legend li", has_text="cut: every gap").wait_for()
    assert page.evaluate("shift") == before
    world = saved(page, tmp_path)
    assert (world.target.x, world.target.y) == (1.25, 0.95)
    assert check_certificate(world).valid and world.failure is None
    assert outcome(copied(page)) == ""  # the robot stays out
    page.get_by_role("button", name="Undo").click()
    page.locator("#change-proof.good").wait_for()


def test_the_start_its_heading_and_the_radius_can_be_changed_and_reset(page, tmp_path):
    begin(page)
    drag(page, (2, 3), (3, 5))
    page.keyboard.press("a")
    page.locator("#board").focus()
    page.get_by_label("Robot radius, m").fill("0.03")
    page.get_by_label("Robot radius, m").press("Enter")
    world = saved(page, tmp_path)
    assert (world.start.x, world.start.y, world.robot_radius) == (0.35, 0.55, 0.03)
    page.get_by_role("button", name="Reset").click()
    page.locator("#change-verdict b", has_text="loop").wait_for()
    expect(page.get_by_role("button", name="Reset")).to_be_disabled()


def test_keys_can_do_it_all(page, tmp_path):
    begin(page)
    said = page.locator("#said")
    said.filter(has_text="loop forever").wait_for(state="attached")
    page.locator("#board").focus()
    page.keyboard.press("ArrowRight")  # shows the cursor, in the middle, and moves it
    for key in ["ArrowDown"] * 2:
        page.keyboard.press(key)
    here = page.locator("#said").text_content()
    page.keyboard.press("Space")
    changed = saved(page, tmp_path)
    ix, iy = map(int, here.split(":")[0].split(", "))
    assert changed.walls[iy, ix] != room().walls[iy, ix]
    page.locator("#board").focus()
    said.evaluate(
        "element => { element.textContent = ''; }"
    )  # only what is said from now on counts
    page.keyboard.press("Control+z")
    assert (saved(page, tmp_path).walls == room().walls).all()
    said.filter(has_text="loop forever").wait_for(state="attached")
    page.locator("#board").focus()
    page.keyboard.press("ArrowUp")
    ix, iy = map(int, said.text_content().split(":")[0].split(", "))
    page.keyboard.press("g")
    page.keyboard.press("Space")
    world = saved(page, tmp_path)
    assert (int(world.target.x * 10), int(world.target.y * 10)) == (ix, iy)
    page.locator("#board").focus()
    page.keyboard.press("Escape")
    page.locator("#change", has_text="Change it").wait_for()


def test_what_was_changed_stays_when_the_editor_is_closed(page):
    begin(page)
    drag(page, WALL, WALL)
    page.locator("#change-verdict b", has_text="reached").wait_for()
    page.locator("#change").click()
    page.locator("#stage").wait_for()
    begin(page, "reached")


def test_the_core_is_loaded_when_it_is_first_used_and_only_once(page):
    page.wait_for_timeout(300)
    assert page.evaluate("workers") == 0
    begin(page)
    page.locator("#change").click()
    begin(page)
    assert page.evaluate("workers") == 1


@pytest.mark.parametrize("missing", ["WebAssembly", "Worker", "DecompressionStream"])
def test_a_browser_without_what_the_core_needs_shows_no_button(browser, report, missing):
    with failure_in(browser, *report, script=f"delete globalThis.{missing};") as page:
        page.locator("#play-pause").wait_for()
        expect(page.locator("#change")).to_have_count(0)
        assert page.complaints == []


def test_the_recording_of_a_python_controller_stays_and_the_proof_is_live(browser, tmp_path):
    (tmp_path / "slow.py").write_text(PYTHON)
    address, failure = write_failure(tmp_path, f"{tmp_path / 'slow.py'}:Slow")
    with failure_in(browser, address, failure) as page:
        begin(page, failure.verdict)
        page.locator(".change-answer", has_text="the run is the recording").wait_for()
        drag(page, (12, 3), ROOM)
        page.locator("#change-proof.bad", has_text="blocked").wait_for()
        page.get_by_role("button", name="Undo").click()
        page.locator("#change-proof.good").wait_for()
        drag(page, (4, 3), (4, 3))
        page.locator("#change-proof.good").wait_for()
        assert outcome(copied(page)) == "failed"


@pytest.mark.parametrize("size", [{"width": 1280, "height": 800}, {"width": 400, "height": 800}])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_editor_has_no_barriers(browser, report, size, scheme):
    with failure_in(browser, *report, viewport=size, color_scheme=scheme) as page:
        begin(page)
        assert complaints(page) == []


def test_the_editor_of_a_body_has_no_radius(browser, tmp_path):
    box = ((0.06, 0.04), (-0.06, 0.04), (-0.06, -0.04), (0.06, -0.04))
    world = room()
    world = replace(world, robots=[replace(world.robots[0], footprint=box)], certificate=None)
    failure = failure_of(
        replace(world, certificate=decide(world).certificate), Scenario.parse("turn-right")
    )
    failure.write(tmp_path / "loop.grid")
    write_report([tmp_path], tmp_path / "report.html")
    with failure_in(browser, (tmp_path / "report.html").as_uri(), failure) as page:
        begin(page, failure.verdict)
        expect(page.get_by_label("Robot radius, m")).to_be_hidden()
        page.locator("#change-proof.good", has_text="reachable").wait_for()
        assert Failure.of(saved(page, tmp_path)) == failure
        shown = page.locator("pre.test").text_content()
        assert copied(page) == shown
        assert page.complaints == []


def test_a_passage_in_which_a_body_cannot_turn_is_closed_by_a_cut_of_poses(browser, tmp_path):
    walls = np.ones((12, 12), bool)
    walls[1:4, 1:4] = walls[4:7, 6:9] = walls[8:11, 1:11] = walls[4:8, 8] = False
    walls[4, 1:9] = False
    long = ((0.13, 0.04), (-0.06, 0.04), (-0.06, -0.04), (0.13, -0.04))
    robot = Robot(Pose(0.25, 0.25, 1.5), Target(0.6, 1.0, 0.05), footprint=long)
    world = World(walls, cell_size=0.1, robots=[robot])
    world = replace(world, certificate=decide(world).certificate)
    address, failure = write_failure(tmp_path, "turn-right", world)
    with failure_in(browser, address, failure) as page:
        begin(page, failure.verdict)
        page.locator("#change-proof.good").wait_for()
        page.locator("#board").focus()
        page.keyboard.press("b")
        drag(page, (7, 5), (7, 6), size=(12, 12))
        drag(page, (6, 5), (6, 6), size=(12, 12))
        page.locator("#change-proof.bad", has_text="runs of poses").wait_for()
        page.locator("#detail .legend li", has_text="no heading fits").wait_for()
        changed = saved(page, tmp_path)
        assert changed.certificate.boxes is not None and check_certificate(changed).valid
        assert outcome(copied(page)) == ""


def test_waypoints_are_proved_one_after_the_other(browser, tmp_path):
    world = room()
    goals = (Target(0.45, 0.85, 0.05), Target(0.95, 0.85, 0.02))
    world = replace(world, robots=[replace(world.robots[0], waypoints=goals)])
    world = replace(world, certificate=decide(world).certificate)
    address, failure = write_failure(tmp_path, "turn-left", world)
    with failure_in(browser, address, failure) as page:
        begin(page, failure.verdict)
        page.locator("#change-proof.good").wait_for()
        page.locator("#detail .legend li", has_text="waypoint").wait_for()
        drag(page, (4, 4), (4, 4))
        page.locator("#change-proof.good").wait_for()
        assert check_certificate(saved(page, tmp_path)).valid
