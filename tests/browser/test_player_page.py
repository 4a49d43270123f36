"""Replay pages of the player in Debian's Chromium.

Walls that the robot enters, the memory's map, long paths, films.
"""

import base64
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from fuzz.player import drawn_run, drawn_world, replay_page
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.motion import MOTIONS
from tests.helpers.browser import eventually, expect
from worldgen.files.grid import read_world
from worldgen.world import Pose, Target, World

FAULTS = Path(__file__).parents[2] / "corpora" / "thesis-faults"
RED = (192, 0, 24)  # --pierced


def room(speed):
    walls = np.zeros((10, 14), np.bool_)
    walls[2:8, 7] = True
    return World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.1), robot_speed=speed)


def endless_room():
    """A world in which a robot drives until its budget ends, because its target is in a wall."""
    walls = np.zeros((10, 14), np.bool_)
    walls[3:6, 11:14] = True
    return World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.01), robot_speed=2.0)


def page_of(browser, folder, world, controller, *, density=1, **settings):
    """An opened replay page, at its end, on a screen with this many pixels per CSS pixel."""
    robot, episode = driven(world, controller, **settings)
    page = browser.new_page(viewport={"width": 900, "height": 700}, device_scale_factor=density)
    open_replay(page, folder, world, robot)
    page.keyboard.press("End")
    return page, episode


def driven(world, controller, **settings):
    """A robot as a replay page contains it, and its episode."""
    episode = simulate(world, controller, record=True, **settings)
    motion = MOTIONS.get(settings.get("motion", "swept"))
    run = drawn_run(episode, world.cell_size, motion=motion, controller=CONTROLLERS.get(controller))
    robot = {"name": controller, "verdict": episode.verdict, "why": "", "steps": episode.steps}
    robot |= {
        "time": episode.time,
        "path": episode.path_length,
        "collisions": episode.collisions,
        "digest": "-",
    }
    return robot | {"run": run, "sensors": None}, episode


def open_replay(page, folder, world, *robots):
    path = folder / "replay.html"
    path.write_bytes(replay_page("replay", drawn_world(world), list(robots)))
    page.goto(path.as_uri())


def shown(page):
    data = page.evaluate("document.querySelector('#stage').toDataURL()")
    return np.asarray(
        Image.open(io.BytesIO(base64.b64decode(data.partition(",")[2]))).convert("RGB"), np.int64
    )


def red(page):
    """Return how many pixels have the colour of a wall that the robot enters."""
    return int((np.abs(shown(page) - RED).max(axis=2) < 12).sum())


def thesis_failure(name):
    world = read_world(FAULTS / name)
    failure = world.failure
    return (
        replace(world, failure=None),
        failure.controller,
        {"motion": failure.motion, "steps": 3000},
    )


@pytest.mark.gate
def test_a_fast_robot_s_walls_are_red_once_it_is_in_them(browser, tmp_path):
    page, episode = page_of(
        browser, tmp_path, room(20.0), "turn-left", motion="endpoint", steps=300
    )
    assert episode.verdict in ("tunnel", "overlap") and red(page) > 200
    page.keyboard.press("Home")
    assert red(page) < 100  # a dashed frame: it is in the future


@pytest.mark.nightly
def test_a_thesis_robot_s_tunnel_is_red_and_its_touched_walls_are_not(browser, tmp_path):
    world, controller, settings = thesis_failure("thesis-2-slide.grid")
    page, episode = page_of(browser, tmp_path, world, controller, **settings)
    assert episode.verdict in ("tunnel", "overlap") and red(page) > 200
    before = red(page)
    page.keyboard.press("u")  # touched walls have their own colour
    assert red(page) == pytest.approx(before, rel=0.1)


@pytest.mark.nightly
def test_the_memory_s_map_is_a_layer_of_its_own(browser, tmp_path):
    page, _ = page_of(browser, tmp_path, room(2.0), "mapper")
    with_map = shown(page)
    page.get_by_label("Memory").uncheck()
    assert (shown(page) != with_map).any()
    page.keyboard.press("m")
    assert (shown(page) == with_map).all()
    expect(page.locator("#instruments")).to_contain_text("doing")


@pytest.mark.nightly
def test_a_long_way_is_drawn_alike_forwards_and_at_once(browser, tmp_path):
    page, _ = page_of(browser, tmp_path, endless_room(), "random-walk", steps=12_000)
    at_once = shown(page)
    page.keyboard.press("Home")
    for step in (4_000, 9_000):
        page.locator("#scrub").fill(str(step))
    page.keyboard.press("End")
    assert np.abs(shown(page) - at_once).max() <= 40


def follow(page):
    """Follows the robot near the end of its path, with much of the path in view."""
    page.locator("#scrub").fill("9000")
    for key in "r-":
        page.keyboard.press(key)


@pytest.mark.nightly
def test_a_long_way_that_is_followed_is_where_it_is_when_drawn_anew(browser, tmp_path):
    page, _ = page_of(browser, tmp_path, endless_room(), "random-walk", steps=12_000)
    follow(page)
    for _ in range(6):
        page.keyboard.press("ArrowRight")
    followed = shown(page)
    for key in "+-":
        page.keyboard.press(key)
    anew = shown(page)
    page.get_by_label("Trail").uncheck()
    assert np.abs(followed - anew).mean() < np.abs(shown(page) - anew).mean() / 10


@pytest.mark.nightly
def test_a_long_way_is_at_the_same_place_on_a_finer_screen(browser, tmp_path):
    pages = [
        page_of(browser, tmp_path, endless_room(), "random-walk", steps=12_000, density=k)[0]
        for k in (1, 2)
    ]
    for page in pages:
        follow(page)
    coarse, fine = map(shown, pages)
    height, width = coarse.shape[:2]
    fine = fine[: 2 * height, : 2 * width].reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
    pages[0].get_by_label("Trail").uncheck()
    assert np.abs(fine - coarse).mean() < np.abs(shown(pages[0]) - coarse).mean() / 3


@pytest.mark.nightly
def test_a_film_can_be_played_and_its_end_is_not_its_beginning(browser, tmp_path):
    page, _ = page_of(browser, tmp_path, room(2.0), "mapper")
    page.locator(".save summary").click()
    with page.expect_download() as download:
        page.locator(".save button", has_text="Film").click()
    film = base64.b64encode(Path(download.value.path()).read_bytes()).decode()
    blank = browser.new_page()
    width, height, changed, length = blank.evaluate(_LOOK_AT, film)
    canvas = page.evaluate(
        "(({width, height}) => [width, height])(document.querySelector('#stage'))"
    )
    assert [width, height] == canvas and changed > 50 and length > 0.5


_LOOK_AT = """async (film) => {
  const video = document.createElement("video");
  video.muted = true;
  const bytes = Uint8Array.from(atob(film), (c) => c.charCodeAt(0));
  video.src = URL.createObjectURL(new Blob([bytes], {type: "video/webm"}));
  await new Promise((done, fail) => { video.onloadeddata = done; video.onerror = () => fail(video.error.message); });
  const canvas = new OffscreenCanvas(video.videoWidth, video.videoHeight), pen = canvas.getContext("2d");
  const look = () => {
    pen.drawImage(video, 0, 0);
    return pen.getImageData(0, 0, canvas.width, canvas.height).data;
  };
  let first = null;
  video.requestVideoFrameCallback(() => (first = look()));
  await video.play();
  await new Promise((done) => { video.onended = done; });
  const last = look();
  let changed = 0;
  for (let k = 0; k < first.length; k += 4) changed += Math.abs(first[k] - last[k]) > 40;
  return [video.videoWidth, video.videoHeight, changed, video.currentTime];
}"""


@pytest.mark.gate
def test_the_timeline_is_zoomed_with_its_marks_whether_or_not_the_plots_are_shown(
    browser, tmp_path
):
    world, controller, settings = thesis_failure("thesis-1-loop-104.grid")
    page, _ = page_of(browser, tmp_path, world, controller, **settings)
    last = ends_of_bar(page)[1]
    width = width_of_period(page)
    page.locator(".plots-part").evaluate("part => part.open = false")
    page.keyboard.press(">")
    low, high = ends_of_bar(page)
    assert 0 < low < high == last
    expect(page.locator(".below-timeline .view")).to_have_text(re.compile(f"^steps {low:,} to "))
    assert width_of_period(page) > 1.2 * width
    # The wheel zooms too, and the bar follows the time.
    page.locator("#scrub").hover()
    page.mouse.wheel(0, -100)
    eventually(page, lambda: ends_of_bar(page)[0], lambda first: first > low)
    page.keyboard.press("Home")
    assert ends_of_bar(page)[0] == 0 and ends_of_bar(page)[1] < last
    page.keyboard.press("|")
    assert ends_of_bar(page) == (0, last)
    assert width_of_period(page) == width
    page.close()


def ends_of_bar(page):
    """Return the first and the last step that the scrub bar shows."""
    bar = page.locator("#scrub")
    return int(bar.get_attribute("min")), int(bar.get_attribute("max"))


def width_of_period(page):
    """Return the width of the period's mark above the scrub bar, in its own units."""
    return float(page.locator(".scrub .period").get_attribute("width"))


@pytest.mark.gate
@pytest.mark.parametrize("height", [1050, 560], ids=["a-wall-a-pixel", "several-walls-a-pixel"])
def test_a_large_maze_has_no_pattern_of_its_own(browser, tmp_path, height):
    page, _ = page_of(browser, tmp_path, large_maze(), "turn-right", steps=5)
    page.set_viewport_size({"width": 1280, "height": height})
    page.reload()
    page.wait_for_timeout(500)
    picture = shown(page).mean(axis=2)
    middle, side = [size // 2 for size in picture.shape], min(picture.shape) // 4
    part = picture[tuple(slice(at - side, at + side) for at in middle)]
    window = np.hanning(2 * side)
    window = window[:, None] * window
    waves = np.abs(np.fft.fft2((part - part.mean()) * window)) * 2 / window.sum()
    across = np.fft.fftfreq(2 * side)
    # waves of 3 to 100 pixels, which are wider than what the maze consists of
    wide = np.abs(np.hypot(across[:, None], across) - 0.17) < 0.16
    assert waves[wide].max() < 3.2
    page.close()


def large_maze():
    """A world of 1000 x 1000 cells: one wall in three, with gaps."""
    gaps = np.random.default_rng(1).random((1000, 1000)) < 0.5
    walls = np.zeros((1000, 1000), np.bool_)
    walls[::3] = gaps[::3]
    walls[:, ::3] |= gaps[:, ::3]
    walls[1:3, 1:3] = walls[-5:, -5:] = False
    return World(walls, Pose(0.15, 0.15, 0.0), Target(99.8, 99.8, 0.05), robot_radius=0.04)
