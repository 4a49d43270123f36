"""The studio's page in a browser, with real mouse and keyboard."""

import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sim.episode import simulate
from sim.run_options import RunOptions
from tests.helpers.browser import missing_browser
from tests.helpers.studio import studio_of
from worldgen.grid_file import read_world
from worldgen.reach import decide

pytest.importorskip("playwright", reason="no playwright here: the studio is not tested in a browser")
pytestmark = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

from tests.helpers.studio_page import chromium_browser, drag, opened, place, solid_cells  # noqa: E402

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"
FAILURE = CONFIG_5.parents[1] / "thesis-faults/thesis-1-loop-104.grid"
BORDER = 156  # solid cells of an empty world of 40 x 40


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio")
    shutil.copy(CONFIG_5, folder / "config-05.grid")
    return folder


@pytest.fixture(scope="module")
def gate(folder):
    with studio_of(folder) as gate:
        yield gate


@pytest.fixture(scope="module")
def browser():
    with chromium_browser() as browser:
        yield browser


@pytest.fixture
def page(browser, gate):
    with opened(browser, gate) as page:
        yield page


def draw_configuration_5(page):
    """The thesis's configuration 5, by hand: a wall, the start with its heading, the target."""
    page.keyboard.press("r")
    drag(page, (5, 14), (36, 13))
    page.keyboard.press("a")
    page.mouse.click(*place(page, 3.5, 36.5))
    page.get_by_label("Heading").fill("-77.83")
    page.get_by_label("Heading").press("Enter")
    page.keyboard.press("Escape")
    page.locator("#board").focus()
    page.keyboard.press("g")
    page.mouse.click(*place(page, 27.5, 6.5))


def test_configuration_5_drawn_by_hand_loops_is_saved_and_replays_the_same_digest(page, folder):
    draw_configuration_5(page)
    page.keyboard.press("2")
    result = page.locator(".result[data-controller=thesis-2]")
    assert "loop" in result.inner_text() and "every 104 steps" in result.inner_text()
    assert page.get_by_role("button", name="One period").count() == 1
    assert "period 104" in page.locator("#instruments").inner_text()
    digest = page.locator(".digest").inner_text()
    page.keyboard.press("1")
    page.keyboard.press("Control+s")
    page.keyboard.type("mine")
    page.keyboard.press("Enter")
    page.get_by_text("Saved mine.grid").wait_for()
    drawn = read_world(folder / "mine.grid")
    assert (drawn.walls == read_world(CONFIG_5).walls).all()
    assert simulate(drawn, "thesis-2", RunOptions("stepped", 20_000)).trace_digest == digest
    page.reload()
    page.locator("#name", has_text="mine.grid").wait_for()
    page.keyboard.press("2")
    assert page.locator(".digest").inner_text() == digest
    assert page.complaints == []


def test_every_stroke_is_undone_and_done_again(page):
    drag(page, (5, 5), (9, 5))
    page.keyboard.press("l")
    drag(page, (5, 10), (5, 19))
    assert solid_cells(page) == BORDER + 15
    page.keyboard.press("Control+z")
    assert solid_cells(page) == BORDER + 5
    page.keyboard.press("Control+z")
    assert solid_cells(page) == BORDER
    page.keyboard.press("Control+y")
    page.keyboard.press("Control+Shift+Z")
    assert solid_cells(page) == BORDER + 15


def test_the_right_button_erases(page):
    drag(page, (5, 5), (9, 5))
    drag(page, (6, 5), (8, 5), button="right")
    assert solid_cells(page) == BORDER + 2


def test_a_selection_is_moved_turned_and_copied(page):
    drag(page, (5, 5), (9, 5))
    page.keyboard.press("s")
    drag(page, (4, 4), (10, 6))
    drag(page, (5, 5), (5, 15))
    page.keyboard.press(".")
    page.keyboard.press("Control+c")
    page.keyboard.press("Control+v")
    page.mouse.click(*place(page, 25, 25))
    assert solid_cells(page) == BORDER + 10


def test_a_stamp_and_a_fill_put_down_cells(page):
    page.keyboard.press("t")
    page.mouse.click(*place(page, 20, 20))
    stamped = solid_cells(page)
    page.keyboard.press("f")
    page.mouse.click(*place(page, 5, 20))
    assert stamped > BORDER + 20 and solid_cells(page) == 1600


def test_the_board_is_drawn_on_with_the_keyboard_alone(page):
    page.locator("#board").focus()
    for key in ("Space", "ArrowRight", "Space", "Shift+ArrowUp", "Space"):
        page.keyboard.press(key)
    assert solid_cells(page) > BORDER


def test_a_wall_across_is_told_with_its_cut_and_a_way_with_its_clearance(page):
    page.keyboard.press("l")
    drag(page, (0, 20), (39, 20))
    page.locator("#proof.bad").wait_for()
    assert "ring of" in page.locator("#proof").inner_text()
    page.keyboard.press("e")
    page.mouse.click(*place(page, 10.5, 20.5))
    page.locator("#proof.bad").wait_for()
    drag(page, (10, 20), (11, 20))
    page.locator("#proof.good", has_text="radius up to").wait_for()


def test_the_radius_slider_shows_where_the_way_closes(page):
    page.locator("#widest", has_text="closes for a radius above").wait_for()
    page.locator("#radius").focus()
    page.keyboard.press("End")
    page.locator("#proof.bad").wait_for()


def test_a_generated_world_is_shown_and_can_be_taken_back(page):
    page.locator("#tab-maker").click()
    page.get_by_role("button", name="Generate", exact=True).click()
    page.get_by_text("Made by maze, version 1, seed 1.").wait_for()
    page.keyboard.press("Control+z")
    assert solid_cells(page) == BORDER


def test_robots_of_several_colours_drive_in_what_is_drawn_at_once(page):
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    page.get_by_label("thesis-1").check()
    page.keyboard.press("Control+Enter")
    page.locator(".result").nth(1).wait_for()
    assert page.locator(".chip").count() == 2
    page.keyboard.press("Home")
    page.locator("#play").get_by_role("button", name="Play", exact=True).click()
    page.locator("#readout", has_text=re.compile(r"step [1-9]")).wait_for()
    assert page.complaints == []


def test_an_export_is_what_the_library_writes(page):
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.get_by_label("Export as").select_option("thesis")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert Path(download.value.path()).stat().st_size > 100


def test_a_file_that_is_dropped_on_the_page_becomes_the_world(page, tmp_path):
    (tmp_path / "drawing.txt").write_text("#########\n#S......#\n#.......#\n#.......#\n#......G#\n#########\n")
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.get_by_label("Import a map").set_input_files(tmp_path / "drawing.txt")
    page.get_by_text("Imported drawing.txt.").wait_for()
    assert "9 x 6 cells" in page.locator(".status .place").inner_text()


def test_a_page_without_the_token_gets_nothing(browser, gate):
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(gate.address.partition("?")[0])
        assert "does not know you" in page.inner_text("body")


def start_studio(folder, *port):
    """A studio in a process of its own, at that port or at one that it finds; gives it with its address."""
    command = [sys.executable, "-m", "worldgen", "studio", str(folder), "--no-browser", *port]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    return process, process.stderr.readline().split()[-1]


def test_a_killed_server_loses_nothing_and_the_page_says_so(browser, tmp_path):
    process, address = start_studio(tmp_path)
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(address)
        page.locator("#proof.good").wait_for()
        page.locator("#board").focus()
        page.keyboard.press("Space")
        page.keyboard.press("Space")
        process.send_signal(signal.SIGKILL)
        process.wait()
        page.get_by_text("The studio does not answer.").wait_for()
        again, address = start_studio(tmp_path, "--port", address.partition("/?")[0].rpartition(":")[2])
        page.get_by_text("was started anew").wait_for()
        page.goto(address)
        page.locator("#proof.good").wait_for()
        assert solid_cells(page) == BORDER + 1
        again.send_signal(signal.SIGINT)
        assert again.wait(timeout=60) == 0
    process.stderr.close(), again.stderr.close()


def test_the_way_on_the_board_is_the_library_s(page):
    world = read_world(CONFIG_5)
    page.locator("#tab-files").click()
    page.locator(".file", has_text="config-05.grid").click()
    length = decide(world).certificate.length
    page.locator("#proof.good", has_text=f"{length:.2f} m").wait_for()


def test_a_failure_s_file_brings_its_controller_and_replays_to_its_digest(page, folder):
    shutil.copy(FAILURE, folder / "failure.grid")
    page.locator("#tab-files").click()
    page.locator(".file", has_text="failure.grid").click()
    page.get_by_text("Opened failure.grid").first.wait_for()
    page.keyboard.press("2")
    assert page.locator(".digest").inner_text() == read_world(FAILURE).failure.trace_digest


def test_undo_after_opening_brings_the_drawing_back_and_its_name(page):
    drag(page, (5, 5), (9, 5))
    page.locator("#tab-files").click()
    page.locator(".file", has_text="config-05.grid").click()
    page.locator("#name", has_text="config-05.grid").wait_for()
    page.keyboard.press("Control+z")
    page.locator("#name", has_text="not saved yet").wait_for()
    assert solid_cells(page) == BORDER + 5


def test_how_hard_it_is_is_measured(page):
    page.locator("#measure").click()
    page.get_by_role("row", name="Detour").wait_for()


def test_a_finger_draws_and_a_second_one_takes_that_back(browser, gate):
    with opened(browser, gate, viewport={"width": 1024, "height": 768}, has_touch=True) as page:
        page.touchscreen.tap(*place(page, 10.5, 10.5))
        assert solid_cells(page) == BORDER + 1
        fingers = [{"x": x, "y": y} for x, y in (place(page, 20, 20), place(page, 24, 20))]
        touch = page.context.new_cdp_session(page)
        touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": fingers[:1]})
        touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": fingers})
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        assert solid_cells(page) == BORDER + 1


def test_the_eraser_s_right_button_draws(page):
    page.keyboard.press("e")
    drag(page, (5, 5), (9, 5), button="right")
    assert solid_cells(page) == BORDER + 5


def test_another_robot_is_looked_at_at_the_same_time(page):
    page.keyboard.press("2")
    page.locator(".result").wait_for()
    page.get_by_label("thesis-1").check()
    page.get_by_label("Steps", exact=True).fill("40")
    page.keyboard.press("Control+Enter")
    page.locator(".result", has_text="40 steps").nth(1).wait_for()
    page.locator("#stage").click()
    page.keyboard.press("Home")
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    page.locator(".result").nth(1).click()
    page.locator("#readout", has_text="step 30 of").wait_for()
    page.locator(".result[data-controller=thesis-1]").and_(page.locator("[aria-current] > .result")).wait_for()
