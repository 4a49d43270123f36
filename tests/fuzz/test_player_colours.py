"""The player's colours, as seen with colour blindness: distances in CIELAB."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from sim.verdict import Verdict
from worldgen.render import palette
from worldgen.render.palette import mix

CSS = (Path(__file__).parents[2] / "fuzz/player/page/player.css").read_text("utf-8")
ROBOTS = [f"robot-{number}" for number in range(6)]
ON_FLOOR = [
    "start",
    "target",
    "way",
    "loop",
    "breach",
    "pierced",
    "memory",
    "fire",
    "touched",
    *ROBOTS,
]
ON_WALLS = ["touched", "pierced", "fire"]
PLAIN = 25.0  # a difference that is obvious at a glance, even for thin lines

# Complete deficiency, in linear RGB. Source: Machado, Oliveira, Fernandes, A Physiologically-based
# Model for Simulation of Color Vision Deficiency, 2009, table 1.
SEEN = {
    "usual": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.01182, 0.04294, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.3039],
    ],
}
TO_XYZ = [
    [0.4124564, 0.3575761, 0.1804375],
    [0.2126729, 0.7151522, 0.072175],
    [0.0193339, 0.119192, 0.9503041],
]
WHITE = [0.95047, 1.0, 1.08883]


def colours_of(theme):
    """Return the named colours of a theme; the dark theme overrides the light one's."""
    blocks = {"light": r":root \{(.*?)\}", "dark": r':root\[data-theme="dark"\] \{(.*?)\}'}
    named = {
        name: dict(re.findall(r"--([\w-]+): (#\w{6})", re.search(block, CSS, re.S)[1]))
        for name, block in blocks.items()
    }
    return named["light"] | (named["dark"] if theme == "dark" else {})


def lab(colour, seen):
    shares = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)
    ratios = TO_XYZ @ np.clip(np.array(SEEN[seen]) @ linear, 0, 1) / WHITE
    x, y, z = np.where(ratios > 216 / 24389, np.cbrt(ratios), (24389 / 27 * ratios + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def too_near(theme, seen, pairs, least):
    named = colours_of(theme)
    apart = {
        (a, b): float(np.linalg.norm(lab(named[a], seen) - lab(named[b], seen))) for a, b in pairs
    }
    return {pair: distance for pair, distance in apart.items() if distance < least}


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_what_is_drawn_stands_out_from_what_lies_below_it(theme, seen):
    pairs = [
        ("wall", "floor"),
        *((name, "floor") for name in ON_FLOOR),
        *((name, "wall") for name in ON_WALLS),
    ]
    assert too_near(theme, seen, pairs, PLAIN) == {}


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_loop_is_told_from_the_way_into_it(theme, seen):
    assert too_near(theme, seen, [("loop", "way")], PLAIN) == {}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_six_robots_colours_are_told_apart_by_the_usual_eye(theme):
    assert too_near(theme, "usual", combinations(ROBOTS, 2), PLAIN) == {}


def apart(one, other, seen):
    return float(np.linalg.norm(lab(one, seen) - lab(other, seen)))


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_stripes_of_a_pierced_wall_stand_out_from_what_is_below_them_and_that_from_a_wall(
    theme, seen
):
    script = (Path(__file__).parents[2] / "fuzz/player/page/picture/pierced.js").read_text("utf-8")
    named = colours_of(theme)
    ground = named["wall"]
    for layer, share in re.findall(r"\[colours\.(floor|pierced), (0\.\d+)\]", script):
        ground = mix(ground, named[layer], float(share))
    assert ground != named["wall"]
    assert (
        apart(named["pierced"], ground, seen) >= PLAIN
        and apart(ground, named["wall"], seen) >= PLAIN
    )


@pytest.mark.parametrize("seen", SEEN)
def test_so_they_do_in_pictures_that_are_saved(seen):
    assert apart(palette.PIERCED, palette.PIERCED_GROUND, seen) >= PLAIN
    assert apart(palette.PIERCED_GROUND, palette.WALL, seen) >= PLAIN


def test_each_verdict_has_a_sign_and_a_colour():
    script = (Path(__file__).parents[2] / "fuzz/player/page/dom.js").read_text("utf-8")
    signs = script[script.index("const SIGNS") :].partition("};")[0]
    assert re.findall(r'"([\w-]+)":', signs) == [verdict.value for verdict in Verdict]
    assert set(re.findall(r'\[data-verdict="([\w-]+)"\]', CSS)) >= {*map(str, Verdict)}


def test_the_page_s_scripts_use_as_many_robot_colours_as_its_style_has():
    script = (Path(__file__).parents[2] / "fuzz/player/page/picture/pen.js").read_text("utf-8")
    (count,) = re.findall(r"`robot-\$\{\(number - 1\) % (\d+)\}`", script)
    assert int(count) == len(ROBOTS) == len({*re.findall(r"--(robot-\d+):", CSS)})
