"""The page on which robots drive.

Its layout, the thesis's settings, worlds that change.
"""

import base64
import math
import re
from pathlib import Path

import pytest

from sim import simulate
from tests.helpers.browser import eventually, expect
from tests.helpers.studio import studio_of
from tests.helpers.studio_page import drag, opened
from worldgen.families.builtin.shift import shifted
from worldgen.files.grid import read_world

CONFIG_5 = Path(__file__).parents[2] / "corpora/thesis/config-05.grid"


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("play")
    (folder / "config-05.grid").write_bytes(CONFIG_5.read_bytes())
    with studio_of(folder, file="config-05.grid") as gate:
        yield gate


def play(page, steps=300):
    """The page Play after its first run, limited to a few steps from now on."""
    page.keyboard.press("2")
    page.locator(".result").first.wait_for()
    page.get_by_label("Steps", exact=True).fill(str(steps))
    page.keyboard.press("Tab")


def run(page, steps=300):
    page.locator("#run").click()
    page.locator(".result", has_text=f"{steps} steps").first.wait_for()


def expect_digest(page, digest):
    """Wait until the run in front has this digest."""
    expect(page.locator("[aria-current] .digest")).to_have_text(digest)


def expected(world, controller, **options):
    return simulate(world, controller, motion="stepped", steps=300, **options).trace_digest


def out_of_sight(page, *parts):
    """Return the parts of the page that are not fully in the window, or are cut off by a scrolling
    area.
    """
    script = """(all) => all.filter((part) => [...document.querySelectorAll(part)].some((one) => {
      const { left, right, top, bottom } = one.getBoundingClientRect();
      const corners = [[left + 3, top + 3], [right - 3, bottom - 3]];
      return corners.some(([x, y]) => !one.contains(document.elementFromPoint(x, y)));
    }))"""
    return page.evaluate(script, list(parts))


SEEN = [
    "#stage",
    "#run",
    "#scrub",
    "#play-pause",
    "#instruments b",
    "#play .layers",
    ".results > ol > li",
]


@pytest.mark.parametrize(
    "how",
    [
        pytest.param(
            {"viewport": {"width": 1280, "height": 720}}, marks=pytest.mark.gate, id="small"
        ),
        pytest.param(
            {"viewport": {"width": 1920, "height": 1080}}, marks=pytest.mark.nightly, id="large"
        ),
        pytest.param(
            {"viewport": {"width": 820, "height": 1180}, "has_touch": True},
            marks=pytest.mark.nightly,
            id="tablet",
        ),
    ],
)
def test_with_three_robots_world_controls_state_and_all_results_are_in_sight(browser, gate, how):
    with opened(browser, gate, **how) as page:
        play(page)
        for name in ("thesis-1", "thesis-3"):
            page.get_by_role("checkbox", name=name).check()
        run(page)
        page.locator(".result").nth(2).wait_for()
        parts = (*SEEN, "#play .setup .robots label", "#play .headings button")
        eventually(page, lambda: out_of_sight(page, *parts), lambda hidden: hidden == [])


@pytest.mark.nightly
def test_with_six_robots_and_settings_open_the_results_keep_their_place(page):
    play(page)
    labels = (
        "thesis-1+slip=0.2",
        "thesis-1+noise",
        "thesis-2+repaired+sensor_range=60+drive_ticks=4",
        "thesis-1",
    )
    field = page.get_by_label("Another robot, with options")
    for label in labels:
        field.fill(label)
        field.press("Enter")
        page.wait_for_function(
            "(field) => field.value === ''", arg=field.element_handle()
        )  # it was added
    page.get_by_role("checkbox", name="thesis-3").check()
    page.get_by_role("button", name="Behaviours").click()
    run(page)
    page.locator(".results li").nth(5).wait_for()
    parts = ("#stage", "#run", "#scrub", "#instruments b", ".results li:first-child")
    eventually(page, lambda: out_of_sight(page, *parts), lambda hidden: hidden == [])
    box = page.locator("#play .results").bounding_box()
    assert box["y"] + box["height"] == 720 and 250 < box["height"] < 0.61 * 672
    assert page.get_by_label("Collide ticks").bounding_box()["y"] < box["y"]


@pytest.mark.gate
def test_the_flow_chart_marks_the_behaviour_that_acts(browser, gate):
    with opened(browser, gate) as page:
        play(page, 300)
        run(page)
        expect(page.locator("#arbitration")).to_be_hidden()
        page.keyboard.press("b")
        chart = page.locator("#arbitration")
        chart.get_by_role("img", name="Flow chart of thesis-2").wait_for()
        expect(chart.get_by_role("listitem").nth(2)).to_contain_text("drive on for 5 steps")

        # At each step the box of one behaviour is marked, the one that the instruments name.
        expected_acts = simulate(
            read_world(CONFIG_5), "thesis-2", motion="stepped", steps=300, record=True
        ).trace.active
        seen = set()
        for step in range(300, 0, -4):
            marked = chart.locator(".acts").evaluate_all("all => all.map(e => e.dataset.part)")
            who = ["collide", "seek", "drive", "none"][expected_acts[step]]
            named = " ".join(
                page.locator("#instruments", has_text="behaviour").inner_text().split()
            )
            assert marked == ([] if who == "none" else [who]) and f"behaviour {who}" in named
            seen.add(who)
            for _ in range(4):
                page.keyboard.press("ArrowLeft")
        assert seen >= {"collide", "seek", "drive"}

        # A robot without behaviours has no chart, and the choice is kept.
        page.locator("#play").get_by_label("Motion model").select_option("swept")
        page.get_by_role("checkbox", name="bug1", exact=True).check()
        page.get_by_role("checkbox", name="thesis-2").uncheck()
        page.locator("#run").click()
        page.locator(".result", has_text="bug1").wait_for()
        expect(chart).to_be_hidden()
        expect(page.locator("#show-arbitration")).to_be_hidden()
        assert page.complaints == []


@pytest.mark.nightly
def test_the_behaviours_settings_are_those_of_the_command_line(page):
    play(page)
    page.keyboard.press("Control+b")
    for name, value in (("Collide ticks", "9"), ("Drive ticks", "6"), ("Turn angle", "45")):
        page.get_by_label(name).fill(value)
    page.get_by_role("button", name="Sensor").click()
    page.get_by_label("Sensor range").fill("50")
    page.locator("#play").get_by_label("Noise", exact=True).check()
    page.locator("#run-due", has_text="Not run yet").wait_for()
    run(page, 261)  # the end of the first period of a loop
    own = {
        "collide_ticks": 9,
        "drive_ticks": 6,
        "turn_angle": math.pi / 4,
        "sensor_range": 50,
        "noise": True,
    }
    expect_digest(page, expected(read_world(CONFIG_5), "thesis-2", **own))
    for words in ("Behaviours 3 changed", "Sensor 2 changed"):
        page.get_by_role("button", name=words).wait_for()
    page.get_by_role("button", name="Behaviours").click()
    page.get_by_label("Turn angle").fill("90")
    page.keyboard.press("Tab")
    page.get_by_role("button", name="Behaviours 2 changed").wait_for()


@pytest.mark.gate
def test_a_setting_out_of_its_bounds_is_marked_and_nothing_is_run_with_it(page):
    play(page)
    page.get_by_role("button", name="Sensor").click()
    page.get_by_label("Sensor range").fill("20")
    page.get_by_role("button", name="Faults").click()
    page.keyboard.press("Control+Enter")
    page.locator(".fault", has_text="36 to 1,000").wait_for()
    page.get_by_label("Sensor range").and_(page.locator(":focus")).wait_for()
    expect(page.locator(".result", has_text="300 steps")).to_have_count(0)
    page.keyboard.press("Control+a")
    page.keyboard.type("40")
    page.keyboard.press("Control+Enter")
    page.locator(".result", has_text="300 steps").wait_for()
    expect_digest(page, expected(read_world(CONFIG_5), "thesis-2", sensor_range=40))


@pytest.mark.nightly
def test_with_a_wrong_setting_the_former_world_s_run_is_not_shown_as_this_one_s(page):
    play(page)
    page.get_by_label("Steps", exact=True).fill("0")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("1")
    page.locator("#board").wait_for()
    page.keyboard.press("b")
    drag(page, (16, 15), (22, 21))
    page.locator("#name", has_text="changed").wait_for()
    page.keyboard.press("2")
    page.locator("#run-said.bad", has_text="a setting is not valid").wait_for()
    expect(page.locator(".stage.stale")).to_have_count(1)
    expect(page.locator("input:focus")).to_have_count(0)
    page.locator("#run").click()
    page.get_by_label("Steps", exact=True).and_(page.locator(":focus")).wait_for()


@pytest.mark.nightly
def test_walls_change_places_and_stand_still_again(page):
    play(page)
    page.get_by_label("Let walls change places").check()
    page.locator(".result", has_text="300 steps").wait_for()
    still = read_world(CONFIG_5)
    moving = shifted(still, 0)
    assert len(moving.timeline) > 0
    expect_digest(page, expected(moving, "thesis-2"))
    expect(page.locator(".changes")).to_have_text(
        f"The world changes ({len(moving.timeline)} changes)"
    )
    page.get_by_label("The world changes").uncheck()
    page.locator("#run").click()
    page.locator(".digest", has_text=expected(still, "thesis-2")).wait_for()
    page.keyboard.press("1")
    page.keyboard.press("Control+z")
    page.keyboard.press("2")
    page.get_by_label("Let walls change places").wait_for()


@pytest.mark.nightly
def test_a_film_is_as_long_as_the_run_at_its_speed_and_moves_all_the_time(browser, gate):
    with opened(browser, gate) as page:
        play(page)
        run(page)
        page.locator("#play .under select").select_option("2")
        page.locator(".save summary").click()
        with page.expect_download() as download:
            page.locator(".save .menu").get_by_text("Film, WebM").click()
        film = base64.b64encode(Path(download.value.path()).read_bytes()).decode()
    with browser.new_context() as context:  # the studio's own page is not allowed to show films
        length, changed = context.new_page().evaluate(_LOOK_AT, [film, [0.1, 0.7, 1.3, 1.9]])
    assert length > 300 * 0.015 / 2  # on a busy machine it takes longer
    assert len(changed) == 3 and min(changed) > 20


# Return a film's length, and how many pixels change from each of these times to the next.
_LOOK_AT = """async ([film, times]) => {
  const video = document.createElement("video");
  video.muted = true;
  const bytes = Uint8Array.from(atob(film), (c) => c.charCodeAt(0));
  const seek = (time) => new Promise((done) => { video.onseeked = done; video.currentTime = time; });
  await new Promise((done, fail) => {
    video.onloadeddata = done;
    video.onerror = () => fail(video.error.message);
    video.src = URL.createObjectURL(new Blob([bytes], {type: "video/webm"}));
  });
  await seek(1e6);
  const length = video.currentTime;
  const pen = new OffscreenCanvas(video.videoWidth, video.videoHeight).getContext("2d");
  const looks = [];
  for (const time of times) {
    await seek(time);
    pen.drawImage(video, 0, 0);
    looks.push(pen.getImageData(0, 0, video.videoWidth, video.videoHeight).data);
  }
  const changed = looks.slice(1).map((look, k) => look.filter((v, p) => Math.abs(v - looks[k][p]) > 40).length);
  return [length, changed];
}"""


@pytest.mark.nightly
def test_a_controller_that_never_answers_is_stopped_by_its_button_and_the_others_stay(
    browser, tmp_path
):
    (tmp_path / "config-05.grid").write_bytes(CONFIG_5.read_bytes())
    mine = tmp_path / "mine.py"
    mine.write_text(
        "class Stuck:\n def reset(self): return ()\n def act(self, o, m):\n  while True: pass\n"
    )
    with (
        studio_of(tmp_path, named=(f"{mine}:Stuck",), file="config-05.grid") as gate,
        opened(browser, gate) as page,
    ):
        page.keyboard.press("2")
        page.locator("#stop-run").click()
        page.locator("#run-said", has_text="Stopped.").wait_for()
        expect(page.locator("#stop-run")).to_be_hidden()
        expect(page.locator("#run")).to_be_focused()
        page.locator("#play .robots").get_by_label("mine.py:Stuck").uncheck()
        page.locator("#play .robots").get_by_label("thesis-1").check()
        page.locator("#run").click()
        page.locator(".result", has_text="thesis-1").wait_for()
        page.locator("#run-said").wait_for(state="hidden")
        assert page.complaints == []


@pytest.mark.nightly
def test_a_robot_with_options_is_added_by_its_words(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.get_by_label("Steps", exact=True).fill("300")
        page.get_by_label("Another robot, with options").fill("thesis-2+repaired")
        page.keyboard.press("Enter")
        expect(page.get_by_role("checkbox", name="thesis-2+repaired")).to_be_checked()
        page.keyboard.press("Control+Enter")
        names = [
            re.compile(rf"^\S+ {re.escape(name)} ") for name in ("thesis-2", "thesis-2+repaired")
        ]
        expect(page.locator(".result")).to_have_text(names, use_inner_text=True)
        assert page.complaints == []


@pytest.mark.nightly
def test_numbers_and_robots_that_cannot_be_are_refused_at_their_fields(browser, gate):
    with opened(browser, gate) as page:
        page.keyboard.press("2")
        page.get_by_label("Another robot, with options").fill("nope")
        page.keyboard.press("Enter")
        page.locator("#another-fault", has_text="'nope'").wait_for()
        expect(page.get_by_role("checkbox", name="nope")).to_have_count(0)
        page.locator(".result").first.wait_for()
        before = page.locator(".result").all_inner_texts()
        for name, values in (
            ("Steps", ["0", "-5", "1.5"]),
            ("Seed", ["", "1e30"]),
            ("Time step s", ["", "0"]),
        ):
            field = page.locator("#play").get_by_label(name, exact=True)
            for value in values:
                field.fill(value)
                page.keyboard.press("Tab")
                page.locator(f"#{field.get_attribute('id')}-fault").wait_for()
            field.fill("1")
        expect(page.locator(".result")).to_have_text(before, use_inner_text=True)


@pytest.mark.gate
def test_on_a_phone_the_results_are_below_the_picture_and_above_the_list_of_robots(browser, gate):
    phone = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
    with opened(browser, gate, **phone) as page:
        page.get_by_role("link", name="Play").click()
        page.locator(".result").first.wait_for()
        top = {
            part: page.locator(part).first.bounding_box()["y"]
            for part in ("#stage", ".result", ".setup")
        }
        assert top["#stage"] < top[".result"] < top[".setup"]
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
