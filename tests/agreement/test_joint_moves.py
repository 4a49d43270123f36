"""Joint moves: the core against plain Python, bit for bit, and against shapely."""

import math

import numpy as np
import pytest
import shapely

from tests.helpers.fleets import at_times
from tests.helpers.joint_moves import crowds, draw_displacements
from tests.reference.sim.fleet_motion import Disc, joint_move

# Lattice units: far above shapely's rounding errors, far below a unit.
TOLERANCE = 1e-6


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_joint_move_is_its_plain_python(motion, friction):
    moves = 0
    for rng, robots in crowds(range(12), motion=motion, wall_friction=friction):
        for _ in range(25):
            by = draw_displacements(rng, len(robots.settings))
            discs = [
                Disc(x, y, dx, dy, int(own.clear_sq), int(own.reach))
                for (x, y), (dx, dy), own in zip(robots.places(), by, robots.settings, strict=True)
            ]
            collided = joint_move(
                robots.cells, discs, robots.clear_sq, friction, swept=motion == "swept"
            )
            found = robots.move(by)
            assert [(disc.chain, disc.contact) for disc in discs] == found
            assert robots.collision() == min(collided, default=None)
            moves += len(by)
    assert moves > 1_000


def stretches(paths, starts):
    """Yield the straight pieces of a joint move: the ends of each robot's piece, which all take the
    same time.
    """
    times = np.array(sorted({0, 1 << 32, *(time for path, _ in paths for *_, time in path)}))
    sides = []
    for (path, _), start in zip(paths, starts, strict=True):
        own = np.array([0, *(time for *_, time in path)])
        sides.append(at_times(own, np.array([start, *(p[:2] for p in path)], float), times))
    for k in range(len(times)):
        yield [(before[k], after[k]) for before, after in sides]
        if k + 1 < len(times):
            yield [(after[k], before[k + 1]) for before, after in sides]


def joint_moves_cut_nothing(seeds, moves_each):
    moves = 0
    contacts = 0
    for rng, robots in crowds(seeds):
        # Cells outside the grid are solid.
        height, width = robots.cells.shape
        walls = np.pad(robots.cells, 1, constant_values=1)
        tree = shapely.STRtree(
            [
                shapely.box(x * 1024, y * 1024, (x + 1) * 1024, (y + 1) * 1024)
                for y in range(-1, height + 1)
                for x in range(-1, width + 1)
                if walls[y + 1, x + 1]
            ]
        )
        radii = [math.sqrt(int(own.clear_sq)) for own in robots.settings]
        for _ in range(moves_each):
            starts = robots.places()
            paths = robots.move(draw_displacements(rng, len(starts)))
            moves += len(starts)
            contacts += sum(normal != (0.0, 0.0) for _, normal in paths)
            for (path, _), start, radius in zip(paths, starts, radii, strict=True):
                way = [start, *((x, y) for x, y, _ in path)]
                line = shapely.LineString([*way, way[-1]])
                nearest = tree.geometries[tree.nearest(line)]
                assert shapely.distance(nearest, line) >= radius - TOLERANCE
            for pieces in stretches(paths, starts):
                for other in range(len(pieces)):
                    for one in range(other):
                        begin = pieces[one][0] - pieces[other][0]
                        end = pieces[one][1] - pieces[other][1]
                        way = shapely.LineString([begin, end])
                        far = math.sqrt(robots.clear_sq[one, other])
                        assert shapely.distance(way, shapely.Point(0, 0)) >= far - TOLERANCE
    return moves, contacts


def test_no_joint_move_cuts_a_wall_or_a_robot():
    moves, contacts = joint_moves_cut_nothing(range(8), 40)
    assert moves > 1_000 and contacts > 200


@pytest.mark.nightly
def test_none_of_a_hundred_thousand_joint_moves_cuts_a_wall_or_a_robot():
    moves, contacts = joint_moves_cut_nothing(range(1_000, 1_200), 110)
    assert moves > 100_000 and contacts > 20_000
