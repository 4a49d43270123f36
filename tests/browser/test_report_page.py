"""A report opened in Chromium, from disk."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from fuzz.report import write_report
from tests.helpers.accessibility import badly_structured, nameless
from tests.helpers.browser import eventually, expect, page_in
from tests.helpers.campaign_folder import (
    CORPUS,
    LOOP,
    TUNNEL,
    campaign_folder,
    explain_the_loop,
    with_details,
)
from tests.helpers.command_line import worldgen
from tests.helpers.yellow_marks import YELLOW, check_in_place
from worldgen.files.grid import read_world, write_world
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import FailureRecord, Pose, Target, World

pytestmark = pytest.mark.gate

HOSTILE = (
    "<img src=x "
    "onerror=document.title='broken'></script><script>document.title='broken'</script>'\"& "
    "\u202e☃"
)
LOOPS = "returns to a wall"
PLACES = ["", "loop", "#campaign"]

BLANK = """canvas => !canvas.getContext('2d')
  .getImageData(0, 0, canvas.width, canvas.height).data.some(Boolean)"""

# Whether the lowest row with the colour of walls is as wide as the highest one.
LOWER_CORNERS = """canvas => {
  const { width, height } = canvas, { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const isWall = (x, y) => data[4 * (y * width + x)] === 59 && data[4 * (y * width + x) + 1] === 67;
  const count = (y) => [...Array(width).keys()].filter((x) => isWall(x, y)).length;
  const rows = [...Array(height).keys()].map(count).map((n, y) => [n, y]).filter(([n]) => n > 40);
  return rows.length > 0 && rows.at(0)[0] === rows.at(-1)[0];
}"""


def burning_failure():
    """A robot with range beams in a world that changes, without a search."""
    walls = np.zeros((6, 8), bool)
    walls[3, 4] = True
    line = Timeline.of([Event(0.3, 6, 1, CellState.BURNING), Event(0.6, 6, 1, CellState.FREE)])
    record = FailureRecord(
        "vfh", "swept", 0, "timeout", "0" * 16, {"steps": 60, "time_step": 0.015}
    )
    return World(
        walls, Pose(0.25, 0.25, 0.0), Target(0.65, 0.45, 0.05), timeline=line, failure=record
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = campaign_folder(tmp_path_factory.mktemp("page") / "failures")
    hostile = with_details(read_world(CORPUS / TUNNEL), **{"class": HOSTILE}, cause="unknown")
    write_world(hostile, folder / "<b onclick=x>'\".grid")
    gone = read_world(CORPUS / "thesis-3-slide.grid")
    gone = with_details(gone, **{"class": "of-a-controller-elsewhere"}, cause="unknown")
    write_world(
        replace(gone, failure=replace(gone.failure, controller="./gone.py:<i>")),
        folder / "gone.grid",
    )
    write_world(burning_failure(), folder / "burning.grid")
    return folder


@pytest.fixture(scope="module")
def address(folder):
    out = folder.parent / "report.html"
    write_report([folder], out)
    return out.as_uri()


@pytest.fixture(scope="module")
def python_address(tmp_path_factory):
    """The report of a campaign of a Python class whose count of bumps survives reset()."""
    folder = tmp_path_factory.mktemp("python")
    (folder / "counts.py").write_text("""
import math
from sim import Command

class Counts:
    bumps = 0
    def reset(self):
        return (0.0,)
    def act(self, observation, memory):
        turn = 0.0
        if observation.bump:
            self.bumps += 1
            turn = math.pi / 2
        elif observation.x < -1:
            turn = 1.0
        return Command(observation.top_speed, turn / observation.time_step), memory
""")
    out = folder / "failures"
    controller = f"{folder / 'counts.py'}:Counts"
    wanted = ("--units", 1, "--examples", 40, "--seed", 5, "--workers", 1, "--no-shrink")
    worldgen("fuzz", "--controller", controller, *wanted, "--out", out)
    write_report([out], folder / "report.html")
    return (folder / "report.html").as_uri()


@pytest.fixture
def page(browser, address):
    """The page, freshly opened in light colours."""
    with page_in(browser, color_scheme="light") as page:
        page.goto(address)
        yield page


def open_failure(page, text):
    """Open the failure whose card has this text, by its link."""
    page.locator(".card", has_text=text).first.click()
    page.locator("#stage").wait_for()


def open_place(page, address, place):
    """Show the list, a failure, or the campaign."""
    if place == "loop":
        open_failure(page, LOOPS)
    else:
        page.goto(f"{address}{place}")


def press(page, *keys):
    """Press keys in the focused element."""
    for key in keys:
        page.keyboard.press(key)


def readout(page):
    return page.locator("#readout").inner_text()


def step(page):
    return int(re.search(r"step ([\d,]+)", readout(page))[1].replace(",", ""))


def scrub_to(page, moment):
    page.locator("#scrub").fill(str(moment))


def picture(page):
    """Return the canvas's picture as a data address."""
    return page.evaluate("document.querySelector('#stage').toDataURL()")


def test_the_first_screen_says_why_failures_are_not_confirmed(page):
    words = page.locator("#totals + .bad").inner_text()
    assert "not confirmed: " in words and "./gone.py" in words


def test_nothing_is_asked_of_any_other_file_or_host(page, address):
    open_failure(page, LOOPS)
    page.goto(f"{address}#campaign")
    page.reload()
    asked = {name for name in page.requested if not name.startswith("data:")}
    assert {name.partition("#")[0] for name in asked} == {address}
    assert page.complaints == []


def test_names_of_strangers_are_only_text(page):
    title = page.title()
    open_failure(page, "onerror")
    expect(page.locator("#detail h2")).to_have_text(HOSTILE)
    expect(page.locator("main img, main script, main [onclick], main [onerror]")).to_have_count(0)
    expect(page).to_have_title(f"{HOSTILE} - {title}")


def test_every_small_picture_is_drawn(page):
    expect(page.locator(".card")).to_have_count(6)
    page.wait_for_function(
        "[...document.querySelectorAll('.card canvas')].every((one) => one.width >= 100)"
    )


def test_scrubbing_to_the_entry_is_put_into_words(page):
    open_failure(page, LOOPS)
    scrub_to(page, 29)
    expect(page.locator("#scrub")).to_have_attribute("aria-valuetext", re.compile("step 29 of 133"))
    expect(page.locator("#readout")).to_contain_text("the loop is entered")


def test_paper_shows_what_is_folded_and_no_buttons(page):
    open_failure(page, LOOPS)
    folded = page.locator("main details:not([open])")
    before = folded.count()
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    assert before > 0
    expect(folded).to_have_count(0)
    expect(page.locator("main button:visible")).to_have_count(0)
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    expect(folded).to_have_count(before)


def test_a_loop_is_told_by_the_moves_that_repeat(page):
    open_failure(page, LOOPS)
    expect(page.locator("#detail")).to_contain_text("It repeats 104 steps (1.56 s")


def test_each_layer_can_be_switched_off_and_on(page):
    open_failure(page, LOOPS)
    before = picture(page)
    for key in "tuiw":
        press(page, key)
        assert picture(page) != before, key
        press(page, key)
        assert picture(page) == before, key


def test_range_beams_are_drawn_for_a_robot_that_has_them(page):
    open_failure(page, "vfh")
    beams = (
        "JSON.parse(document.getElementById('data').textContent).failures.map((f) => "
        "f.now.sensors?.beams)"
    )
    assert max(number or 0 for number in page.evaluate(beams)) > 0
    before = picture(page)
    press(page, "s")
    assert picture(page) != before


def test_fire_is_drawn_while_it_burns_and_the_floor_stays_burnt(page):
    open_failure(page, "vfh")
    pixels = []
    press(page, "s", "t", "u", "i")
    for moment in (19, 20, 39, 40):  # it burns from 0.3 s to 0.6 s
        scrub_to(page, moment)
        pixels.append(page.evaluate(_BURNING_CELL))
    before, first, last, after = pixels
    assert first == last
    assert len({before, first, after}) == 3


_BURNING_CELL = """() => {
  const c = document.getElementById("stage"), s = c.width / c.clientWidth, pen = c.getContext("2d");
  const h = c.clientHeight - 18, w = c.clientWidth, k = Math.min((w - 32) / 8, (h - 32) / 6);
  return [...pen.getImageData((w / 2 + 2.5 * k) * s, (h / 2 + 1.5 * k) * s, 1, 1).data].join();
}"""


def test_the_keyboard_alone_opens_and_goes_back(page):
    card = page.locator(".card").first
    first = card.get_attribute("id")
    card.focus()
    press(page, "ArrowRight")
    chosen = page.evaluate("document.activeElement.id")
    assert chosen != first
    press(page, "Enter")
    page.locator("#detail h2").wait_for()
    press(page, "Escape")
    page.wait_for_function("(id) => document.activeElement.id === id", arg=chosen)


def test_a_failure_has_an_address_and_back_works(page):
    open_failure(page, LOOPS)
    link = page.url
    page.go_back()
    page.locator("#overview").wait_for()
    page.goto(link)
    expect(page.locator("#detail h2")).to_have_text(LOOPS)


def test_the_keys_are_shown_and_closed(page):
    press(page, "?")
    expect(page.locator("#keys")).to_contain_text("Play, pause")
    press(page, "Escape")
    expect(page.locator("#keys")).to_be_hidden()


def test_colours_follow_the_system_and_the_button(page):
    colour = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(colour)
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(f"(light) => {colour} !== light", arg=light)
    page.locator("#theme").click()
    page.wait_for_function(f"(light) => {colour} === light", arg=light)


def test_a_picture_changes_its_colours_too(page):
    open_failure(page, LOOPS)
    before = picture(page)
    press(page, "d")
    assert picture(page) != before


def test_the_download_is_the_file_byte_for_byte(page, folder, tmp_path):
    open_failure(page, LOOPS)
    with page.expect_download() as download:
        page.locator("a[download]").first.click()
    download.value.save_as(tmp_path / "got.grid")
    assert download.value.suggested_filename.endswith(".grid")
    assert (tmp_path / "got.grid").read_bytes() == (folder / LOOP).read_bytes()


def test_the_world_as_found_can_be_replayed(page):
    open_failure(page, LOOPS)
    pair = page.locator(".pair canvas")
    expect(pair).to_have_count(2)
    expect(pair.first).to_have_attribute(
        "aria-label", re.compile("^As found: World of 9 x 3 cells")
    )
    page.locator(".pair button").first.click()
    expect(page.locator("#stage")).to_have_attribute("aria-label", re.compile(r"^As found\."))


def test_a_controller_that_is_not_here_leaves_the_world(page):
    open_failure(page, "elsewhere")
    expect(page.locator("#detail")).to_contain_text("could not be run here")
    assert len(set(picture(page))) > 10


def test_search_and_verdicts_choose_cards(page):
    page.locator("button", has_text="tunnel").first.click()
    expect(page.locator(".card")).to_have_count(3)
    page.locator("#find").fill("onerror")
    expect(page.locator(".card")).to_have_count(1)
    page.locator("#find").press_sequentially("zzz")
    expect(page.locator("#overview")).to_contain_text("No failure matches")


def test_the_campaign_has_its_charts_and_their_tables(page, address):
    page.goto(f"{address}#campaign")
    titles = ("Found over time", "By search strategy", "Archive: detour and density")
    for number, title in enumerate(titles):
        expect(page.locator("#campaign h3").nth(number)).to_have_text(title)
    expect(page.locator("#campaign .heat")).to_have_count(2)
    expect(page.locator("#campaign .first")).to_have_count(2)
    expect(page.locator("svg.plot[aria-label]").first).to_be_attached()
    expect(page.locator("svg.plot:not([aria-label])")).to_have_count(0)


def test_every_control_has_a_name_and_headings_and_tables_make_sense(page, address):
    for place in PLACES:
        open_place(page, address, place)
        assert nameless(page) == [], place
        assert badly_structured(page) == [], place


def test_a_narrow_window_needs_no_scrolling_sideways(browser, address):
    with page_in(
        browser, viewport={"width": 400, "height": 800}, device_scale_factor=2, is_mobile=True
    ) as page:
        page.goto(address)
        for place in PLACES:
            open_place(page, address, place)
            assert page.evaluate("document.documentElement.scrollWidth") <= 400, place


def test_the_first_screen_answers_without_scrolling(page):
    page.set_viewport_size({"width": 1280, "height": 800})
    first = page.locator(".answer").first
    for part in (".headline", ".cause .name", ".cause p", ".command code", ".pictures canvas"):
        box = first.locator(part).first.bounding_box()
        assert box["y"] + box["height"] <= 800, part
    expect(first.locator(".headline")).to_contain_text("goes through walls")
    painted = first.locator(".pictures canvas").first.evaluate(
        "canvas => new Set(canvas.getContext('2d').getImageData(0, 0, canvas.width, "
        "canvas.height).data).size"
    )
    assert painted > 8


def test_each_cause_has_its_example_and_only_one_is_open(browser, tmp_path):
    write_report([campaign_folder(tmp_path / "c")], tmp_path / "r.html")
    with page_in(browser) as page:
        page.goto((tmp_path / "r.html").as_uri())
        check_examples(page)


def check_examples(page):
    answer = page.locator(".answer", has_text="wanders")
    commands = answer.locator(".cause .command")
    expect_visible(commands, True, False)
    answer.get_by_role("button", name="Example of wanders").click()
    expect_visible(commands, False, True)
    expect(answer.locator(".pictures:visible")).to_have_count(1)
    shown = answer.locator(".pictures canvas:visible").first
    eventually(page, lambda: shown.evaluate(BLANK), lambda blank: not blank)

    # Paper shows all of them, and the campaign.
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    expect_visible(commands, True, True)
    expect(page.locator("#campaign")).to_be_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    expect_visible(commands, False, True)
    expect(page.locator("#campaign")).to_be_hidden()


def expect_visible(parts, *flags):
    """Wait until exactly those parts are visible whose flag is set."""
    expect(parts).to_have_count(len(flags))
    for number, flag in enumerate(flags):
        expect(parts.nth(number)).to_be_visible(visible=flag)


def test_a_picture_on_paper_keeps_its_proportions_and_its_theme_is_light(page):
    page.set_viewport_size({"width": 1280, "height": 800})
    page.emulate_media(color_scheme="dark")
    page.wait_for_function("() => document.documentElement.dataset.theme === 'dark'")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    canvas = page.locator(".pictures canvas").first
    expect(canvas).to_have_css("object-fit", "contain")
    expect(page.locator("html")).to_have_attribute("data-theme", "light")


def test_the_scale_bar_is_below_the_world(page):
    """The solid ground around a world is in one colour to its last corner."""
    cards = page.locator(".card canvas").all()
    for canvas in cards:
        canvas.scroll_into_view_if_needed()
    # Some pictures are cropped to what happens; those of whole worlds have their lower corners.
    eventually(page, lambda: [canvas.evaluate(LOWER_CORNERS) for canvas in cards], any)


def test_a_cause_leads_to_its_clearest_failure_with_the_reason_and_a_test(page):
    page.locator(".cause .name", has_text=LOOPS).first.click()
    page.locator("#stage").wait_for()
    expect(page.locator("#detail h2")).to_have_text(LOOPS)
    page.get_by_text("Test to paste").click()
    expect(page.locator("pre.test")).to_contain_text("def test_")


def test_on_paper_every_small_picture_is_drawn(page):
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    blank = page.evaluate(
        """[...document.querySelectorAll('.card canvas')].filter((canvas) => {
          const context = canvas.getContext('2d');
          return !context.getImageData(0, 0, canvas.width, canvas.height).data.some(Boolean);
        }).length"""
    )
    # The one world whose controller is missing is also drawn, without a path.
    assert blank == 0
    expect(page.locator("nav")).to_be_hidden()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_cell_that_a_sentence_names_is_marked_in_the_pictures_next_to_it(
    browser, tmp_path, scheme
):
    folder = campaign_folder(tmp_path / "c", controller="thesis-1")
    explain_the_loop(folder, [{"what": "cell", "value": [2, 1]}])
    world = read_world(folder / LOOP)
    write_report([folder], tmp_path / "r.html")
    with page_in(browser, color_scheme=scheme) as page:
        page.goto((tmp_path / "r.html").as_uri())
        answer = page.locator(".answer", has_text="thesis-1").first
        expect(answer.get_by_text("cell named in the text")).to_have_count(1)
        check_in_place(answer.locator("canvas[data-which=now]"), world, (2, 1))
        # The cards, which have no sentence, have no mark.
        card = page.locator(".card", has_text=LOOPS).first
        assert card.locator("canvas").evaluate(YELLOW)["count"] == 0
        card.click()
        page.locator(".legend-part").get_by_text("cell named in the text").wait_for()
        check_in_place(page.locator("#stage"), world, (2, 1))
        check_in_place(page.locator(".pair canvas[data-which=now]"), world, (2, 1))
        assert page.complaints == []


def test_a_button_leads_to_the_first_bump(browser, address):
    with page_in(browser) as page:
        page.goto(address)
        page.locator(".card", has_text=LOOPS).first.click()
        button = page.get_by_role("button", name=re.compile(r"First bump \d+"))
        button.click()
        step = int(button.inner_text().split()[-1])
        expect(page.locator("#readout")).to_contain_text(f"step {step} of")
        expect(page.locator("#readout")).to_contain_text("touches something for the first time")


def test_lines_state_and_reactions_are_on_the_first_screen_and_with_each_failure(
    browser, python_address
):
    with page_in(browser) as page:
        page.goto(python_address)
        answer = page.locator("#answer")
        for words in ("survives reset(): self.bumps", "Lines of the controller that never ran"):
            answer.locator(".notice", has_text=words).first.wait_for()
        runs = answer.locator(".code tr", has_text="turn = math.pi / 2").first
        expect(runs).to_have_class("ran")
        expect(runs).not_to_contain_text("never")
        idle = answer.locator(".code tr", has_text="turn = 1.0").first
        expect(idle).to_have_class("unused")
        expect(idle).to_contain_text("never")
        expect(answer).to_contain_text("in all runs of this report")
        expect(answer.locator(".reactions")).to_contain_text("left by 90 degrees")
        page.locator(".card").first.click()
        page.locator("#stage").wait_for()
        for part in (".code", ".state", ".reactions"):
            expect(page.locator(f"#detail {part}")).to_be_visible()
        assert page.complaints == []


def test_lines_of_code_need_no_scrolling_sideways(browser, python_address):
    with page_in(browser, viewport={"width": 400, "height": 800}, is_mobile=True) as page:
        page.goto(python_address)
        page.locator(".code").first.wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 400


def test_a_compiled_controller_has_reactions_and_no_lines(page):
    expect(page.locator("#answer .reactions").first).to_be_visible()
    expect(page.locator(".code")).to_have_count(0)


@pytest.mark.gate
def test_a_report_of_several_controllers_begins_with_a_table_of_them(browser, tmp_path):
    for name in ("thesis-1-loop-104", "thesis-2-corner-tunnel"):
        shutil.copy(CORPUS / f"{name}.grid", tmp_path)
    write_report([tmp_path], tmp_path / "report.html")
    with page_in(browser) as page:
        page.goto((tmp_path / "report.html").as_uri())
        rows = page.locator(".controllers tbody tr")
        expect(rows).to_have_count(2)
        expect(page.locator(".answer")).to_have_count(2)
        expect(rows.first).to_contain_text("goes through a wall")  # the worst comes first
        assert page.complaints == []
