"""The thesis's simulator in C gives the same bits as the specification in Python and as the
listing.
"""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from sim.thesis.core_calls import ThesisEpisode, ThesisSetup, add_noise, new_rows, signal_map
from tests.helpers import thesis_parts
from tests.reference.sim import thesis_layout as at
from tests.reference.sim import thesis_signal
from tests.reference.sim.stepped_motion import advance
from tests.reference.sim.thesis_episode import thesis_episode
from tests.replay_vectors import random_numbers, read_vectors, setup_of, signal_cells, simulate
from tests.sim.test_thesis_vectors import DATA

VECTORS = {
    vector["id"]: vector
    for name in ("vectors", "demos")
    for _, vector in read_vectors(DATA / f"{name}.jsonl.gz")
}
SIDE = 12
NO_EVENTS = np.zeros((0, 4), np.int64)
WALLS = st.sets(st.tuples(st.integers(1, SIDE - 2), st.integers(1, SIDE - 2)), max_size=25)
PLACES = st.floats(17.0, SIDE * 10 - 17.0)
WAYS = st.floats(-30.0, 30.0)


def touches(x, y, cell_x, cell_y):
    """Ellipse2D.intersects for the 14 px disc and a 10 px cell."""
    near = []
    for centre, cell in ((x, cell_x), (y, cell_y)):
        low = (cell * 10.0 - (centre - 7.0)) / 14.0 - 0.5
        high = low + 10.0 / 14.0
        near.append(low if low > 0 else high if high < 0 else 0.0)
    return near[0] * near[0] + near[1] * near[1] < 0.25


def listed_scan(walls, test, before, unit):
    """Check nine cells like the listing; return where the collision leaves the robot, or None."""
    grid = (int(test[0] / 10), int(test[1] / 10))
    for cell_y in (grid[1] + 1, grid[1], grid[1] - 1):
        if not 0 <= cell_y < SIDE:
            break
        for cell_x in (grid[0] - 1, grid[0], grid[0] + 1):
            if not 0 <= cell_x < SIDE:
                break
            wall = (cell_x, cell_y) in walls or not (
                0 < cell_x < SIDE - 1 and 0 < cell_y < SIDE - 1
            )
            if (touches(*test, cell_x, cell_y) and wall) or max(test) >= SIDE * 10 - 7:
                in_x, in_y = (
                    touches(test[0], before[1], cell_x, cell_y),
                    touches(before[0], test[1], cell_x, cell_y),
                )
                if in_x or in_y:
                    return (
                        before[0] - unit[0] if in_x else test[0],
                        before[1] - unit[1] if in_y else test[1],
                    )
    return None


def listed_advance(walls, x, y, goal_x, goal_y):
    """``checkCollision`` and the clamps, as in the listing."""
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


def walled(walls):
    """A map with walls, all closed."""
    cells = signal_map(SIDE, SIDE, 5, 5)
    for wall in walls:
        cells[wall] = at.WALL
    return cells


@given(WALLS, PLACES, PLACES, WAYS, WAYS)
def test_one_pixel_stepping_is_the_listing_read_plainly(walls, x, y, dx, dy):
    place = (x, y, x + dx, y + dy)
    move = thesis_parts.move(walled(walls), *place, 7.0, 0, 0.0)
    assert (move.x, move.y, bool(move.collision)) == listed_advance(walls, *place)


@given(
    WALLS, PLACES, PLACES, WAYS, WAYS, st.floats(0.5, 10.0), st.integers(0, 7), st.floats(0.0, 1.0)
)
@example({(6, 6), (7, 7)}, 58.0, 75.0, 20.0, -3.0, 7.0, 4, 0.5)
def test_a_move_of_any_disc_is_that_of_the_specification(
    walls, x, y, dx, dy, radius, repairs, friction
):
    cells = walled(walls)
    move = thesis_parts.move(cells, x, y, x + dx, y + dy, radius, repairs, friction)
    ours = (move.x, move.y, bool(move.collision), move.ending, move.before_x, move.before_y)
    assert ours == advance(cells, x, y, x + dx, y + dy, radius, repairs, friction)


def specified(cells, light, events, start, setup, draws, row_count):
    """A run of the specification, in the same form as :func:`seen`."""
    names = setup._asdict()
    arena = at.new_arena(cells, light, events)
    progress = at.new_progress(*start, setup.speed)
    trace = np.zeros((row_count, at.ROW_SIZE))
    thesis_episode(arena, at.Setup(**names), progress, draws, trace)
    counts = progress.counts.tolist()
    found = {
        "ending": counts[at.OUT_ENDING],
        "steps": counts[at.OUT_STEPS],
        "period": counts[at.OUT_PERIOD],
        "collisions": counts[at.OUT_COLLISIONS],
        "activations": counts[at.OUT_ACTIVATIONS],
        "last_new_cell": counts[at.OUT_LAST_NEW_CELL],
        "visited": counts[at.OUT_VISITED],
        "digest": counts[at.OUT_DIGEST] % 2**64,
        "hit": counts[at.OUT_HIT_STEP : at.OUT_HIT_IY + 1],
        "hit_state": counts[at.OUT_HIT_STATE],
        "overlap": counts[at.OUT_OVERLAP_STEP : at.OUT_OVERLAP_IY + 1],
        "overlap_origin": (counts[at.OUT_OVERLAP_BEGAN], counts[at.OUT_OVERLAP_CAUSE]),
        "tunnel": counts[at.OUT_TUNNEL_STEP : at.OUT_TUNNEL_IY + 1],
        "tunnel_origin": (counts[at.OUT_TUNNEL_BEGAN], counts[at.OUT_TUNNEL_CAUSE]),
        "in_wall": counts[at.OUT_IN_WALL_STEP : at.OUT_IN_WALL_IY + 1],
        "path_length": float(progress.sums[at.SUM_PATH]),
        "deepest": float(progress.sums[at.SUM_OVERLAP]),
    }
    return found, trace.tobytes(), arena.cells.tobytes(), arena.visited.tobytes()


def seen(cells, light, events, start, setup, draws, row_count):
    """The same run in C."""
    episode = ThesisEpisode(cells, light, events, start, setup)
    rows = new_rows(row_count)
    episode.go(setup.steps, draws, rows)
    run = episode.run
    names = (
        "ending", "steps", "period", "collisions", "activations", "last_new_cell", "visited", "digest",
    )  # fmt: skip
    found = {name: getattr(run, name) for name in (*names, "path_length", "deepest")}
    for name in ("hit", "overlap", "tunnel", "in_wall"):
        place = getattr(run, name)
        found[name] = [place.step, place.x, place.y]
    found["hit_state"] = run.hit.state
    for name in ("overlap", "tunnel"):
        place = getattr(run, name)
        found[f"{name}_origin"] = (place.began, place.cause) if place.step >= 0 else (0, 0)
    return found, rows.tobytes(), episode.cells.tobytes(), episode.visited.tobytes()


def of_vector(name, **changes):
    """A recording's scenario."""
    vector = VECTORS[name]
    cells, light = signal_cells(vector)
    setup = setup_of(vector)._replace(**changes)
    return (
        cells,
        light,
        NO_EVENTS,
        tuple(map(float, vector["start"])),
        setup,
        random_numbers(vector),
        setup.steps + 1,
    )


@pytest.mark.parametrize("name", ["pub-001", "pub-012", "pub-057", "demo-4"])
def test_a_recorded_run_has_the_bits_of_the_specification(name):
    scenario = of_vector(name, steps=700, find_loop=1)
    assert seen(*scenario) == specified(*scenario)


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
def test_a_run_with_every_kind_of_switch_has_the_bits_of_the_specification(changes):
    scenario = of_vector("demo-1", steps=500, target_x=8, target_y=9, **changes)
    assert seen(*scenario) == specified(*scenario)


@st.composite
def scenarios(draw):
    """A small world with walls and changes, a robot with any options, and a run's arguments."""
    width = draw(st.integers(5, 12))
    height = draw(st.integers(5, 12))
    columns = st.integers(0, width - 1)
    rows = st.integers(0, height - 1)
    inner = st.tuples(st.integers(1, width - 2), st.integers(1, height - 2))
    target = draw(inner)
    start = draw(inner)
    light = signal_map(width, height, *target)
    cells = light.copy()
    for wall in draw(st.sets(st.tuples(columns, rows), max_size=30)) - {target, start}:
        cells[wall] = at.WALL
    changes = draw(
        st.lists(st.tuples(st.integers(1, 60), columns, rows, st.integers(0, 2)), max_size=4)
    )
    events = np.array(sorted(changes), np.int64).reshape(-1, 4)
    share = st.sampled_from([0.0, 0.0, 0.3, 1.0])
    force = st.sampled_from([0.0, 0.0, 0.0002, 0.001])
    setup = ThesisSetup(
        rule=draw(st.integers(1, 3)),
        time_step=draw(st.sampled_from([15.0, 16.0, 60.0, 400.0])),
        sense=draw(st.integers(0, 3)),
        collide_ticks=draw(st.sampled_from([5, 0, 9])),
        drive_ticks=draw(st.sampled_from([2, 0, 6])),
        turn_angle=draw(st.sampled_from([math.pi / 2, 0.4, 2.5])),
        radius=draw(st.sampled_from([7.0, 3.0, 10.0])),
        steps=draw(st.integers(1, 150)),
        find_loop=draw(st.sampled_from([at.NO_LOOP, at.SEEK_LOOP])),
        stop_at_tunnel=draw(st.integers(0, 1)),
        reading=draw(st.integers(0, 7)),
        repairs=draw(st.integers(0, 7)),
        acceleration=draw(force),
        friction=draw(force),
        wall_friction=draw(share),
        slip=draw(share),
        sensor_field=draw(st.sampled_from([0.0, 0.0, 2.0])),
        sensor_noise=draw(share),
        signal=draw(st.integers(0, 2)),
        map_scale=draw(st.sampled_from([1, 1, 2, 3])),
        target_x=target[0],
        target_y=target[1],
        seed=draw(st.integers(0, 2**63)),
    )
    place = (
        start[0] * 10 + draw(st.floats(0, 9)),
        start[1] * 10 + draw(st.floats(0, 9)),
        draw(st.floats(0, 6.3)),
    )
    draws = np.array(draw(st.lists(st.floats(0, 1, exclude_max=True), max_size=12)))
    return cells, light, events, place, setup, draws, draw(st.sampled_from([0, setup.steps + 1]))


@given(scenarios())
def test_any_run_has_the_bits_of_the_specification(scenario):
    assert seen(*scenario) == specified(*scenario)


def test_the_signal_map_and_its_noise_are_those_of_the_specification():
    light = signal_map(16, 16, 3, 9)
    assert light.tobytes() == thesis_signal.signal_map(16, 16, 3, 9).tobytes()
    ours = np.where(light % 7 == 1, np.int32(at.WALL), light)
    theirs = ours.copy()
    add_noise(ours, light)
    thesis_signal.add_noise(theirs, light)
    assert ours.tolist() == theirs.tolist()


@pytest.mark.parametrize("name", ["pub-044", "pub-018"])
def test_a_run_in_pieces_is_the_whole_run(name):
    whole, rows = simulate(
        VECTORS[name], *signal_cells(VECTORS[name]), random_numbers(VECTORS[name]), 1000
    )
    cells, light, events, start, setup, draws, count = of_vector(name, steps=1000)
    episode = ThesisEpisode(cells, light, events, start, setup)
    pieces = new_rows(count)
    for used, until in ((1, 400), (2, 400), (5, 700), (len(draws), 700), (len(draws), 1000)):
        episode.go(until, draws[:used], pieces)
    assert pieces[: len(rows)].tobytes() == rows.tobytes()
    assert episode.run.digest == whole.digest


@pytest.mark.parametrize("name", ["pub-011", "pub-049", "pub-058", "demo-7"])
def test_the_loop_search_finds_the_recorded_period(name):
    cells, light, events, start, setup, draws, _ = of_vector(
        name, steps=60_000, find_loop=at.SEEK_LOOP
    )
    episode = ThesisEpisode(cells, light, events, start, setup)
    episode.go(60_000, draws, new_rows(0))
    assert (episode.run.ending, episode.run.period) == (at.LOOP, VECTORS[name]["period"])


@pytest.mark.parametrize(
    ("cell", "stop", "ending"),
    [((1, 8), 1, at.LIMIT), ((6, 9), 1, at.BURNED), ((6, 9), 0, at.LIMIT)],
    ids=["elsewhere", "on it", "on it, and it keeps going"],
)
def test_debris_only_strikes_where_it_falls(cell, stop, ending):
    cells, light, _, start, setup, draws, _ = of_vector("demo-1", steps=140, stop_at_tunnel=stop)
    episode = ThesisEpisode(cells, light, np.array([[130, *cell, 1]]), start, setup)
    episode.go(140, draws, new_rows(0))
    assert episode.run.deepest > 2.0  # px: the robot is deep in a wall by then
    assert episode.run.ending == ending


@pytest.mark.parametrize(
    "changes",
    [
        {"radius": 11.0}, {"radius": math.nan}, {"time_step": 1e9}, {"time_step": 0.0}, {"slip": math.inf},
        {"friction": -1.0}, {"rule": 4}, {"target_x": 16}, {"map_scale": 0}, {"wall_friction": 1e300},
    ],
    ids=str,
)  # fmt: skip
def test_a_robot_whose_ticks_would_not_end_is_refused(changes):
    scenario = of_vector("pub-050", steps=10, **changes)
    with pytest.raises(ValueError, match="out of its range"):
        seen(*scenario)


def test_a_change_outside_the_grid_is_refused():
    cells, light, _, start, setup, draws, count = of_vector("pub-050", steps=10)
    with pytest.raises(ValueError, match="out of its range"):
        seen(cells, light, np.array([[5, 99, 3, 1]]), start, setup, draws, count)
