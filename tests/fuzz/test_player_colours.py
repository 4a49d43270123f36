"""The colours of all pictures: contrast, and distances in CIELAB as seen with colour blindness."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from build_tools import page_marks
from sim.verdict import Verdict
from worldgen.render.marks import DARK, LIGHT, MARKS, SPECIFICATION, hue, mix
from worldgen.render.trail_parts import pierced_ground

THEMES = [pytest.param(LIGHT, id="light"), pytest.param(DARK, id="dark")]
ROOT = Path(__file__).parents[2]
ROBOTS = [name for name in SPECIFICATION.colours if name.startswith("robot-")]
# What a mark is drawn on; the others are drawn on the floor.
ON_WALLS = {"touched": "wall", "named": "named-edge"}
NOT_MARKS = {"floor", "grid", "wall", "burnt"}
PLAIN = 25.0  # a difference that is obvious at a glance, even for thin lines
# Source: Web Content Accessibility Guidelines 2.1, 1.4.3 and 1.4.11.
TEXT = 4.5
GRAPHICS = 3.0

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


def linear(colour):
    shares = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def lab(colour, seen):
    ratios = TO_XYZ @ np.clip(np.array(SEEN[seen]) @ linear(colour), 0, 1) / WHITE
    x, y, z = np.where(ratios > 216 / 24389, np.cbrt(ratios), (24389 / 27 * ratios + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def apart(one, other, seen):
    return float(np.linalg.norm(lab(one, seen) - lab(other, seen)))


def contrast(one, other):
    lights = sorted(float(np.array(TO_XYZ[1]) @ linear(colour)) for colour in (one, other))
    return (lights[1] + 0.05) / (lights[0] + 0.05)


def too_near(theme, seen, pairs):
    found = {(a, b): apart(hue(a, theme), hue(b, theme), seen) for a, b in pairs}
    return {pair: distance for pair, distance in found.items() if distance < PLAIN}


def too_faint(theme, pairs, least):
    found = {(a, b): round(contrast(hue(a, theme), hue(b, theme)), 2) for a, b in pairs}
    return {pair: ratio for pair, ratio in found.items() if ratio < least}


def grounds():
    """The colours of marks and robots, each with what it is drawn on."""
    marks = {mark.colour for name, mark in MARKS.items() if name not in NOT_MARKS}
    return [(name, ON_WALLS.get(name, "floor")) for name in sorted({*marks, *ROBOTS})]


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", THEMES)
def test_what_is_drawn_stands_out_from_what_lies_below_it(theme, seen):
    pairs = [("wall", "floor"), ("pierced", "wall"), ("fire", "wall"), *grounds()]
    assert too_near(theme, seen, pairs) == {}


@pytest.mark.parametrize("theme", THEMES)
def test_marks_have_a_contrast_of_3_to_1_to_what_they_are_drawn_on(theme):
    assert too_faint(theme, [("wall", "floor"), *grounds()], GRAPHICS) == {}


@pytest.mark.parametrize("theme", THEMES)
def test_words_have_a_contrast_of_4_5_to_1(theme):
    verdicts = {colour for colour, _ in SPECIFICATION.verdicts.values()}
    words = {"ink", "quiet", "link", *verdicts}
    pairs = [(word, page) for word in sorted(words) for page in ("paper", "panel", "raised")]
    assert too_faint(theme, pairs, TEXT) == {}


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", THEMES)
def test_the_path_that_exists_is_told_from_the_one_that_is_driven(theme, seen):
    """One is dashed; still, nobody should need that."""
    assert too_near(theme, seen, [("loop", "target")]) == {}
    pieces = [
        mix(hue("floor", theme), hue("loop", theme), share)
        for share in (MARKS["approach"].fade[-1], 1.0)
    ]
    assert apart(*pieces, seen) >= 15.0


@pytest.mark.parametrize("seen", SEEN)
@pytest.mark.parametrize("theme", THEMES)
def test_a_verdict_is_known_by_its_colour_or_by_its_sign(theme, seen):
    kinds = dict(SPECIFICATION.verdicts.values())
    for one, other in combinations(kinds, 2):
        if apart(hue(one, theme), hue(other, theme), seen) < PLAIN:
            assert kinds[one] != kinds[other], (one, other)


@pytest.mark.parametrize("theme", THEMES)
def test_six_robots_colours_are_told_apart_by_the_usual_eye(theme):
    assert too_near(theme, "usual", combinations(ROBOTS, 2)) == {}


@pytest.mark.parametrize("seen", SEEN)
def test_stripes_of_a_pierced_wall_stand_out_from_what_is_below_them_and_that_from_a_wall(seen):
    assert apart(hue("pierced"), pierced_ground(), seen) >= PLAIN
    assert apart(pierced_ground(), hue("wall"), seen) >= PLAIN


def test_each_verdict_has_a_sign_and_a_colour():
    assert [*SPECIFICATION.verdicts] == [verdict.value for verdict in Verdict]


def test_each_part_of_the_specification_names_what_there_is():
    named = {mark.colour for mark in MARKS.values()} | {*SPECIFICATION.series}
    named |= {colour for colour, _ in SPECIFICATION.verdicts.values()}
    assert named <= {*SPECIFICATION.colours}
    assert {*SPECIFICATION.legend} == {name for name, mark in MARKS.items() if mark.label}


def test_the_pages_have_the_marks_of_the_specification():
    """If this fails, run ``python -m build_tools.page_marks``."""
    assert page_marks.STYLE.read_text("utf-8") == page_marks.page_style()
    assert page_marks.MODULE.read_text("utf-8") == page_marks.page_module()


def test_no_colour_is_written_elsewhere():
    literal = re.compile(r"#[0-9a-fA-F]{6}\b|#[0-9a-fA-F]{3}\b(?![-\w])|\b(rgb|hsl)a?\([\d\s]")
    made = {page_marks.STYLE, page_marks.MODULE}
    found = {}
    for package in ("worldgen", "sim", "fuzz", "worldgen_plugins"):
        for path in (ROOT / package).rglob("*"):
            if path.suffix not in {".py", ".js", ".css", ".html"} or path in made:
                continue
            lines = path.read_text("utf-8").splitlines()
            if wrong := [line.strip() for line in lines if literal.search(line)]:
                found[str(path.relative_to(ROOT))] = wrong
    assert found == {}
