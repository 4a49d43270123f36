"""The pages' scripts: their own tests in Node, and whether they can read the server's data."""

import re
from pathlib import Path

import numpy as np
import pytest

from fuzz.player import drawn_run, drawn_world
from fuzz.player.streams import numbers
from sim import simulate
from tests.helpers.page_scripts import FOLDER, called, missing_node, run_tests
from tests.helpers.studio import message_of
from worldgen import generate
from worldgen.files.grid import read_world
from worldgen.timeline import CellState

pytestmark = pytest.mark.skipif(bool(missing_node()), reason=missing_node() or "-")

REPOSITORY = Path(__file__).parents[2]
PLAYER = REPOSITORY / "fuzz" / "player" / "page"
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
