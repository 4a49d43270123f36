"""The recorded runs of the thesis's program are reproduced, bit for bit."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import simulate
from tests.helpers.java_random import java_doubles
from tests.helpers.raising import raises
from tests.replay_vectors import main, mismatches, read_vectors
from worldgen import CellState, Event, InvalidParameter, InvalidWorld, Pose, Target, Timeline, World

DATA = Path(__file__).parents[1] / "data" / "thesis"
VECTORS = {
    f"{v['id']}": v
    for name in ("vectors", "demos")
    for _, v in read_vectors(DATA / f"{name}.jsonl.gz")
}


@pytest.mark.gate
@pytest.mark.parametrize("name", VECTORS)
def test_a_recorded_run_comes_out_to_the_last_bit(name):
    assert mismatches(VECTORS[name]) == []


def test_the_replay_command_counts_what_matches(tmp_path, capsys):
    good, bad = VECTORS["pub-004"], {**VECTORS["pub-008"], "hash": "0" * 16}
    (tmp_path / "two.jsonl").write_text(json.dumps(good) + "\n" + json.dumps(bad) + "\n")
    assert main([str(tmp_path / "two.jsonl")]) == 1
    assert capsys.readouterr().out.endswith("matched 1 of 2\n")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n": 10**9}, "n is 1000000000; it must be a whole number from 3 to 2000"),
        ({"maxTicks": "many"}, "maxTicks is 'many'; it must be a whole number"),
        ({"noise": 1}, "noise is 1; it must be true or false"),
        ({"rows": ["#"] * 30}, "rows must be 30 strings of 30 characters"),
        ({"rows": ["." * 30] * 30}, "rows hold 0 targets 'T'"),
        ({"rows": ["." * 30] * 29 + ["T" + "." * 29]}, "rows are open at the border"),
        ({"rows": ["x" * 30] * 30}, "rows hold 'x'"),
        ({"start": [1e9, 35.0, 4.5]}, "x and y must be in [0, 300) px"),
        ({"start": [35.0, 35.0, float("nan")]}, "finite numbers"),
        ({"start": [35.0, 35.0, 1e9]}, "must be within 823550 rad of 0"),
        ({"rule": 3}, "give seed, draws or both"),
        ({"rule": 3, "draws": [1.5]}, "draws must be a list of numbers in [0, 1)"),
        ({"cp": [[1]]}, "cp must be a list of checkpoints"),
        ({"hash": None}, "hash is None; a recording says how the run went"),
        ({"maxPen": "deep"}, "maxPen is 'deep'; it must be a number"),
    ],
    ids=lambda value: None if isinstance(value, str) else ",".join(value),
)
def test_a_line_that_is_no_recording_gets_a_sentence_and_the_rest_is_replayed(
    tmp_path, capsys, changes, message
):
    odd = tmp_path / "odd.jsonl"
    odd.write_text(
        json.dumps({**VECTORS["pub-004"], **changes}) + "\n" + json.dumps(VECTORS["pub-008"]) + "\n"
    )
    code, printed = main([str(odd)]), capsys.readouterr()
    assert (code, printed.out) == (2, "matched 1 of 2\n")
    assert message in printed.err and printed.err.startswith(f"{odd}:1: cannot be replayed: ")


@pytest.mark.parametrize(
    "text", [b"{", b"[]", b"3", b"[" * 100_000, b"", b"\xff"], ids=lambda text: repr(text[:9])
)
def test_a_file_that_holds_no_recordings_gives_a_message_not_a_traceback(tmp_path, capsys, text):
    (tmp_path / "odd.jsonl").write_bytes(text)
    assert main([str(tmp_path / "odd.jsonl")]) == 2
    assert "odd.jsonl" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("cellCrc32", "00000000", "cellCrc32 715a72fb, recorded 00000000"),
        ("ticks", 236, "ticks 237, recorded 236"),
        ("collideActivations", 7, "collideActivations 8, recorded 7"),
        ("firstCross", 5, "firstCross -1, recorded 5"),
        ("maxPen", 0.5, "maxPen 0.0, recorded 0.5"),
        ("seed", 1, "the seed does not give the recorded draws"),
        ("draws", [0.9], "draws: "),
    ],
)
def test_what_differs_from_a_recording_is_said(key, value, message):
    assert any(message in line for line in mismatches({**VECTORS["pub-021"], key: value}))


def test_a_wrong_number_in_a_checkpoint_is_said():
    vector = VECTORS["pub-021"]
    points = [vector["cp"][0], [*vector["cp"][1][:5], 0.1, *vector["cp"][1][6:]]]
    (line,) = mismatches({**vector, "cp": points})
    assert line.startswith("checkpoint 2: ")


def test_the_seed_alone_gives_the_draws():
    vector = {key: value for key, value in VECTORS["pub-060"].items() if key != "draws"}
    assert mismatches(vector) == []


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
    assert (episode.evidence.entry, episode.evidence.period) == (
        vector["loopStart"],
        vector["period"],
    )
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
    assert (
        runs[0].trace_digest == runs[1].trace_digest
        and runs[0].verdict == runs[1].verdict == "reached"
    )


def empty(**changes):
    return replace(
        World(np.zeros((12, 12), bool), Pose(0.35, 0.35, 0.0), Target(0.85, 0.85, 0.05)), **changes
    )


def test_flames_burn_the_thesis_robot():
    timeline = Timeline.of([Event(0.1, 5, 5, CellState.BURNING)])
    episode = simulate(empty(timeline=timeline), "turn-left", motion="stepped")
    assert (episode.verdict, episode.evidence.state, episode.evidence.cell) == (
        "burned",
        "burning",
        (5, 5),
    )


def test_debris_blocks_the_thesis_robot_and_freed_cells_let_it_pass():
    wall = [Event(0.0, ix, 6, CellState.SOLID) for ix in range(12)]
    freed = [Event(3.0, ix, 6, CellState.FREE) for ix in range(12)]
    verdicts = [
        simulate(
            empty(timeline=Timeline.of(events)), "turn-random", motion="stepped", steps=20_000
        ).verdict
        for events in (wall, wall + freed)
    ]
    assert verdicts[0] != "reached" and verdicts[1] == "reached"


def test_a_robot_wider_than_two_cells_is_refused():
    with raises(InvalidParameter, "robot-larger-than-cell"):
        simulate(empty(robot_radius=0.12), "turn-left", motion="stepped")


def test_a_target_in_a_wall_is_refused():
    walls = np.zeros((12, 12), bool)
    walls[8, 8] = True
    with raises(InvalidWorld, "target-in-wall"):
        simulate(empty(walls=walls), "turn-left", motion="stepped")
