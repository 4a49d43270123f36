"""A coverage task ends when every reachable cell has been visited, and not before."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fuzz.evidence_checks import check_evidence
from sim import Command, RunOptions, simulate
from sim.drawing.picture import trail_of
from sim.episode import prepare
from sim.evidence import CoveredEvidence
from sim.motion import MOTIONS
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, InvalidWorld, generate, read_world, write_world
from worldgen.reach import coverage_tour, decide, reachable_cells
from worldgen.world import Pose, Target

FAMILIES = ["trap", "maze", "rooms", "forest", "cave", "corridor"]
SWEEP = """
import math
from sim import Command
from worldgen.reach import coverage_tour
class Sweep:
    senses = ("x", "y", "heading")
    def reset(self, world):
        self.tour = coverage_tour(world)
        return (0.0,)
    def act(self, seen, memory):
        at = int(memory[0])
        if math.dist(self.tour[at], (seen.x, seen.y)) < 0.0002 and at + 1 < len(self.tour):
            at += 1
        x, y = self.tour[at]
        turn = math.atan2(y - seen.y, x - seen.x) - seen.heading
        speed = min(seen.top_speed, math.dist((x, y), (seen.x, seen.y)) / seen.time_step)
        return Command(speed, math.remainder(turn, 2 * math.pi) / seen.time_step), (float(at),)
"""


@pytest.fixture
def sweep(tmp_path):
    (tmp_path / "sweep.py").write_text(SWEEP)
    return f"{tmp_path}/sweep.py:Sweep"


def centres(world, cells):
    rows, columns = np.nonzero(cells)
    side = world.cell_size
    return [((x + 0.5) * side, (y + 0.5) * side) for y, x in zip(rows, columns, strict=True)]


@pytest.mark.parametrize("family", FAMILIES)
def test_every_cell_that_is_asked_for_can_be_reached(family):
    world = generate(family, 2, size=16)
    for x, y in centres(world, reachable_cells(world))[::5]:
        there = replace(world, target=Target(x, y, 0.001), certificate=None, provenance=None)
        assert decide(there).result == "reachable"


@pytest.mark.parametrize("family", FAMILIES)
def test_a_tour_is_clear_and_visits_every_cell(family):
    world = generate(family, 3, size=16)
    tour = shapely.LineString(coverage_tour(world))
    solid = np.argwhere(world.walls) * world.cell_size
    side = world.cell_size
    walls = shapely.union_all(
        shapely.box(solid[:, 1], solid[:, 0], solid[:, 1] + side, solid[:, 0] + side)
    )
    assert shapely.distance(tour, walls) >= world.robot_radius - 1e-9
    missed = [
        place
        for place in centres(world, reachable_cells(world))
        if tour.distance(shapely.Point(place)) > 1e-9
    ]
    assert missed == []


@pytest.mark.parametrize("family", FAMILIES)
def test_who_drives_the_tour_has_covered_the_world(family, sweep):
    world = generate(family, 4, size=16)
    episode = simulate(
        world, sweep, Scenario(sweep, RunOptions(task="cover")).options(world), record=True
    )
    assert episode.verdict == "covered" and episode.cells_left == 0
    assert episode.evidence.cells == np.count_nonzero(reachable_cells(world))
    wrong = check_evidence(
        episode.verdict, world, episode.trace, episode.evidence, MOTIONS.get("swept")
    )
    assert wrong == ""


def test_a_claim_of_coverage_that_leaves_a_cell_is_refused(sweep):
    world = generate("rooms", 4, size=16)
    options = Scenario(sweep, RunOptions(task="cover")).options(world)
    whole = simulate(world, sweep, options, record=True)
    half = simulate(world, sweep, replace(options, steps=whole.steps // 2), record=True)
    assert half.verdict == "timeout" and half.cells_left > 0
    claim = CoveredEvidence(step=half.steps, cells=whole.evidence.cells)
    assert check_evidence("covered", world, half.trace, claim, MOTIONS.get("swept"))


def test_the_target_does_not_end_a_coverage_task():
    world = generate("trap", 3, size=16)
    assert simulate(world, "bug2").verdict == "reached"
    assert simulate(world, "bug2", task="cover").verdict != "reached"


def test_a_loop_of_a_coverage_task_is_proved_and_checked():
    world = generate("trap", 3, size=16)
    run = prepare(world, "bug2", Scenario.parse("bug2+task=cover").options(world))
    episode = simulate(world, "bug2", task="cover")
    assert episode.verdict == "loop" and episode.cells_left > 0
    longer = run.run(episode.steps + episode.evidence.period, find_loop=False, record=True)
    motion = MOTIONS.get("swept")
    assert check_evidence("loop", world, longer.trace, episode.evidence, motion) == ""


@given(st.integers(0, 200), st.integers(0, 2**32))
def test_a_random_run_that_covers_has_visited_what_it_should(seed, draws):
    world = generate("corridor", seed, size=12)
    options = replace(Scenario.parse("random-walk+task=cover").options(world), seed=draws)
    episode = simulate(world, "random-walk", options, record=True)
    cells = {
        (int(x / 0.1 + 1e-9), int(y / 0.1 + 1e-9))
        for x, y in zip(episode.trace.x, episode.trace.y, strict=True)
    }
    wanted = {(x, y) for y, x in np.argwhere(reachable_cells(world)).tolist()}
    assert episode.cells_left == len(wanted - cells)
    assert (episode.verdict == "covered") == (episode.cells_left == 0)


def test_a_budget_follows_from_the_cells():
    world = generate("rooms", 4, size=24)
    cells = int(np.count_nonzero(reachable_cells(world)))
    steps = Scenario.parse("bug2+task=cover").options(world).steps
    assert steps == pytest.approx(10 * 2 * cells * 0.1 / world.robot_speed / 0.015, abs=1)


def test_a_task_is_stored_with_the_run():
    options = RunOptions(task="cover", steps=7)
    assert options.parameters() == {"steps": 7, "time_step": 0.015, "task": "cover"}
    assert RunOptions.of("swept", 0, options.parameters()) == options
    assert Scenario.parse("bug2+task=cover").label() == "bug2+task=cover"


def test_a_world_that_changes_cannot_be_covered():
    with raises(InvalidWorld, code="world-changes"):
        simulate(generate("fire", 1, size=20), "bug2", task="cover")


def test_a_robot_that_cannot_move_has_nothing_to_cover():
    world = generate("trap", 3, size=16)
    walls = np.ones_like(world.walls)
    walls[4:6, 4:6] = False
    shut = replace(
        world, walls=walls, start=Pose(0.5, 0.5, 0.0), target=Target(0.5, 0.5, 0.01),
        certificate=None, provenance=None,
    )  # fmt: skip
    with raises(InvalidWorld, code="nothing-to-cover"):
        simulate(shut, "bug2", task="cover")


def test_the_thesis_robot_has_no_coverage_task():
    with raises(InvalidParameter, code="option-without-effect"):
        RunOptions("stepped", task="cover")


def test_a_task_is_one_of_two():
    with raises(InvalidParameter, code="unknown-name", name="task"):
        RunOptions(task="sweep")


def test_a_picture_shows_what_was_not_covered():
    world = generate("trap", 3, size=16)
    episode = simulate(world, "bug2", task="cover", record=True)
    assert np.count_nonzero(trail_of(episode, world).missed) == episode.cells_left
    assert trail_of(simulate(world, "bug2", record=True), world).missed is None


@pytest.mark.gate
def test_the_commands_run_fuzz_and_replay_the_task(tmp_path, sweep):
    write_world(generate("rooms", 4, size=16), tmp_path / "w.grid")
    ran = worldgen("run", tmp_path / "w.grid", "--controller", sweep, "--task", "cover", "--json")
    assert ran.code == 0 and json.loads(ran.out)["verdict"] == "covered"
    found = worldgen(
        "fuzz", "--controller", "bug2", "--task", "cover", "--family", "trap", "--units", 1,
        "--seed", 1, "--workers", 1, "--examples", 10, "--out", tmp_path / "out",
    )  # fmt: skip
    assert found.code == 1
    kept = sorted((tmp_path / "out").glob("*.grid"))
    assert kept and all(read_world(path).failure.parameters["task"] == "cover" for path in kept)
    assert worldgen("replay", tmp_path / "out").code == 0
    clean = worldgen(
        "fuzz", "--controller", sweep, "--task", "cover", "--family", "rooms", "--units", 1,
        "--seed", 1, "--workers", 1, "--examples", 5, "--out", tmp_path / "clean",
    )  # fmt: skip
    assert clean.code == 0, clean.out


def test_a_controller_that_never_moves_is_not_said_to_cover():
    class Stands:
        def reset(self):
            return ()

        def act(self, observation, memory):
            return Command(0.0, 0.0), memory

    assert simulate(generate("trap", 3, size=16), Stands(), task="cover").verdict == "loop"
