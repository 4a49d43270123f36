"""The thesis's simulator has the same bits compiled, interpreted, and as a plain reading of the listing."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.kernels import stepped_motion, thesis_signal
from sim.kernels import thesis_layout as at
from sim.kernels.thesis_episode import thesis_episode
from tests.helpers.twins import twin
from tests.replay_vectors import random_numbers, read_vectors, signal_cells, simulate
from tests.sim.test_thesis_vectors import DATA

VECTORS = {
    vector["id"]: vector for name in ("vectors", "demos") for _, vector in read_vectors(DATA / f"{name}.jsonl.gz")
}
SIDE = 12
WALLS = st.sets(st.tuples(st.integers(1, SIDE - 2), st.integers(1, SIDE - 2)), max_size=25)
PLACES = st.floats(17.0, SIDE * 10 - 17.0)
WAYS = st.floats(-30.0, 30.0)


def fresh(vector, **changes):
    """Arena, setup, start, draws and an empty trace for a recording."""
    cells, light = signal_cells(vector)
    setup = at.Setup(
        rule=vector["rule"], time_step=float(vector["timeSize"]), sense=at.sensor_cells(vector["sensorRange"])
    )
    steps = changes.get("steps", 0)
    progress = at.new_progress(*map(float, vector["start"]), steps=steps)
    trace = np.zeros((steps + 1, at.ROW_SIZE))
    return at.new_arena(cells, light), setup._replace(**changes), progress, random_numbers(vector), trace


def touches(x, y, cell_x, cell_y):
    """Ellipse2D.intersects for the 14 px disc and a 10 px cell."""
    near = []
    for centre, cell in ((x, cell_x), (y, cell_y)):
        low = (cell * 10.0 - (centre - 7.0)) / 14.0 - 0.5
        high = low + 10.0 / 14.0
        near.append(low if low > 0 else high if high < 0 else 0.0)
    return near[0] * near[0] + near[1] * near[1] < 0.25


def listed_scan(walls, test, before, unit):
    """The listing's look at nine cells: where the collision leaves the robot, or None."""
    grid = (int(test[0] / 10), int(test[1] / 10))
    for cell_y in (grid[1] + 1, grid[1], grid[1] - 1):
        if not 0 <= cell_y < SIDE:
            break
        for cell_x in (grid[0] - 1, grid[0], grid[0] + 1):
            if not 0 <= cell_x < SIDE:
                break
            wall = (cell_x, cell_y) in walls or not (0 < cell_x < SIDE - 1 and 0 < cell_y < SIDE - 1)
            if (touches(*test, cell_x, cell_y) and wall) or max(test) >= SIDE * 10 - 7:
                in_x, in_y = touches(test[0], before[1], cell_x, cell_y), touches(before[0], test[1], cell_x, cell_y)
                if in_x or in_y:
                    return (before[0] - unit[0] if in_x else test[0], before[1] - unit[1] if in_y else test[1])
    return None


def listed_advance(walls, x, y, goal_x, goal_y):
    """``checkCollision`` and the clamps, read off the listing."""
    way = (goal_x - x, goal_y - y)
    length = math.sqrt(way[0] * way[0] + way[1] * way[1])
    unit = (1 / length * way[0], 1 / length * way[1]) if length else (math.nan, math.nan)
    gone, before, end = unit, (x, y), None
    while end is None and (abs(gone[0]) < abs(way[0]) or abs(gone[1]) < abs(way[1])):
        test = (x + gone[0], y + gone[1])
        end = listed_scan(walls, test, before, unit)
        gone, before = (gone[0] + unit[0], gone[1] + unit[1]), before if end else test
    place = [min(max(value, 17.0), SIDE * 10 - 17.0) for value in end or before]
    return place[0], place[1], end is not None


@given(WALLS, PLACES, PLACES, WAYS, WAYS)
def test_one_pixel_stepping_is_the_listing_read_plainly(walls, x, y, dx, dy):
    cells = thesis_signal.signal_map(SIDE, SIDE, 5, 5)
    for wall in walls:
        cells[wall] = at.WALL
    place = (x, y, x + dx, y + dy)
    assert stepped_motion.advance(cells, *place, 7.0, 0, 0.0)[:3] == listed_advance(walls, *place)


@pytest.mark.parametrize("name", ["pub-001", "pub-012", "pub-057", "demo-4"])
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")  # wrapping is what fingerprints want
def test_a_run_has_the_same_bits_compiled_and_interpreted(name):
    runs = []
    for episode in (thesis_episode, twin(thesis_episode)):
        arena, setup, progress, draws, trace = fresh(VECTORS[name], steps=700, find_loop=1)
        episode(arena, setup, progress, draws, trace)
        runs.append((trace.tobytes(), progress.counts.tolist(), progress.sums.tobytes(), arena.visited.tobytes()))
    assert runs[0] == runs[1]


@pytest.mark.parametrize(
    "changes",
    [
        {"reading": 7, "repairs": 7, "acceleration": 0.001, "friction": 0.002},
        {"reading": 3, "signal": at.BLOCKED, "sensor_field": 2.0, "wall_friction": 0.5},
        {"reading": 2, "signal": at.WEAKENED, "sensor_noise": 0.3, "slip": 0.2, "seed": 2**62},
        {"reading": 4, "map_scale": 3, "repairs": 2, "sense": 2},
    ],
    ids=["forces", "sight", "chance", "coarse"],
)
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")  # wrapping is what the generator wants
def test_a_run_with_every_kind_of_switch_has_the_same_bits_compiled_and_interpreted(changes):
    runs = []
    for episode in (thesis_episode, twin(thesis_episode)):
        arena, setup, progress, draws, trace = fresh(VECTORS["demo-1"], steps=500, target_x=8, target_y=9, **changes)
        episode(arena, setup, progress, draws, trace)
        runs.append((trace.tobytes(), progress.counts.tolist(), progress.sums.tobytes()))
    assert runs[0] == runs[1]


def test_the_signal_map_and_its_noise_are_the_same_interpreted():
    compiled, interpreted = signal_cells(VECTORS["pub-050"])[1], twin(thesis_signal.signal_map)(16, 16, 3, 9)
    assert thesis_signal.signal_map(16, 16, 3, 9).tolist() == interpreted.tolist()
    walled = [np.where(compiled % 7 == 1, np.int32(at.WALL), compiled) for _ in range(2)]
    thesis_signal.add_noise(walled[0], compiled)
    twin(thesis_signal.add_noise)(walled[1], compiled)
    assert walled[0].tolist() == walled[1].tolist()


@pytest.mark.parametrize("name", ["pub-044", "pub-018"])
def test_a_run_in_pieces_is_the_whole_run(name):
    whole = simulate(VECTORS[name], *signal_cells(VECTORS[name]), random_numbers(VECTORS[name]), 1000)
    arena, setup, progress, draws, _ = fresh(VECTORS[name])
    rows = []
    for used, steps in ((1, 400), (2, 400), (5, 700), (len(draws), 700), (len(draws), 1000)):
        progress.counts[at.TRACE_START] = progress.counts[at.OUT_STEPS]
        piece = np.zeros((1001, at.ROW_SIZE))
        thesis_episode(arena, setup._replace(steps=steps), progress, draws[:used], piece)
        rows.extend(piece[1 : progress.counts[at.OUT_STEPS] - progress.counts[at.TRACE_START] + 1])
    assert np.array(rows).tobytes() == whole[1][1:].tobytes()
    assert progress.counts[at.OUT_DIGEST] == whole[0].counts[at.OUT_DIGEST]


@pytest.mark.parametrize("name", ["pub-011", "pub-049", "pub-058", "demo-7"])
def test_the_loop_search_finds_the_recorded_period(name):
    arena, setup, progress, draws, trace = fresh(VECTORS[name], steps=60_000, find_loop=1)
    thesis_episode(arena, setup, progress, draws, trace)
    assert (progress.counts[at.OUT_ENDING], progress.counts[at.OUT_PERIOD]) == (at.LOOP, VECTORS[name]["period"])


@pytest.mark.parametrize(("cell", "ending"), [((1, 8), at.LIMIT), ((6, 9), at.BURNED)], ids=["elsewhere", "on it"])
def test_debris_only_strikes_where_it_falls(cell, ending):
    arena, setup, progress, draws, trace = fresh(VECTORS["demo-1"], steps=140)
    arena = at.new_arena(arena.cells, arena.light, np.array([[130, *cell, 1]]))
    thesis_episode(arena, setup, progress, draws, trace)
    assert progress.sums[at.SUM_OVERLAP] > 2.0  # px: it has worked itself into a wall by then
    assert progress.counts[at.OUT_ENDING] == ending
