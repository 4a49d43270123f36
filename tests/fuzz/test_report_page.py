"""A report opened in Chromium, from disk."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from fuzz.report import write_report
from tests.helpers.browser import colour_scheme, missing_browser, requested, start_browser
from tests.helpers.campaign_folder import CORPUS, LOOP, TUNNEL, campaign_folder, renamed
from worldgen.grid_file import read_world, write_world
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import FailureRecord, Pose, Target, World

pytestmark = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "-")

HOSTILE = "<img src=x onerror=document.title='broken'></script><script>document.title='broken'</script>'\"& \u202e☃"
SECONDS = 60  # that a page gets at most, on a machine that is busy, for what it does at once


def burning_failure():
    """A robot with range beams in a world that changes: no search is needed to have one."""
    walls = np.zeros((6, 8), bool)
    walls[3, 4] = True
    line = Timeline.of([Event(0.3, 6, 1, CellState.BURNING), Event(0.6, 6, 1, CellState.FREE)])
    record = FailureRecord("vfh", "swept", 0, "timeout", "0" * 16, {"steps": 60, "time_step": 0.015})
    return World(walls, Pose(0.25, 0.25, 0.0), Target(0.65, 0.45, 0.05), timeline=line, failure=record)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = campaign_folder(tmp_path_factory.mktemp("page") / "failures")
    write_world(renamed(read_world(CORPUS / TUNNEL), HOSTILE), folder / "<b onclick=x>'\".grid")
    gone = renamed(read_world(CORPUS / "thesis-3-slide.grid"), "of-a-controller-elsewhere")
    write_world(replace(gone, failure=replace(gone.failure, controller="./gone.py:<i>")), folder / "gone.grid")
    write_world(burning_failure(), folder / "burning.grid")
    return folder


@pytest.fixture(scope="module")
def downloads(tmp_path_factory):
    return tmp_path_factory.mktemp("downloads")


@pytest.fixture(scope="module")
def browser(tmp_path_factory, downloads):
    browser = start_browser(tmp_path_factory.mktemp("profile"), downloads)
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def address(folder):
    out = folder.parent / "report.html"
    write_report([folder], out)
    return out.as_uri()


@pytest.fixture
def page(browser, address):
    """The page, freshly opened in light colours."""
    colour_scheme(browser, "light")
    browser.get("about:blank")
    browser.get(address)
    return browser


def until(check):
    """Waits until something holds, and returns it."""
    deadline = time.monotonic() + SECONDS
    while not (found := check()) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert found
    return found


def open_failure(page, text):
    """Opens the failure whose card has this text, by its link."""
    cards = page.find_elements(By.CSS_SELECTOR, ".card")
    next(card for card in cards if text in card.text).click()
    until(lambda: page.find_elements(By.CSS_SELECTOR, "#stage"))


def press(page, *keys):
    """Presses keys where the focus is."""
    page.switch_to.active_element.send_keys(*keys)


def readout(page):
    return page.find_element(By.ID, "readout").text


def step(page):
    return int(re.search(r"step ([\d,]+)", readout(page))[1].replace(",", ""))


def picture(page, selector="#stage"):
    """The canvas as the text of a data address."""
    return page.execute_script(f"return document.querySelector({selector!r}).toDataURL()")


def test_it_opens_without_a_word_on_the_console(page):
    assert len(page.find_elements(By.CSS_SELECTOR, ".card")) == 6
    assert page.get_log("browser") == []


def test_nothing_is_asked_of_any_other_file_or_host(page, address):
    requested(page)
    page.get("about:blank")
    page.get(address)
    open_failure(page, "loop-a")
    page.get(f"{address}#campaign")
    assert {name.partition("#")[0] for name in requested(page)} <= {address, "about:blank"}


def test_names_of_strangers_are_only_text(page):
    title = page.title
    open_failure(page, "onerror")
    assert page.find_element(By.CSS_SELECTOR, "#detail h2").get_property("textContent").strip() == HOSTILE
    assert page.find_elements(By.CSS_SELECTOR, "main img, main script, main [onclick], main [onerror]") == []
    assert page.title == f"{HOSTILE} - {title}"


def test_every_small_picture_is_drawn(page):
    empty = "return [...document.querySelectorAll('.card canvas')].filter((c) => c.width < 100).length"
    until(lambda: page.execute_script(empty) == 0)


def test_play_moves_the_robot(page):
    open_failure(page, "loop-a")
    press(page, Keys.HOME)
    before = picture(page)
    page.find_element(By.ID, "play-pause").click()
    until(lambda: step(page) > 0)
    press(page, " ")
    assert picture(page) != before


def test_a_loop_goes_on_at_its_entry(page):
    open_failure(page, "loop-a")
    assert step(page) == 133
    press(page, "e")
    assert (step(page), "the loop is entered" in readout(page)) == (29, True)
    press(page, "l")
    until(lambda: step(page) > 29)
    assert page.find_element(By.CSS_SELECTOR, "#detail button[aria-pressed=true]").text == "One period"


def test_scrubbing_to_the_entry_says_so(page):
    open_failure(page, "loop-a")
    page.execute_script("scrub.value = 29; scrub.dispatchEvent(new Event('input'))")
    assert "step 29 of 133" in page.find_element(By.ID, "scrub").get_attribute("aria-valuetext")
    assert "the loop is entered" in readout(page)


def test_entry_and_period_are_marked_on_the_bar(page):
    open_failure(page, "loop-a")
    period = page.find_element(By.CSS_SELECTOR, ".scrub .period")
    assert float(period.get_attribute("x")) == pytest.approx(1000 * 29 / 133)
    assert float(period.get_attribute("width")) == pytest.approx(1000 * 104 / 133)


def test_a_tunnel_is_marked_where_it_happens(page):
    open_failure(page, "tunnel-a")
    assert page.find_elements(By.CSS_SELECTOR, ".scrub .breach")
    press(page, "e", "e")  # the cause, then the breach
    assert "goes through this wall" in readout(page)


def test_arrows_step_and_shift_steps_ten(page):
    open_failure(page, "loop-a")
    press(page, Keys.HOME)
    press(page, Keys.ARROW_RIGHT)
    press(page, Keys.SHIFT, Keys.ARROW_RIGHT)
    assert step(page) == 11


@pytest.mark.parametrize("key", ["t", "u", "i", "w"])
def test_a_layer_can_be_switched_off_and_on(page, key):
    open_failure(page, "loop-a")
    before = picture(page)
    press(page, key)
    assert picture(page) != before
    press(page, key)
    assert picture(page) == before


def test_range_beams_are_drawn_for_a_robot_that_has_them(page):
    open_failure(page, "vfh")
    beams = "return JSON.parse(document.getElementById('data').textContent).failures.map((f) => f.now.sensors?.beams)"
    assert max(number or 0 for number in page.execute_script(beams)) > 0
    before = picture(page)
    press(page, "s")
    assert picture(page) != before


def test_fire_is_drawn_while_it_burns(page):
    open_failure(page, "vfh")
    pixels = []
    press(page, "s", "t", "u", "i")
    for moment in (19, 20, 39, 40):  # it burns from 0.3 s to 0.6 s
        page.execute_script(f"scrub.value = {moment}; scrub.dispatchEvent(new Event('input'))")
        pixels.append(page.execute_script(
            "const c = document.getElementById('stage'), s = c.width / c.clientWidth, p = c.getContext('2d');"
            "const h = c.clientHeight, w = c.clientWidth, k = Math.min((w - 32) / 8, (h - 32) / 6);"
            "return [...p.getImageData((w / 2 + 2.5 * k) * s, (h / 2 + 1.5 * k) * s, 1, 1).data].join()"
        ))  # fmt: skip
    assert pixels[0] == pixels[3] != pixels[1] == pixels[2]


def test_the_keyboard_alone_opens_plays_and_goes_back(page):
    card = page.find_element(By.CSS_SELECTOR, ".card")
    page.execute_script("arguments[0].focus()", card)
    press(page, Keys.ARROW_RIGHT)
    chosen = page.switch_to.active_element.get_attribute("id")
    assert chosen != card.get_attribute("id")
    press(page, Keys.ENTER)
    until(lambda: page.find_elements(By.CSS_SELECTOR, "#detail h2"))
    press(page, Keys.ESCAPE)
    until(lambda: page.switch_to.active_element.get_attribute("id") == chosen)


def test_a_failure_has_an_address_and_back_works(page, address):
    open_failure(page, "loop-a")
    link = page.current_url
    page.back()
    until(lambda: page.find_element(By.ID, "overview").is_displayed())
    page.get(link)
    assert page.find_element(By.CSS_SELECTOR, "#detail h2").text.strip() == "loop-a"


def test_the_keys_are_shown_and_closed(page):
    press(page, "?")
    assert "Space\nPlay, pause" in page.find_element(By.ID, "keys").text.replace("Space Play", "Space\nPlay")
    press(page, Keys.ESCAPE)
    assert not page.find_element(By.ID, "keys").is_displayed()


def test_colours_follow_the_system_and_the_button(page):
    colour = "return getComputedStyle(document.body).backgroundColor"
    light = page.execute_script(colour)
    colour_scheme(page, "dark")
    until(lambda: page.execute_script(colour) != light)
    page.find_element(By.ID, "theme").click()
    assert page.execute_script(colour) == light


def test_a_picture_changes_its_colours_too(page):
    open_failure(page, "loop-a")
    before = picture(page)
    press(page, "d")
    assert picture(page) != before


def test_the_download_is_the_file_byte_for_byte(page, folder, downloads):
    open_failure(page, "loop-a")
    page.find_element(By.CSS_SELECTOR, "a[download]").click()
    got = until(lambda: [path for path in downloads.iterdir() if path.suffix == ".grid"])
    assert got[0].read_bytes() == (folder / LOOP).read_bytes()


def test_the_world_as_found_can_be_replayed(page):
    open_failure(page, "loop-a")
    before, _ = page.find_elements(By.CSS_SELECTOR, ".pair canvas")
    assert before.get_attribute("aria-label").startswith("As found: World of 9 x 3 cells")
    page.find_element(By.CSS_SELECTOR, ".pair button").click()
    assert page.find_element(By.ID, "stage").get_attribute("aria-label").startswith("As found.")


def test_a_controller_that_is_not_here_leaves_the_world(page):
    open_failure(page, "elsewhere")
    assert "could not be run here" in page.find_element(By.ID, "detail").text
    assert len(set(picture(page))) > 10


def test_search_and_verdicts_choose_cards(page):
    page.find_element(By.XPATH, "//button[contains(., 'tunnel')]").click()
    assert len(page.find_elements(By.CSS_SELECTOR, ".card")) == 3
    page.find_element(By.ID, "find").send_keys("onerror")
    assert len(page.find_elements(By.CSS_SELECTOR, ".card")) == 1
    page.find_element(By.ID, "find").send_keys("zzz")
    assert "No failure fits" in page.find_element(By.ID, "overview").text


def test_the_campaign_has_its_charts_and_their_tables(page, address):
    page.get(f"{address}#campaign")
    titles = [title.text for title in page.find_elements(By.CSS_SELECTOR, "#campaign h3")]
    assert titles[:3] == ["Found over time", "By lane", "Archive: detour and density"]
    assert len(page.find_elements(By.CSS_SELECTOR, "#campaign .heat")) == 2
    assert len(page.find_elements(By.CSS_SELECTOR, "#campaign .first")) == 2
    assert all(plot.get_attribute("aria-label") for plot in page.find_elements(By.CSS_SELECTOR, "svg.plot"))


@pytest.mark.parametrize("place", ["", "loop", "#campaign"])
def test_every_control_has_a_name(page, address, place):
    if place == "loop":
        open_failure(page, "loop-a")
    else:
        page.get(f"{address}{place}")
    controls = page.find_elements(By.CSS_SELECTOR, "a, button, input, select, summary, canvas, [tabindex='0']")
    shown = [control for control in controls if control.is_displayed()]
    assert shown
    assert [control.get_attribute("outerHTML") for control in shown if not control.accessible_name.strip()] == []


@pytest.mark.parametrize("place", ["", "loop", "#campaign"])
def test_a_narrow_window_needs_no_scrolling_sideways(page, address, place):
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 400, "height": 800, "deviceScaleFactor": 2, "mobile": True}
    )
    try:
        if place == "loop":
            open_failure(page, "loop-a")
        else:
            page.get(f"{address}{place}")
        assert page.execute_script("return document.documentElement.scrollWidth") <= 400
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
