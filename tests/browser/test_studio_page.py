"""The studio's page in a browser, with real mouse and keyboard."""

import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sim.episode import simulate
from sim.options.run import RunOptions
from tests.helpers.command_line import worldgen
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, opened, place, solid_cells
from worldgen import generate
from worldgen.files.grid import read_world, write_world

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


@pytest.mark.gate
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


@pytest.mark.nightly
def test_the_right_button_erases(page):
    drag(page, (5, 5), (9, 5))
    drag(page, (6, 5), (8, 5), button="right")
    assert solid_cells(page) == BORDER + 2


@pytest.mark.gate
def test_the_board_stays_where_it_is_whatever_the_proof_says(page):
    page.locator("#proof.good").wait_for()
    before = page.locator("#board").bounding_box()
    page.keyboard.press("l")
    drag(page, (0, 20), (39, 20))
    page.locator("#proof.bad", has_text="gaps too narrow").wait_for()
    assert page.locator("#board").bounding_box() == before


@pytest.mark.gate
def test_saving_a_nameless_world_while_playing_leads_at_once_to_its_name(page):
    page.keyboard.press("2")
    page.locator("#play").wait_for()
    focused = page.evaluate("""() => {
      document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "s", ctrlKey: true, bubbles: true }));
      return document.activeElement.id;
    }""")
    assert focused == "save-name"


@pytest.mark.nightly
def test_the_radius_slider_shows_where_the_way_closes(page):
    page.locator("#widest", has_text="Robots pass up to a radius of").wait_for()
    page.locator("#radius").focus()
    page.keyboard.press("End")
    page.locator("#proof.bad").wait_for()


@pytest.mark.nightly
def test_the_generator_shows_a_family_s_bounds_and_does_not_send_what_is_outside(page):
    page.locator("#tab-maker").click()
    page.get_by_text("Cells per side, including the solid border. 10 to 20000 cells.").wait_for()
    page.get_by_role("spinbutton", name="Size", exact=True).fill("9")
    assert (
        page.get_by_role("spinbutton", name="Size", exact=True).get_attribute("aria-invalid")
        == "true"
    )
    page.get_by_role("button", name="Generate", exact=True).click()
    page.get_by_text("Size is a whole number, 10 to 20000 cells.").wait_for()
    page.get_by_role("spinbutton", name="Size", exact=True).fill("12")
    page.get_by_role("button", name="Generate", exact=True).click()
    page.get_by_text("Made by maze, version 1, seed 1.").wait_for()
    page.locator(".status .place", has_text="12 x 12 cells").wait_for()  # drawn a frame later


@pytest.mark.nightly
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


@pytest.mark.gate
def test_an_export_is_what_the_library_writes(page):
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.get_by_label("Export as").select_option("thesis")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert Path(download.value.path()).stat().st_size > 100


@pytest.mark.gate
def test_a_page_without_the_token_gets_nothing(browser, gate):
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(gate.address.partition("?")[0])
        assert "your browser has no access" in page.inner_text("body")


def start_studio(folder, *port):
    """A studio in a process of its own, at that port or at one that it finds.

    Gives it with its address.
    """
    command = [sys.executable, "-m", "worldgen", "studio", str(folder), "--no-browser", *port]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    return process, process.stderr.readline().split()[-1]


@pytest.mark.nightly
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
        again, address = start_studio(
            tmp_path, "--port", address.partition("/?")[0].rpartition(":")[2]
        )
        page.get_by_text("was restarted").wait_for()
        page.goto(address)
        page.locator("#proof.good").wait_for()
        assert solid_cells(page) == BORDER + 1
        again.send_signal(signal.SIGINT)
        assert again.wait(timeout=180) == 0
    process.stderr.close(), again.stderr.close()


@pytest.mark.gate
def test_a_failure_s_file_brings_its_controller_and_replays_to_its_digest(page, folder):
    shutil.copy(FAILURE, folder / "failure.grid")
    page.locator("#tab-files").click()
    page.locator(".file", has_text="failure.grid").click()
    page.get_by_text("Opened failure.grid").first.wait_for()
    page.keyboard.press("2")
    assert page.locator(".digest").inner_text() == read_world(FAILURE).failure.trace_digest


@pytest.mark.nightly
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
    page.locator(".result[data-controller=thesis-1]").and_(
        page.locator("[aria-current] > .result")
    ).wait_for()


@pytest.mark.gate
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
    page.locator("#said", has_text="shared.grid was not changed").wait_for(state="attached")
    assert (
        "another program" in asked[0]
        and (folder / "shared.grid").read_bytes() == FAILURE.read_bytes()
    )


def darkness(page, x, y):
    """How dark the board is at a point of the world, in cells: 0 to 255."""
    box = page.locator("#board").bounding_box()
    across, down = place(page, x, y)
    page.evaluate(
        "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )
    return page.evaluate(
        "([x, y]) => 255 - document.getElementById('board').getContext('2d').getImageData(x, y, 1, "
        "1).data[0]",
        [round(across - box["x"]), round(down - box["y"])],
    )


@pytest.mark.nightly
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
    assert [
        one for one in page.complaints if "readback" not in one
    ] == []  # that one is of this test's own looking


@pytest.mark.nightly
def test_each_tab_keeps_its_own_drawing_and_a_new_one_goes_on_with_that_of_a_closed_one(
    browser, gate, folder
):
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


@pytest.mark.nightly
def test_a_controller_named_at_the_start_that_cannot_be_loaded_is_told_with_its_fault(
    browser, folder
):
    with studio_of(folder, named=["./misspelt.py:Robot"]) as gate, opened(browser, gate) as page:
        told = page.locator("#gone")
        told.get_by_text("misspelt.py").wait_for()
        assert (
            "misspelt.py:Robot cannot run." in told.inner_text()
            and "no such file" in told.inner_text()
        )
        told.get_by_role("button", name="Close").click()
        assert not told.is_visible()
        assert page.complaints == []


@pytest.mark.nightly
def test_no_difficulty_can_be_wished_of_a_family_whose_worlds_change(page):
    page.get_by_role("tab", name="Generate").click()
    page.get_by_text("Search for a world with a given difficulty").click()
    difficulty = page.get_by_label("Difficulty, 0 to 1")
    difficulty.fill("0.8")
    page.get_by_label("Family").select_option("fire")
    assert difficulty.is_disabled() and difficulty.input_value() == ""
    page.get_by_label("Family").select_option("maze")
    assert difficulty.is_enabled()


@pytest.mark.nightly
def test_a_world_grows_where_it_does_not_stay_down_to_one_row_and_up_to_four_million_cells(page):
    drag(page, (5, 5), (9, 5))
    drawn = solid_cells(page)
    page.get_by_label("Upper right").check()
    page.get_by_label("Columns").first.fill("44")
    page.get_by_label("Rows").first.fill("30")
    page.get_by_role("button", name="Resize").click()
    page.locator("#place", has_text="44 x 30 cells").wait_for()
    assert solid_cells(page) == drawn - 40 - 2 * 9 - 5  # below, the border and the stroke are gone
    assert (
        page.get_by_label("x m").first.input_value() == "0.65"
    )  # the start has moved with its cells
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


@pytest.mark.nightly
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


@pytest.mark.gate
def test_in_a_blocked_world_the_results_say_so_and_the_cut_is_drawn(page):
    page.keyboard.press("l")
    drag(page, (0, 20), (39, 20))
    page.locator("#proof.bad", has_text="separates the start from the target").wait_for()
    page.keyboard.press("2")
    page.locator(".result .note", has_text="can reach the target").wait_for()
    assert page.get_by_label("Cut").is_checked()


@pytest.mark.nightly
def test_start_and_target_are_named_under_the_mouse(page):
    for name in ("Start", "Target"):
        x, y = (
            page.get_by_role("group", name=name).get_by_role("spinbutton").nth(k).input_value()
            for k in range(2)
        )
        page.mouse.move(*place(page, float(x) / 0.1, float(y) / 0.1))
        page.locator(".status .place", has_text=f"{name} · cell").wait_for()
        assert page.locator("#board").get_attribute("title").startswith(name)


@pytest.mark.gate
def test_a_name_that_was_typed_stays_while_one_draws_on(page):
    page.keyboard.press("Control+s")
    page.keyboard.type("mine")
    drag(page, (3, 3), (9, 3))
    page.locator("#name", has_text="changed").wait_for()
    assert page.locator("#save-name").input_value() == "mine"


@pytest.mark.gate
def test_a_pair_of_ros_is_imported_by_the_mouse_and_exported_with_options(page, folder, tmp_path):
    write_world(generate("corridor", 3), tmp_path / "w.grid")
    assert (
        worldgen("export", tmp_path / "w.grid", "--to", "ros", "--out", tmp_path / "out.yaml").code
        == 0
    )
    pair = [tmp_path / "out.pgm", tmp_path / "out.yaml"]
    page.locator("#tab-files").click()
    page.get_by_text("Import and export").click()
    page.locator("#import").set_input_files(pair)
    page.get_by_text("Imported out.yaml.").wait_for()
    page.get_by_label("Export as").select_option("ros")
    page.locator("#export-more summary").click()
    page.get_by_label("Mode", exact=True).select_option("scale")
    page.locator("#export-x").fill("0.5")
    page.locator("#export-y").fill("-2")
    page.get_by_role("button", name="Save to the folder").click()
    page.get_by_text("Wrote world.yaml, world.pgm").wait_for()
    assert page.complaints == []
    assert "mode: scale" in (folder / "world.yaml").read_text()
    assert "origin: [0.5, -2, 0.0]" in (folder / "world.yaml").read_text()
