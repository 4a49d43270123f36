"""The recorded runs of the thesis's program come out again, bit for bit."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import simulate
from tests.helpers.java_random import java_doubles
from tests.replay_vectors import main, mismatches, read_vectors
from worldgen import CellState, Event, InvalidParameter, InvalidWorld, Pose, Target, Timeline, World

DATA = Path(__file__).parents[1] / "data" / "thesis"
VECTORS = {f"{v['id']}": v for name in ("vectors", "demos") for _, v in read_vectors(DATA / f"{name}.jsonl.gz")}


@pytest.mark.parametrize("name", VECTORS)
def test_a_recorded_run_comes_out_to_the_last_bit(name):
    assert mismatches(VECTORS[name]) == []


def test_the_replay_command_counts_what_matches(tmp_path, capsys):
    good, bad = VECTORS["pub-004"], {**VECTORS["pub-008"], "hash": "0" * 16}
    (tmp_path / "two.jsonl").write_text(json.dumps(good) + "\n" + json.dumps(bad) + "\n")
    assert main([str(tmp_path / "two.jsonl")]) == 1
    assert capsys.readouterr().out.endswith("matched 1 of 2\n")


@pytest.mark.parametrize("text", ["{", "[]", '{"n": 3}', ""])
def test_a_file_that_holds_no_recordings_gives_a_message_not_a_traceback(tmp_path, capsys, text):
    (tmp_path / "odd.jsonl").write_text(text)
    code = main([str(tmp_path / "odd.jsonl")])
    assert (code, capsys.readouterr().err != "") == ((0, False) if text == "" else (2, True))


def test_java_random_has_its_published_first_value():
    assert java_doubles(42, 1) == [0.7275636800328681]


def world_of(vector):
    """A recording's world in our own frame."""
    n, rows = vector["n"], vector["rows"]
    walls = np.array([[c == "#" for c in row] for row in rows])[::-1]
    ty = next(y for y, row in enumerate(rows) if "T" in row)
    tx = rows[ty].index("T")
    x, y, heading = vector["start"]
    centre = (round((tx + 0.5) / 10, 6), round((n - ty - 0.5) / 10, 6))
    start = Pose(x / 100, round((n * 10 - y) / 100, 9), np.pi - heading)
    return World(walls, start, Target(*centre, 0.05))


@pytest.mark.parametrize("name", ["pub-001", "pub-010", "pub-040", "pub-044", "demo-2"])
def test_a_recorded_run_is_the_same_from_a_world(name):
    vector = VECTORS[name]
    controller = {1: "thesis-1", 2: "thesis-2"}[vector["rule"]]
    episode = simulate(world_of(vector), controller, motion="stepped", steps=vector["ticks"])
    tunnels = vector["firstCentreInWall"] >= 0
    expected = ("tunnel", None) if tunnels else (vector["verdict"], vector["hash"])
    assert episode.verdict == expected[0] and expected[1] in (None, episode.trace_digest)


def test_a_recorded_loop_is_proved_with_its_entry_and_period():
    vector = VECTORS["pub-011"]
    episode = simulate(world_of(vector), "turn-left", motion="stepped", steps=20_000)
    assert (episode.evidence["entry"], episode.evidence["period"]) == (vector["loopStart"], vector["period"])
    assert (episode.verdict, episode.trace_digest) == ("loop", vector["hash"])


def test_an_open_border_is_closed_by_the_solid_outside():
    world = world_of(VECTORS["pub-001"])
    inner = replace(
        world,
        walls=world.walls[1:-1, 1:-1],
        start=Pose(0.25, round(world.start.y - 0.1, 9), world.start.heading),
        target=Target(round(world.target.x - 0.1, 9), round(world.target.y - 0.1, 9), 0.05),
    )
    runs = [simulate(w, "turn-right", motion="stepped", steps=2000) for w in (world, inner)]
    assert runs[0].trace_digest == runs[1].trace_digest and runs[0].verdict == runs[1].verdict == "reached"


def empty(**changes):
    return replace(World(np.zeros((12, 12), bool), Pose(0.35, 0.35, 0.0), Target(0.85, 0.85, 0.05)), **changes)


def test_flames_burn_the_thesis_robot():
    timeline = Timeline.of([Event(0.1, 5, 5, CellState.BURNING)])
    episode = simulate(empty(timeline=timeline), "turn-left", motion="stepped")
    assert (episode.verdict, episode.evidence["state"], episode.evidence["cell"]) == ("burned", "burning", [5, 5])


def test_debris_blocks_the_thesis_robot_and_freed_cells_let_it_pass():
    wall = [Event(0.0, ix, 6, CellState.SOLID) for ix in range(12)]
    freed = [Event(3.0, ix, 6, CellState.FREE) for ix in range(12)]
    verdicts = [
        simulate(empty(timeline=Timeline.of(events)), "turn-random", motion="stepped", steps=20_000).verdict
        for events in (wall, wall + freed)
    ]
    assert verdicts[0] != "reached" and verdicts[1] == "reached"


def test_a_robot_wider_than_two_cells_is_refused():
    with pytest.raises(InvalidParameter, match="at most 1 cell: take swept"):
        simulate(empty(robot_radius=0.12), "turn-left", motion="stepped")


def test_a_target_in_a_wall_is_refused():
    walls = np.zeros((12, 12), bool)
    walls[8, 8] = True
    with pytest.raises(InvalidWorld, match=r"target .* lies in a wall cell"):
        simulate(empty(walls=walls), "turn-left", motion="stepped")
