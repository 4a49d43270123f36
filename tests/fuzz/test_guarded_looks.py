"""Screening, shrinking and units of controllers in shared libraries, in a separate process that may
die.
"""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from fuzz.campaign.unit import run_unit
from fuzz.oracles import Trial
from fuzz.screening import evaluate
from fuzz.search.native import scenes
from fuzz.unit.config import CampaignConfig
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.shared import guarded
from sim.options.run import RunOptions
from sim.outcome import LIMIT
from sim.runners.edited import CellEdit, EditedRuns, EditKind, Wanted
from sim.runners.lattice import LatticeRun
from sim.scenario import Scenario
from tests.helpers.faulty_library import compile_faulty
from worldgen import generate
from worldgen.random_streams import RandomStream

pytestmark = pytest.mark.skipif(os.name != "posix", reason="nothing is contained there")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The library of faulty controllers, by its full path."""
    return compile_faulty(tmp_path_factory.mktemp("library"))


@pytest.fixture(autouse=True)
def contained(monkeypatch):
    """As in a campaign."""
    monkeypatch.setattr(guarded, "can_fork", True)


def looks_of(name, count=60, budget=400):
    drawn = scenes(RandomStream(3), count)
    return evaluate(drawn, Scenario(name), np.arange(count, dtype=np.uint64), 0.015, budget)


def alone(looks, n):
    """The run of a screening, on its own."""
    options = looks.scenario_of(n).options(looks.world(n))
    return simulate(
        looks.world(n), looks.scenario.controller, replace(options, steps=int(looks.budget[n]))
    )


@pytest.mark.gate
def test_each_crash_of_a_batch_is_that_of_its_world(library):
    looks = looks_of(f"lib:{library}:segfault")
    ran = np.flatnonzero(looks.ran).tolist()
    crashed = [n for n in ran if looks.verdict[n] == "crash"]
    assert 3 < len(crashed) < len(ran) and looks.deaths >= len(crashed)
    for n in ran:
        episode = alone(looks, n)
        assert (episode.verdict == "crash") == (n in crashed)
        assert n not in crashed or episode.steps == looks.steps[n]


@pytest.mark.gate
def test_a_batch_with_crashes_has_the_same_bytes_twice(library):
    first, second = (looks_of(f"lib:{library}:segfault") for _ in range(2))
    assert first.raw.tobytes() == second.raw.tobytes()


def test_looks_in_another_process_are_bit_for_bit_those_in_this_one(library, monkeypatch):
    there = looks_of(f"lib:{library}:complain")
    monkeypatch.setattr(guarded, "can_fork", False)
    here = looks_of(f"lib:{library}:complain")
    assert [
        there.raw[name].tolist()
        for name in ("ending", "steps", "path_length", "visited", "contact")
    ] == [
        here.raw[name].tolist() for name in ("ending", "steps", "path_length", "visited", "contact")
    ]


def test_a_death_leaves_the_results_that_an_error_leaves_in_this_process(library, monkeypatch):
    died = looks_of(f"lib:{library}:segfault")
    world = next(died.world(n) for n in np.flatnonzero(died.verdict == "crash").tolist())
    death = simulate(world, f"lib:{library}:segfault")
    monkeypatch.setattr(guarded, "can_fork", False)
    said = looks_of(f"lib:{library}:own_up")
    error = simulate(world, f"lib:{library}:own_up")
    names = ("ending", "steps", "path_length", "visited", "contact", "collisions")
    assert [died.raw[name].tolist() for name in names] == [
        said.raw[name].tolist() for name in names
    ]
    assert (death.trace_digest, death.steps) == (error.trace_digest, error.steps)


@pytest.mark.parametrize("digest", [False, True], ids=["plain loop", "general loop"])
def test_a_long_run_that_touches_nothing_is_not_taken_for_a_hang(library, monkeypatch, digest):
    monkeypatch.setattr(guarded, "DEADLINE", 0.005)
    monkeypatch.setattr(guarded, "_LOOK", 0.001)
    world = generate("maze", 3, size=20)
    run = LatticeRun(world, CONTROLLERS.get(f"lib:{library}:count_steps"), RunOptions())
    outcome = run.run(300_000, find_loop=not digest, record=False, digest=digest)
    assert (outcome.ending, outcome.steps) == (LIMIT, 300_000)


@pytest.mark.gate
def test_crashes_of_two_kinds_have_two_keys(library):
    keys = [
        {int(key) for key in looks.key[looks.verdict == "crash"]}
        for looks in (looks_of(f"lib:{library}:{name}") for name in ("segfault", "give_up"))
    ]
    assert keys[0] and keys[1] and not keys[0] & keys[1]


@pytest.mark.gate
def test_a_batch_ends_with_its_second_hang(library):
    looks = looks_of(f"lib:{library}:hang")
    assert (
        looks.verdict[looks.ran].tolist().count("hang") == 2
        and looks.verdict[looks.ran][-1] == "hang"
    )


@pytest.mark.gate
def test_what_a_library_keeps_of_one_unit_is_not_there_in_the_next(library):
    config = CampaignConfig(scenario=Scenario(f"lib:{library}:wear_out"), examples=10)
    first, second = (run_unit(config, 0) for _ in range(2))
    assert first.verdicts == second.verdicts and first.steps == second.steps


@pytest.mark.gate
def test_what_a_library_keeps_of_one_run_is_not_there_in_the_next_that_is_judged(library):
    world = generate("maze", 3, size=20)
    name = f"lib:{library}:wear_out"
    # Without new processes, one of these runs would contain the step in which it fails.
    runs = [Trial.recorded(world, name, RunOptions(steps=1000)).episode for _ in range(60)]
    assert {run.verdict for run in runs} == {"loop"}


@pytest.mark.nightly
def test_a_unit_with_crashes_finds_the_same_bytes_again(library):
    config = CampaignConfig(scenario=Scenario(f"lib:{library}:segfault"), examples=10)
    found = [
        {kind: failure.dumps() for kind, failure in run_unit(config, 0).failures.items()}
        for _ in range(2)
    ]
    assert found[0] == found[1] and any(
        signature.startswith("crash-SIGSEGV") for _, signature in found[0]
    )


def test_an_edit_after_which_the_controller_crashes_is_found(library):
    world = generate("maze", 3, size=20)
    controller = CONTROLLERS.get(f"lib:{library}:segfault")
    runs = EditedRuns(world, controller, Scenario(controller.name).options(world))
    edits = [CellEdit(EditKind.FREE_RUN, k, 1) for k in range(3)]
    assert runs.first(edits, Wanted(0, crash=True), way=False) == (0, 1)
    assert runs.first(edits, Wanted(1), way=False)[0] is None


def test_a_process_that_somebody_ended_is_started_again(library):
    world = generate("maze", 3, size=20)
    first = simulate(world, f"lib:{library}:complain")
    process = guarded._here.servers[0].process
    os.kill(process, signal.SIGKILL)
    os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)
    assert simulate(world, f"lib:{library}:complain").trace_digest == first.trace_digest


def test_ctrl_c_ends_the_process_with_its_call(library, monkeypatch):
    class Impatient:
        def poll(self, _time):
            raise KeyboardInterrupt

    world = generate("maze", 3, size=20)
    simulate(world, f"lib:{library}:complain")
    monkeypatch.setattr(guarded._here.servers[0], "_poll", Impatient())
    with pytest.raises(KeyboardInterrupt):
        simulate(world, f"lib:{library}:complain")
    assert not guarded._here.servers
