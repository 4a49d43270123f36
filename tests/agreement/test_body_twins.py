"""The prover's exact tests of a body give the results of their reference, and of shapely."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from sim.runners.core_calls import headings
from tests.helpers.bodies import rectangle
from tests.reference.worldgen import bodies as reference
from worldgen.errors import InvalidWorld
from worldgen.lattice import TURN, UNIT
from worldgen.reach.body.core_calls import Body, BodyPose, cosines
from worldgen.robot import convex_footprint

SIZE = 0.1


def test_prover_and_simulator_turn_bodies_by_the_same_numbers():
    assert np.array_equal(cosines(), headings()[:TURN])


@st.composite
def questions(draw):
    """Walls, a body among them, a pose, a place and a turn."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    walls = rng.random((9, 11)) < draw(st.sampled_from([0.03, 0.1, 0.3]))
    kind = draw(st.sampled_from(["rectangle", "cells", "random"]))
    if kind == "random":
        count = int(rng.integers(3, 12))
        points = rng.uniform(-0.25, 0.25, (count, 2)) + rng.uniform(-0.1, 0.1, 2)
        ring = shapely.convex_hull(shapely.multipoints(points))
        corners = shapely.get_coordinates(ring)[:-1].tolist()
    elif kind == "rectangle":
        corners = rectangle(rng.uniform(0.05, 0.5), rng.uniform(0.05, 0.3), rng.uniform(0, 0.2))
    else:
        # Sides that are whole cells touch walls exactly.
        corners = rectangle(0.1 * rng.integers(1, 5), 0.1 * rng.integers(1, 3))
    try:
        body = Body(walls, convex_footprint(corners), SIZE)
    except InvalidWorld:
        assume(False)
    # Places on borders of half cells, and on any.
    step = draw(st.sampled_from([UNIT // 2, 1]))
    x, y, to_x, to_y = (int(v) // step * step for v in rng.integers(UNIT, 8 * UNIT, 4))
    heading = draw(st.sampled_from([0, TURN // 4, TURN // 8])) + int(rng.integers(0, 40))
    heading = heading if draw(st.booleans()) else int(rng.integers(0, TURN))
    if draw(st.booleans()):
        to_x = x
    return walls, body, BodyPose(x, y, heading), (to_x, to_y), int(rng.integers(-60, 60))


@given(question=questions())
def test_a_body_is_clear_where_the_reference_says_so(question):
    walls, body, pose, place, turn = question
    corners = body.corners.tolist()
    hull = reference.corners_at(corners, *pose)
    assert body.is_clear(pose) == reference.is_clear(walls, hull)
    assert body.may_move(pose, *place) == reference.may_move(walls, corners, pose, *place)
    assert body.may_turn(pose, turn) == reference.may_turn(walls, corners, pose, turn)


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(3))
def test_shapely_agrees_on_random_poses_of_random_bodies(seed):
    rng = np.random.default_rng(seed)
    for _ in range(300):
        walls = rng.random((9, 11)) < 0.1
        iy, ix = np.nonzero(np.pad(walls, 3, constant_values=True))
        solid = shapely.union_all(shapely.box(ix - 3, iy - 3, ix - 2, iy - 2))
        shapely.prepare(solid)
        body = Body(walls, convex_footprint(rectangle(*rng.uniform(0.05, 0.5, 2))), SIZE)
        count = 110
        poses = np.stack(
            [rng.integers(UNIT, n * UNIT, count) for n in (10, 8)] + [rng.integers(0, TURN, count)],
            axis=1,
        )
        angles = poses[:, 2] * (2 * math.pi / TURN)
        c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
        cx, cy = body.corners.T
        rings = np.stack([poses[:, :1] + c * cx - s * cy, poses[:, 1:2] + s * cx + c * cy], 2)
        shapes = shapely.polygons(rings / UNIT)
        # Within a millionth of a cell, floats cannot tell.
        sure = shapely.intersects(solid, shapely.buffer(shapes, -1e-6))
        maybe = shapely.intersects(solid, shapely.buffer(shapes, 1e-6))
        for pose, is_met, may_meet in zip(poses.tolist(), sure, maybe, strict=True):
            clear = body.is_clear(BodyPose(*pose))
            assert not (clear and is_met)
            assert clear or may_meet


def test_a_turn_that_touches_all_the_way_is_tested_heading_by_heading():
    # A square of 2 cells turns in a room of 3 cells: its corners come within 0.086 cells of it.
    walls = np.zeros((3, 3), np.bool_)
    body = Body(walls, rectangle(0.2, 0.2), SIZE)
    middle = BodyPose(3 * UNIT // 2, 3 * UNIT // 2, 0)
    assert body.may_turn(middle, TURN // 2)
    # Half a cell lower it touches the floor, and cannot begin to turn.
    low = BodyPose(3 * UNIT // 2, UNIT, 0)
    assert body.is_clear(low)
    assert not body.may_turn(low, 1)
    assert not body.may_turn(low, -1)
