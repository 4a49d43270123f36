"""Dubins's and Reeds and Shepp's shortest paths, by closed forms and symmetries."""

import itertools
import math

import numpy as np
import pytest

from worldgen import Pose
from worldgen.reach.car.curves import curves

ORIGIN = Pose(0.0, 0.0, 0.0)


def shortest(start, end, radius=1.0, *, reverse):
    return curves(start, end, radius, reverse=reverse)[0].length


def driven(start, curve, radius):
    """Return the pose at the end of a curve, by the circles that it follows."""
    x, y, heading = start.x, start.y, start.heading
    for steer, amount in curve.parts:
        if not steer:
            x += amount * math.cos(heading)
            y += amount * math.sin(heading)
            continue
        centre = (x - steer * radius * math.sin(heading), y + steer * radius * math.cos(heading))
        heading += steer * amount
        x = centre[0] + steer * radius * math.sin(heading)
        y = centre[1] - steer * radius * math.cos(heading)
    return x, y, heading


def some_pairs(count=300):
    rng = np.random.default_rng(7)
    for _ in range(count):
        reach = 10.0 ** rng.uniform(-1, 1)
        ends = [(*rng.uniform(-reach, reach, 2), rng.uniform(-math.pi, math.pi)) for _ in range(2)]
        yield [Pose(*(float(value) for value in end)) for end in ends]


@pytest.mark.parametrize("reverse", [False, True])
def test_every_curve_ends_at_the_goal(reverse):
    for start, end in some_pairs():
        found = curves(start, end, 0.7, reverse=reverse)
        assert found
        for curve in found:
            x, y, heading = driven(start, curve, 0.7)
            assert (x, y) == pytest.approx((end.x, end.y), abs=1e-9)
            assert math.remainder(heading - end.heading, math.tau) == pytest.approx(0, abs=1e-9)
        assert reverse or all(amount >= 0 for curve in found for _, amount in curve.parts)


@pytest.mark.parametrize(
    ("end", "dubins", "reeds_shepp"),
    [
        (Pose(3.0, 0.0, 0.0), 3.0, 3.0),
        (Pose(0.0, 2.0, math.pi), math.pi, math.pi),
        (Pose(1.0, 1.0, math.pi / 2), math.pi / 2, math.pi / 2),
        (Pose(-3.0, 0.0, 0.0), 2 * math.pi + 3.0, 3.0),
        # A turn on the spot takes three arcs of a third each, forwards, backwards, forwards.
        (Pose(0.0, 0.0, math.pi), 7 * math.pi / 3, math.pi),
        (Pose(0.0, 6.0, math.pi), math.pi + 4.0, math.pi + 4.0),
    ],
    ids=["ahead", "u-turn", "quarter", "behind", "on-the-spot", "wide-u-turn"],
)
def test_closed_forms(end, dubins, reeds_shepp):
    assert shortest(ORIGIN, end, reverse=False) == pytest.approx(dubins, abs=1e-9)
    assert shortest(ORIGIN, end, reverse=True) == pytest.approx(reeds_shepp, abs=1e-9)


@pytest.mark.parametrize("reverse", [False, True])
def test_mirrored_and_scaled_pairs_have_curves_as_long(reverse):
    for start, end in some_pairs():
        length = shortest(start, end, reverse=reverse)
        mirrored = [Pose(pose.x, -pose.y, -pose.heading) for pose in (start, end)]
        assert shortest(*mirrored, reverse=reverse) == pytest.approx(length, rel=1e-9)
        scaled = [Pose(5 * pose.x, 5 * pose.y, pose.heading) for pose in (start, end)]
        assert shortest(*scaled, 5.0, reverse=reverse) == pytest.approx(5 * length, rel=1e-9)


def test_a_car_that_may_reverse_goes_back_as_it_came_and_never_farther_than_one_that_may_not():
    for start, end in some_pairs():
        length = shortest(start, end, reverse=True)
        assert shortest(end, start, reverse=True) == pytest.approx(length, rel=1e-9)
        assert length <= shortest(start, end, reverse=False) + 1e-9


@pytest.mark.parametrize("reverse", [False, True])
def test_no_detour_through_a_third_pose_is_shorter(reverse):
    pairs = list(some_pairs())
    for (start, end), (middle, _) in itertools.pairwise(pairs):
        detour = shortest(start, middle, reverse=reverse) + shortest(middle, end, reverse=reverse)
        assert shortest(start, end, reverse=reverse) <= detour + 1e-9
