"""The page about the file format is enough to check a cut: a checker written from it agrees."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.reference.worldgen.cut_by_the_page import proves
from worldgen.files.grid import dumps, read_world
from worldgen.reach import BLOCKED, check_certificate, decide
from worldgen.timeline import CellState, Timeline
from worldgen.world import Cut, Pose, Target, World

SHIPPED = sorted(
    path
    for path in (Path(__file__).parents[2] / "corpora").rglob("*.grid")
    if b"\n%cut\n" in path.read_bytes()
)


def damaged(world):
    """Yield the world with cuts that differ from its own in one thing."""
    cut = world.certificate
    cells = cut.cells.tolist()
    for n in range(len(cells)):
        if len(cells) > 1:
            yield replace(world, certificate=replace(cut, cells=cells[:n] + cells[n + 1 :]))
        for dx, dy in ((1, 0), (0, 1), (-1, 0), (2, 2)):
            ix, iy = cells[n]
            moved = [*cells[:n], [ix + dx, iy + dy], *cells[n + 1 :]]
            yield replace(world, certificate=replace(cut, cells=moved))
        ix, iy = cells[n]
        if 0 <= ix < world.width and 0 <= iy < world.height:
            walls = world.walls.copy()
            walls[iy, ix] = False
            yield replace(world, walls=walls)
            opens = Timeline.of([(1.0, ix, iy, CellState.FREE)])
            yield replace(world, timeline=opens)
    yield replace(world, certificate=replace(cut, clearance=world.robot_radius))
    yield replace(world, certificate=replace(cut, clearance=cut.clearance / 2))
    yield replace(world, robot_radius=0.3 * world.robot_radius)
    yield replace(world, start=Pose(world.target.x, world.target.y), target=world.target)


def agree(world):
    """Return True if both checkers say the same of a world's cut."""
    return proves(dumps(world).decode()) == check_certificate(world).valid


def test_cuts_are_shipped():
    assert len(SHIPPED) >= 5


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_cut_proves_what_the_page_says(path):
    text = path.read_text()
    assert proves(text)
    others = [*damaged(read_world(path))]
    assert all(map(agree, others))
    assert sum(not check_certificate(other).valid for other in others) > len(others) / 2


def random_world(seed):
    """Return a small world with arbitrary walls, start, target and robot."""
    rng = np.random.default_rng(seed)
    width, height = rng.integers(1, 10, 2).tolist()
    walls = rng.random((height, width)) < rng.choice((0.1, 0.35, 0.6))
    place = [round(float(rng.uniform(0, side * 0.1)), 3) for side in (width, height) * 2]
    radius = float(rng.choice((0.03, 0.05, 0.07, 0.12)))
    reach = float(rng.choice((0.001, 0.05, 0.15)))
    # In every other world, walls separate a free start from a free target.
    if seed % 2 and min(width, height) > 5:
        place = [0.1 * (ix + 0.5) for ix in (1, 1, width - 2, height - 2)]
        walls |= np.add.outer(np.arange(height), np.arange(width)) == (width + height) // 2
        walls[:3, :3] = walls[-3:, -3:] = False
        radius, reach = 0.07, 0.05
    return World(walls, Pose(*place[:2]), Target(*place[2:], reach), robot_radius=radius)


@pytest.mark.gate
@pytest.mark.parametrize("first", range(0, 90, 30))
def test_both_checkers_agree_on_the_cuts_of_arbitrary_worlds_and_on_damaged_ones(first):
    lengths = []
    for seed in range(first, first + 30):
        world = random_world(seed)
        decision = decide(world)
        if decision.result == BLOCKED and isinstance(decision.certificate, Cut):
            blocked = replace(world, certificate=decision.certificate)
            assert proves(dumps(blocked).decode()), seed
            lengths.append(len(decision.certificate.cells))
            assert all(map(agree, [*damaged(blocked)][:: 1 + len(lengths) % 3])), seed
    assert 1 in lengths and max(lengths) > 1


def room(start, target, *, radius=0.07, solid=(), timeline=()):
    walls = np.zeros((6, 6), bool)
    for ix, iy in solid:
        walls[iy, ix] = True
    return World(
        walls,
        Pose(*start),
        Target(*target),
        robot_radius=radius,
        timeline=Timeline.of(timeline),
        certificate=Cut(np.array([(3, 3)]), 0.0),
    )


@pytest.mark.parametrize(
    ("world", "holds"),
    [
        pytest.param(room((0.25, 0.35), (0.05, 0.05, 0.01), solid=[(3, 3)]), True, id="start-covered"),
        pytest.param(room((0.1, 0.1), (0.35, 0.35, 0.04), solid=[(3, 3)]), True, id="target-covered"),
        pytest.param(room((0.1, 0.1), (0.35, 0.35, 0.15), solid=[(3, 3)]), False, id="target-too-wide"),
        pytest.param(room((0.1, 0.1), (0.35, 0.35, 0.04)), False, id="free-cell"),
        pytest.param(room((0.1, 0.1), (0.5, 0.5, 0.01), radius=0.31), True, id="grid-too-small"),
        pytest.param(room((0.1, 0.1), (0.5, 0.5, 0.01), solid=[(3, 3)]), False, id="separates-nothing"),
        pytest.param(
            room((0.25, 0.35), (0.05, 0.05, 0.01), timeline=[(0.0, 3, 3, CellState.BURNING)]),
            True,
            id="start-burns",
        ),
        pytest.param(
            room((0.1, 0.1), (0.35, 0.35, 0.04), solid=[(3, 3)], timeline=[(2.0, 3, 3, CellState.FREE)]),
            False,
            id="opens-later",
        ),
    ],
)  # fmt: skip
def test_a_single_cell_proves_what_the_page_says(world, holds):
    assert proves(dumps(world).decode()) is holds
    assert check_certificate(world).valid is holds


def test_a_cut_of_several_robots_is_about_the_one_that_it_names():
    world = room((0.1, 0.1), (0.35, 0.35, 0.04), solid=[(3, 3)])
    first, *_ = world.robots
    other = replace(first, start=Pose(0.5, 0.1), target=Target(0.1, 0.5, 0.05), radius=0.04)
    for number, holds in ((1, False), (2, True)):
        cut = replace(world.certificate, robot=number)
        two = replace(world, robots=(other, first), certificate=cut)
        assert proves(dumps(two).decode()) is holds
        assert check_certificate(two).valid is holds
    assert math.isclose(other.radius, 0.04)
