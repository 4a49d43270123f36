"""The pages' scripts: their own tests in Node, and whether they can read the server's data."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.player import drawn_run, drawn_world
from fuzz.player.live import live_world
from fuzz.player.streams import numbers
from sim import simulate
from tests.helpers.bodies import bend, rectangle
from tests.helpers.page_scripts import FOLDER, called, missing_node, run_tests
from tests.helpers.studio import message_of
from worldgen import generate
from worldgen.files.grid import dumps, read_world
from worldgen.files.grid.toml_text import number_text
from worldgen.reach import decide
from worldgen.robot import Pose
from worldgen.timeline import CellState
from worldgen.world import Cut

pytestmark = pytest.mark.skipif(bool(missing_node()), reason=missing_node() or "-")

REPOSITORY = Path(__file__).parents[2]
PLAYER = REPOSITORY / "fuzz" / "player" / "page"


def proved(world):
    return replace(world, certificate=decide(world).certificate)


FAILURE = REPOSITORY / "corpora" / "thesis-faults" / "thesis-1-loop-104.grid"


@pytest.mark.gate
def test_the_pages_scripts_pass_their_own_tests():
    done = run_tests()
    assert done.returncode == 0, done.stdout[-20_000:]
    assert int(re.search(r"^# pass (\d+)$", done.stdout, re.MULTILINE)[1]) >= 170


def test_a_fault_in_a_script_fails_its_tests(tmp_path):
    (tmp_path / "wrong.test.mjs").write_text(
        f"""import {{ test }} from "node:test";
            import "{(FOLDER / "stand_in.mjs").as_uri()}";
            import {{ keyButton }} from "{(PLAYER / "dom.js").as_uri()}";
            const fault = () => {{ throw new Error("here"); }};
            test("a listener that throws", () => keyButton("x", "x", "x", fault).click());
        """
    )
    done = run_tests(tmp_path / "wrong.test.mjs")
    assert done.returncode != 0 and "here" in done.stdout


def test_numbers_of_all_sizes_are_read_as_they_were_packed():
    random = np.random.default_rng(1)
    lists = [np.cumsum(random.integers(-(10**k), 10**k, 50)) for k in (1, 3, 6, 9)] + [
        np.zeros(0, np.int64)
    ]
    read = called(*(["player/decode", "numbersOf", [numbers(values)]] for values in lists))
    assert [list(map(int, one)) for one in read] == [values.tolist() for values in lists]


def test_the_pages_have_the_codes_of_the_states_of_cells():
    script = (PLAYER / "decode.js").read_text("utf-8")
    declared = re.search(r"export const (FREE.*?);", script, re.DOTALL)[1]
    codes = dict(re.findall(r"(\w+) = (\d+)", declared))
    assert {name: int(code) for name, code in codes.items()} == {**CellState.__members__}


@pytest.mark.parametrize("family", ["cave", "fire"])
def test_the_world_that_is_drawn_is_the_one_that_was_packed(family):
    world = generate(family, 3)
    packed = drawn_world(generate(family, 3))
    line = world.timeline
    moments = [0.0, *(1000 * line.times[:40:8])]
    read = called(*(["player/decode", "cellsAt", [packed, moment]] for moment in moments))
    for moment, cells in zip(moments, read, strict=True):
        known = world.walls.astype(np.int64)
        over = 1000 * line.times <= moment
        for ix, iy, state in zip(line.ix[over], line.iy[over], line.states[over], strict=True):
            known[iy, ix] = state
        assert cells == known.ravel().tolist()


def test_the_robot_is_drawn_where_it_was():
    world = read_world(FAILURE)
    episode = simulate(world, world.failure.controller, motion="stepped", steps=400, record=True)
    run = drawn_run(episode, world.cell_size)
    steps = range(0, episode.steps + 1, 17)
    places = called(*(["player/decode", "poseAt", [run, step]] for step in steps))
    for step, place in zip(steps, places, strict=True):
        x = episode.trace.x[step] / world.cell_size
        y = episode.trace.y[step] / world.cell_size
        assert (place["x"], place["y"]) == pytest.approx((x, y), abs=1 / 512)


@pytest.mark.gate
@pytest.mark.parametrize("family", ["cave", "fire"])
def test_a_world_that_the_page_sends_back_is_the_one_that_it_got(family):
    message = message_of(generate(family, 3))
    (there,) = called(["studio/shared/world_message", "worldOf", [message]])
    assert called(["studio/shared/world_message", "messageOf", [there]]) == [message]


def edited(world):
    """A world in which a wall, the start and the radius were changed, and what a page has of it."""
    walls = world.walls.copy()
    walls[1, 1] = not walls[1, 1]
    start = Pose(world.start.x / 3, 1e-05, -0.0)
    robot = replace(world.robots[0], start=start)
    if robot.is_disc:
        robot = replace(robot, radius=world.robot_radius / 3)
    changed = replace(world.bare, walls=walls, robots=(robot, *world.robots[1:]))
    columns = zip(("times", "ix", "iy", "state"), world.timeline.columns, strict=True)
    return changed, {
        "width": world.width,
        "height": world.height,
        "cells": walls.ravel().astype(int).tolist(),
        "cell_size": world.cell_size,
        "robot_radius": changed.robot_radius,
        "robot_speed": world.robot_speed,
        "start": [start.x, start.y, start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        "events": {key: column.tolist() for key, column in columns} if world.is_dynamic else None,
        "source": dumps(world).decode(),
    }


def proof_of(world):
    """The certificate of a world as the core in a page gives it."""
    proof = world.certificate
    if isinstance(proof, Cut):
        cut = {"cells": proof.cells.tolist(), "clearance": proof.clearance}
        return {"witness": None, "cut": cut}
    names = ("t", "x", "y", "heading") if proof.headings is not None else ("t", "x", "y")
    columns = (proof.times, proof.x, proof.y, proof.headings)
    witness = {name: column.tolist() for name, column in zip(names, columns, strict=False)}
    return {"witness": witness | {"clearance": proof.clearance}, "cut": None}


@pytest.mark.parametrize(
    "world",
    [
        replace(generate("trap", 3), robot_speed=0.1 + 0.2),
        generate("fire", 3),
        read_world(FAILURE),
        read_world(REPOSITORY / "corpora" / "thesis-faults" / "thesis-3-breach.grid"),
        proved(bend(rectangle(0.9, 0.62))),
    ],
    ids=["trap", "fire", "failure", "cut", "body"],
)
def test_a_page_writes_the_file_that_python_writes(world):
    changed, page = edited(world)
    record = world.failure
    run = None
    if record is not None:
        record = replace(record, verdict="stalled", trace_digest="00" * 8, details={})
        evidence = {"box": [3, 4], "last_new_cell": 7, "witness_multiple": 50.25}
        parameters = {**record.parameters, "steps": 123}
        record = replace(record, parameters=parameters, evidence=evidence)
        names = {"verdict": "stalled", "digest": record.trace_digest, "budget": 123}
        run = {**names, "evidence": evidence}
    (text,) = called(["player/edit/grid_text", "gridText", [page, proof_of(world), run]])
    expected = replace(changed, certificate=world.certificate, failure=record)
    assert text == dumps(expected).decode()


@pytest.mark.parametrize(
    "world", [generate("fire", 3), read_world(FAILURE)], ids=["fire", "failure"]
)
def test_a_page_reads_the_world_that_it_edits(world):
    source = dumps(world).decode()
    (page,) = called(["player/edit/grid_text", "editedOf", [live_world(world), source, "a"]])
    _, known = edited(world)
    same = ("width", "height", "cell_size", "robot_speed", "target", "events", "source")
    assert {name: page[name] for name in same} == {name: known[name] for name in same}
    assert page["cells"] == world.walls.ravel().astype(int).tolist()
    assert page["start"] == [world.start.x, world.start.y, world.start.heading]


def test_a_page_writes_numbers_as_python_does():
    random = np.random.default_rng(2)
    drawn = (random.standard_normal(200) * 10.0 ** random.integers(-20, 20, 200)).tolist()
    some = [0.0, -0.0, 5.0, 1e15, 1e16, 123456789012345680.0, 1e-4, 9.9e-5, 1e22, 0.1, -2.5, *drawn]
    _, page = edited(generate("trap", 3))
    zeros = [0] * len(some)
    page["events"] = {"times": some, "ix": zeros, "iy": zeros, "state": zeros}
    (text,) = called(["player/edit/grid_text", "gridText", [page, None, None]])
    lines = text.partition("%timeline\n")[2].splitlines()[:-1]
    assert lines == [f"{number_text(value, 'it')} 0 0 free" for value in some]
