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
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, opened, place, solid_cells
from worldgen import generate
from worldgen.grid_file import read_world, write_world
from worldgen.reach import decide

pytestmark = pytest.mark.gate

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
    page.locator("#proof.good", has_text="clearance of the way").wait_for()


def test_the_board_stays_where_it_is_whatever_the_proof_says(page):
    page.locator("#proof.good").wait_for()
    before = page.locator("#board").bounding_box()
    page.keyboard.press("l")
    drag(page, (0, 20), (39, 20))
    page.locator("#proof.bad", has_text="every gap too narrow").wait_for()
    assert page.locator("#board").bounding_box() == before


def test_saving_a_nameless_world_while_playing_leads_at_once_to_its_name(page):
    page.keyboard.press("2")
    page.locator("#play").wait_for()
    focused = page.evaluate("""() => {
      document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "s", ctrlKey: true, bubbles: true }));
      return document.activeElement.id;
    }""")
    assert focused == "save-name"


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


def test_the_generator_shows_a_family_s_bounds_and_does_not_send_what_is_outside(page):
    page.locator("#tab-maker").click()
    page.get_by_text("Cells a side, the solid border included. 10 to 20000 cells.").wait_for()
    page.get_by_role("spinbutton", name="Size", exact=True).fill("9")
    assert page.get_by_role("spinbutton", name="Size", exact=True).get_attribute("aria-invalid") == "true"
    page.get_by_role("button", name="Generate", exact=True).click()
    page.get_by_text("Size is a whole number, 10 to 20000 cells.").wait_for()
    page.get_by_role("spinbutton", name="Size", exact=True).fill("12")
    page.get_by_role("button", name="Generate", exact=True).click()
    page.get_by_text("Made by maze, version 1, seed 1.").wait_for()
    page.locator(".status .place", has_text="12 x 12 cells").wait_for()  # drawn a frame later


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
        assert again.wait(timeout=180) == 0
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


def test_a_failure_s_seed_and_steps_go_with_it_when_another_world_is_opened(page, folder):
    shutil.copy(FAILURE, folder / "failure.grid")
    failure = read_world(FAILURE).failure
    page.locator("#tab-files").click()
    numbers = {}
    for name in ("failure.grid", "config-05.grid"):
        page.locator(".file", has_text=name).click()
        page.locator("#name", has_text=name).wait_for()
        page.keyboard.press("2")
        fields = (page.locator("#play").get_by_label(label, exact=True) for label in ("Seed", "Steps"))
        numbers[name] = tuple(field.input_value() for field in fields)
        page.keyboard.press("1")
    assert numbers["failure.grid"] == (str(failure.seed), str(failure.parameters["steps"]))
    assert numbers["config-05.grid"] == ("0", "20000")


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


def test_a_file_that_another_program_has_changed_is_not_overwritten_unasked(page, folder):
    shutil.copy(CONFIG_5, folder / "shared.grid")
    page.locator("#tab-files").click()
    page.locator(".file", has_text="shared.grid").click()
    page.locator("#name", has_text="shared.grid").wait_for()
    drag(page, (5, 5), (9, 5))
    page.locator("#name", has_text="changed").wait_for()
    page.keyboard.press("Control+s")
    page.locator("#name", has_text=re.compile("grid$")).wait_for()
    shutil.copy(FAILURE, folder / "shared.grid")
    drag(page, (5, 8), (9, 8))
    page.locator("#name", has_text="changed").wait_for()
    asked = []
    page.once("dialog", lambda dialog: (asked.append(dialog.message), dialog.dismiss()))
    page.keyboard.press("Control+s")
    page.locator("#said", has_text="shared.grid is as it was").wait_for(state="attached")
    assert "another program" in asked[0] and (folder / "shared.grid").read_bytes() == FAILURE.read_bytes()


def test_each_drag_of_the_target_is_undone_alone_and_a_tool_taken_while_drawing_waits(page):
    page.keyboard.press("g")
    drag(page, (30, 30), (20, 20))
    drag(page, (20, 20), (10, 10))
    page.keyboard.press("Control+z")
    target = page.get_by_role("group", name="Target").get_by_role("spinbutton").first
    page.wait_for_function("(field) => field.value === '2.05'", arg=target.element_handle())
    page.keyboard.press("b")
    page.mouse.move(*place(page, 5.5, 30.5))
    page.mouse.down()
    page.keyboard.press("l")
    page.mouse.move(*place(page, 9.5, 30.5), steps=3)
    page.mouse.up()
    assert solid_cells(page) == BORDER + 5 and page.complaints == []


def darkness(page, x, y):
    """How dark the board is at a point of the world, in cells: 0 to 255."""
    box = page.locator("#board").bounding_box()
    across, down = place(page, x, y)
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.evaluate(
        "([x, y]) => 255 - document.getElementById('board').getContext('2d').getImageData(x, y, 1, 1).data[0]",
        [round(across - box["x"]), round(down - box["y"])],
    )


def test_in_a_world_of_two_million_cells_all_that_is_drawn_is_seen_decided_and_undone(page):
    page.get_by_label("Columns").first.fill("2000")
    page.get_by_label("Rows").first.fill("1000")
    page.get_by_role("button", name="New").click()
    page.keyboard.press("r")
    seen = [darkness(page, 600, 500)]
    acts = {
        "rectangle": lambda: drag(page, (400, 300), (800, 700)),
        "fill": lambda: (page.keyboard.press("f"), page.mouse.click(*place(page, 200, 200))),
        "undone fill": lambda: page.keyboard.press("Control+z"),
        "undone rectangle": lambda: page.keyboard.press("Control+z"),
    }
    for act in acts.values():
        act()
        seen.append((darkness(page, 600, 500), darkness(page, 200, 800)))
        page.locator("#proof.good, #proof.bad").wait_for()
    free, wall = seen[0], seen[1][0]
    assert wall > free + 100
    assert seen[1:] == [(wall, free), (wall, wall), (wall, free), (free, free)]
    assert [one for one in page.complaints if "readback" not in one] == []  # that one is of this test's own looking


def test_each_tab_keeps_its_own_drawing_and_a_new_one_goes_on_with_that_of_a_closed_one(browser, gate, folder):
    with opened(browser, gate) as first:
        drag(first, (5, 5), (9, 5))
        second = first.context.new_page()
        second.goto(gate.address)
        second.locator("#proof.good").wait_for()
        assert solid_cells(second) == BORDER
        second.keyboard.press("Control+s")
        second.keyboard.type("second")
        second.keyboard.press("Enter")
        second.get_by_text("Saved second.grid").wait_for()
        second.close(run_before_unload=True)
        first.reload()
        assert solid_cells(first) == BORDER + 5
        third = first.context.new_page()
        first.close(run_before_unload=True)
        third.goto(gate.address)
        assert solid_cells(third) == BORDER + 5
        assert (folder / "second.grid").is_file()


def test_a_controller_named_at_the_start_that_cannot_be_loaded_is_told_with_its_fault(browser, folder):
    with studio_of(folder, named=["./misspelt.py:Robot"]) as gate, opened(browser, gate) as page:
        told = page.locator("#gone")
        told.get_by_text("misspelt.py").wait_for()
        assert "Named at the start, but cannot run" in told.inner_text() and "no such file" in told.inner_text()
        told.get_by_role("button", name="Close").click()
        assert not told.is_visible()
        assert page.complaints == []


def test_no_difficulty_can_be_wished_of_a_family_whose_worlds_change(page):
    page.get_by_role("tab", name="Generate").click()
    page.get_by_text("Search for a world as hard as wished").click()
    difficulty = page.get_by_label("Difficulty, 0 to 1")
    difficulty.fill("0.8")
    page.get_by_label("Family").select_option("fire")
    assert difficulty.is_disabled() and difficulty.input_value() == ""
    page.get_by_label("Family").select_option("maze")
    assert difficulty.is_enabled()


def test_a_world_grows_where_it_does_not_stay_down_to_one_row_and_up_to_four_million_cells(page):
    drag(page, (5, 5), (9, 5))
    drawn = solid_cells(page)
    page.get_by_label("Upper right").check()
    page.get_by_label("Columns").first.fill("44")
    page.get_by_label("Rows").first.fill("30")
    page.get_by_role("button", name="Resize").click()
    page.locator("#place", has_text="44 x 30 cells").wait_for()
    assert solid_cells(page) == drawn - 40 - 2 * 9 - 5  # below, the border and the stroke are gone
    assert page.get_by_label("x m").first.input_value() == "0.65"  # the start has moved with its cells
    for sides, words in ((("50", "1"), "50 x 1 cells"), (("20000", "209"), "20000 x 209 cells")):
        for label, side in zip(("Columns", "Rows"), sides, strict=True):
            page.get_by_label(label).first.fill(side)
        page.get_by_role("button", name="New").click()
        page.locator("#place", has_text=words).wait_for()
        page.locator("#proof.good, #proof.bad").wait_for()
    page.get_by_label("Columns").first.fill("20001")
    page.get_by_role("button", name="Resize").click()
    page.get_by_text("at most 4,194,304 cells in all").wait_for()
    assert page.complaints == []


def test_a_schedule_that_is_cleared_away_is_told_and_undo_brings_it_back(page, folder):
    write_world(generate("fire", 3), folder / "fire.grid")
    page.locator("#tab-files").click()
    page.locator(".file", has_text="fire.grid").click()
    page.locator("#place", has_text="changes").wait_for()
    page.locator("#tab-world").click()
    page.get_by_role("button", name="Clear").click()
    page.locator("#size-said", has_text="does not change any more: undo brings").wait_for()
    page.locator("#place:not(:has-text('changes'))").wait_for()
    page.keyboard.press("Control+z")
    page.locator("#place", has_text="changes").wait_for()


def test_play_and_campaign_begin_with_the_controller_that_was_named_at_the_start(browser, tmp_path):
    with studio_of(tmp_path, named=["bug1"]) as gate, opened(browser, gate) as page:
        page.keyboard.press("3")
        page.locator("#campaign-controller").wait_for()
        assert page.locator("#campaign-controller").input_value() == "bug1"
        page.keyboard.press("2")
        page.locator(".result[data-controller=bug1]").wait_for()
        named = page.locator("#play .robots input").first
        assert (named.input_value(), named.is_checked()) == ("bug1", True)
        page.locator("#play").get_by_label("Motion model").select_option("stepped")
        page.locator("#other-controllers", has_text="more under swept, bug1 among them").wait_for()
        page.locator("#run-due", has_text="press Run").wait_for()


def test_a_robot_of_two_names_is_offered_once_under_the_thesis_s_model(page):
    page.keyboard.press("2")
    labels = page.locator("#play .robots label")
    labels.first.wait_for()
    assert labels.all_inner_texts() == ["thesis-1 (turn-right)", "thesis-2 (turn-left)", "thesis-3 (turn-random)"]


def test_in_a_blocked_world_the_results_say_so_and_the_cut_is_drawn(page):
    page.keyboard.press("l")
    drag(page, (0, 20), (39, 20))
    page.locator("#proof.bad", has_text="parts the start from the target").wait_for()
    page.keyboard.press("2")
    page.locator(".result .note", has_text="can reach the target").wait_for()
    assert page.get_by_label("Cut").is_checked()


def test_start_and_target_are_named_under_the_mouse(page):
    for name in ("Start", "Target"):
        x, y = (page.get_by_role("group", name=name).get_by_role("spinbutton").nth(k).input_value() for k in range(2))
        page.mouse.move(*place(page, float(x) / 0.1, float(y) / 0.1))
        page.locator(".status .place", has_text=f"{name} · cell").wait_for()
        assert page.locator("#board").get_attribute("title").startswith(name)
