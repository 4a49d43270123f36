"""The comparison's table, as served: the cells of ``worldgen compare``, one after another."""

import shutil
from pathlib import Path

import pytest

from sim.compare.comparison import NamedWorld, compare
from sim.compare.report import describe_detail
from sim.scenario import Scenario
from tests.helpers.studio import message_of, page_of, studio_of
from worldgen import generate
from worldgen.files.grid import read_world

CORPORA = Path(__file__).parents[2] / "corpora"
ROBOTS = ["turn-right", "bug2"]
SETUP = {"motion": "swept", "time_step": 0.015, "seed": 0, "options": {}, "steps": 3000}


@pytest.fixture(scope="module")
def gate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    shutil.copy(CORPORA / "thesis/config-05.grid", folder)
    (folder / "broken.grid").write_text("no world\n")
    with studio_of(folder) as gate:
        yield gate


def ask(page, worlds, controllers=ROBOTS, **changes):
    message = {**SETUP, "controllers": controllers, "worlds": worlds, "seeds": 3}
    return page.ask("compare", **(message | changes))


def cells_of(said):
    cells = [part for part in said["parts"] if "column" in part]
    return {(part["row"], part["column"]): part for part in cells}


@pytest.mark.gate
def test_every_cell_is_that_of_the_command(gate):
    worlds_sent = [
        {"file": "config-05.grid"},
        {"family": "trap", "seed": "7"},
        {"world": message_of(generate("corridor", 3))},
    ]
    worlds = [
        read_world(CORPORA / "thesis/config-05.grid"),
        generate("trap", 7),
        generate("corridor", 3),
    ]
    with page_of(gate) as page:
        said = ask(page, worlds_sent)
    expected = compare(
        [NamedWorld(str(row), world) for row, world in enumerate(worlds)],
        {name: Scenario.parse(name, motion="swept", time_step=0.015) for name in ROBOTS},
        seeds=3,
        steps=3000,
    )
    found = cells_of(said)
    for row, cells in enumerate(expected.cells):
        for column, cell in enumerate(cells):
            part = found[row, column]
            assert (part["verdict"], part["detail"]) == (cell.verdict, describe_detail(cell))
            assert (part["steps"], part["time"]) == (cell.steps, cell.time)
    assert len({part["verdict"] for part in found.values()}) > 1
    totals = [(total["reached"], total["runs"]) for total in said["answer"]["totals"]]
    assert totals == [(total.reached, total.runs) for total in expected.totals()]


def test_a_robot_with_chance_runs_with_each_seed(gate):
    with page_of(gate) as page:
        said = ask(page, [{"family": "trap", "seed": "7"}], ["turn-random", "turn-right"])
    chance, certain = (cells_of(said)[0, column] for column in (0, 1))
    assert (chance["runs"], certain["runs"]) == (3, 1)


def test_a_world_that_cannot_be_read_costs_its_own_row_only(gate):
    worlds = [{"file": "broken.grid"}, {"file": "../outside.grid"}, {"family": "trap", "seed": "7"}]
    with page_of(gate) as page:
        said = ask(page, worlds)
    rows = [part for part in said["parts"] if "column" not in part and "best" not in part]
    assert [part.get("error", {}).get("code", "") for part in rows[:2]].count("") == 0
    assert rows[1]["error"]["code"] == "outside-of-folder"
    assert said["answer"]["rows"] == 1 and (2, 0) in cells_of(said)


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"worlds": []}, "wrong-message"),
        ({"controllers": ["turn-right"] * 13}, "wrong-message"),
        ({"seeds": 0}, "wrong-message"),
        ({"controllers": ["/tmp/mine.py:Robot"]}, "not-named"),
        ({"controllers": ["behaviours:avoid,/tmp/mine.py:Mine"]}, "not-named"),
    ],
)
def test_what_cannot_be_compared_is_refused(gate, changes, code):
    with page_of(gate) as page:
        said = ask(page, **({"worlds": [{"family": "trap", "seed": "7"}]} | changes))
    assert said["error"]["code"] == code


@pytest.mark.gate
def test_compositions_of_registered_behaviours_need_not_be_named(gate):
    name = "behaviours:avoid+angle=2,follow,wander"
    with page_of(gate) as page:
        found = cells_of(ask(page, [{"family": "trap", "seed": "7"}], [name], seeds=1))
        message = {**SETUP, "world": message_of(generate("trap", 7)), "controllers": [name]}
        run = page.ask("run", **message)["parts"][1]
    assert found[0, 0]["verdict"] == run["verdict"] and found[0, 0]["steps"] == run["steps"]
