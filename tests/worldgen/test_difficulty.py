"""Metrics of worlds with known values."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.difficulty import METRICS, Metrics, measure, with_metrics
from worldgen.difficulty.path import angle
from worldgen.errors import FormatError, InvalidWorld
from worldgen.files.grid import dumps, loads, world_digest
from worldgen.generation import generate
from worldgen.world import Pose, Target, Witness, World


def drawn(*rows, radius=0.4, path=None):
    """A world of 1 m cells, top row first; S and G are the centres of their cells."""
    cells = np.array([list(row) for row in reversed(rows)])
    places = {letter: np.argwhere(cells == letter)[0][::-1] + 0.5 for letter in "SG"}
    start, target = (tuple(map(float, places[letter])) for letter in "SG")
    points = [start, target] if path is None else path
    x, y = np.array(points, float).T
    certificate = Witness(np.arange(len(points), dtype=float) * 10, x, y, radius)
    return World(
        cells == "#", Pose(*start), Target(*target, 0.5), 1.0, radius, certificate=certificate
    )


def test_every_metric_is_described_and_every_description_is_of_a_metric():
    assert list(METRICS) == list(Metrics.__dataclass_fields__)


def test_a_straight_way_has_detour_1_and_no_turns():
    found = measure(drawn("#######", "#S...G#", "#######"))
    assert (found.length, found.detour, found.tortuosity, found.turns) == (4.0, 1.0, 1.0, 0.0)


def test_a_way_round_a_corner_turns_by_a_right_angle():
    found = measure(
        drawn("####", "#.G#", "#.##", "#S##", "####", path=[(1.5, 1.5), (1.5, 3.5), (2.5, 3.5)])
    )
    assert (found.length, found.turns, found.detour) == (3.0, 1.5708, 1.34164)
    assert found.turning == 0.702481


@pytest.mark.parametrize("degrees", range(0, 181, 9))
def test_angles_are_those_of_the_arc_tangent(degrees):
    dot, cross = (
        round(10**6 * math.cos(math.radians(degrees))),
        round(10**6 * math.sin(math.radians(degrees))),
    )
    assert angle(dot, cross) == pytest.approx(math.atan2(cross, dot), abs=1e-14)


def test_a_world_without_a_way_has_no_metrics_that_need_one():
    found = measure(replace(drawn("#####", "#S#G#", "#####"), certificate=None))
    assert found.solid == 0.866667
    assert (found.length, found.detour, found.turns) == (None, None, None)


def test_start_on_the_target_leaves_out_what_goes_by_the_straight_line():
    world = drawn("####", "#SG#", "####")
    found = measure(replace(world, target=Target(1.5, 1.5, 0.5), certificate=None))
    assert (found.detour, found.turning, found.tortuosity) == (None, None, None)


def test_measured_headers_survive_writing_and_leave_the_digest_alone():
    world = generate("trap", 3)
    measured = with_metrics(world)
    assert loads(dumps(measured)) == measured
    assert measured.provenance.metrics == measure(world).as_dict() != {}
    assert world_digest(measured) == world_digest(world)


@pytest.mark.parametrize(
    ("value", "came"), [('"high"', "text"), ("true", "true or false"), ("[1]", "a list")]
)
def test_a_metric_in_a_file_is_a_number(value, came):
    text = (
        dumps(generate("corridor", 1))
        .decode()
        .replace("\n\n[cert", f"\nmetrics = {{ detour = {value} }}\n\n[cert")
    )
    with raises(FormatError, "wrong-type", line=12, what="provenance.metrics.detour"):
        loads(text.encode(), "w.grid")


def test_a_metric_that_is_no_number_is_not_written():
    world = generate("corridor", 1)
    spoilt = replace(world, provenance=replace(world.provenance, metrics={"detour": "high"}))
    with raises(InvalidWorld, "not-a-number", name="detour", kind="str"):
        dumps(spoilt)
