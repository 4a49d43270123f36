"""Slow controllers are searched in small worlds, in runs that end early and claim nothing."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from fuzz.campaign.unit import run_unit
from fuzz.facts import changed_worlds
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.layouts.small_worlds import small_world
from fuzz.search.plan import planned_strategy, strategies_for
from fuzz.search.registry import check_strategy
from fuzz.search.suspects import Symptom, symptom_of
from fuzz.triage.judging import failure_of, judge
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import Deadline
from fuzz.unit.pace import Pace
from fuzz.unit.result import SearchState
from sim import Command, simulate
from sim.clock.controller_time import Effort
from sim.episode import episode_of, prepare
from sim.scenario import Scenario
from sim.verdict import Verdict
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream
from worldgen.reach import check_certificate
from worldgen.world import Pose, Target, World

HERE = "tests.fuzz.test_small_strategy"
EXAMPLE = "sim.controllers.examples.python:Example"
ROUND = 14  # worlds
SLOW = Pace(1e-3)


class Counting:
    """Stands still, and never comes back to a state."""

    def reset(self):
        return (0.0,)

    def act(self, _seen, memory):
        return Command(), (memory[0] + 1.0,)


class Hiding:
    """Stands still, and keeps its count to itself."""

    def reset(self):
        self.count = 0
        return ()

    def act(self, _seen, _memory):
        self.count += 1
        return Command(), ()


class Straight:
    """Drives straight to the target, whatever is in the way."""

    def reset(self):
        return ()

    def act(self, seen, _memory):
        turn = (seen.target_heading - seen.heading + math.pi) % (2 * math.pi) - math.pi
        return Command(seen.top_speed, turn / seen.time_step), ()


class Keeping(Straight):
    """Drives back after a bump, and keeps count of that to itself."""

    def reset(self):
        self.left = 0
        return ()

    def act(self, seen, memory):
        if seen.bump:
            self.left = 8
        if not self.left:
            return super().act(seen, memory)
        self.left -= 1
        return Command(0.5 * seen.top_speed, 1.0 if seen.bump else 0.0), ()


def worlds(numbers, values=None, time_step=0.015):
    return [
        small_world(RandomStream(5).child(number), number, values or {}, time_step)
        for number in numbers
    ]


def config(controller, pace=SLOW, **settings):
    return CampaignConfig(
        Scenario(controller), seed=1, families=("small",), measured=pace, **settings
    )


def test_every_small_world_has_a_witness_that_holds():
    assert all(check_certificate(world).valid for world in worlds(range(2 * ROUND)))


def test_the_first_worlds_can_be_crossed_in_few_steps():
    steps = [world.certificate.duration / 0.015 for world in worlds(range(ROUND))]
    assert np.median(steps) < 45 and max(steps) < 120


def test_small_worlds_grow():
    first, later = worlds(range(ROUND)), worlds(range(30 * ROUND, 31 * ROUND))
    assert sum(one.walls.size for one in later) > 2 * sum(one.walls.size for one in first)


def test_small_worlds_go_on_among_larger_ones():
    steps = [
        one.certificate.duration / 0.015 for one in worlds(range(8 * ROUND, 12 * ROUND)) if one
    ]
    assert np.median(steps) < 70 and max(steps) > 250


@pytest.mark.parametrize(
    ("values", "time_step"),
    [({"robot_radius": 0.35, "robot_speed": 0.5}, 0.1), ({"robot_speed": 1.0}, 0.015)],
)
def test_small_worlds_suit_other_robots(values, time_step):
    made = [one for one in worlds(range(ROUND), values, time_step) if one is not None]
    assert len(made) >= ROUND - 2
    assert all(getattr(made[0], name) == value for name, value in values.items())
    assert np.median([one.certificate.duration / time_step for one in made]) < 150


def test_small_worlds_take_turns():
    kinds = [one.provenance and one.provenance.family for one in worlds(range(ROUND))]
    assert kinds[::2] == [None] * 7 and len(set(kinds[1::2])) == 7


def test_only_slow_controllers_begin_with_small_worlds():
    slow = CampaignConfig(Scenario(EXAMPLE), measured=SLOW)
    quick = CampaignConfig(Scenario(EXAMPLE))
    assert [planned_strategy(slow, unit, SearchState()) for unit in range(3)] == ["small"] * 3
    assert "small" not in strategies_for(quick, SearchState())


def test_the_budget_follows_the_pace():
    slow = CampaignConfig(Scenario(EXAMPLE), measured=SLOW)
    budgets = [tuple(one.scenario.budget) for one in (slow, replace(slow, measured=None))]
    assert budgets == [(20, 600), (50, 4_000)]


def test_several_robots_have_no_small_worlds():
    with raises(InvalidParameter, "strategy-for-one-robot"):
        check_strategy("small", Scenario(EXAMPLE), robots=2)


def test_a_unit_of_small_worlds_is_the_same_again():
    first, again = (run_unit(config(EXAMPLE), 1) for _ in range(2))
    assert (first.worlds, first.steps, first.verdicts) == (
        again.worlds,
        again.steps,
        again.verdicts,
    )
    assert [one.dumps() for one in first.failures.values()] == [
        one.dumps() for one in again.failures.values()
    ]


def test_a_unit_takes_about_a_second_of_the_controller():
    result = run_unit(config(f"{HERE}:Straight", Pace(1e-4)), 0)
    assert result.failures or 3_000 < result.steps < 20_000


def test_the_first_failure_of_a_cause_ends_the_unit_and_replays():
    result = run_unit(config(f"{HERE}:Straight"), 0)
    assert len(result.failures) == 1
    assert all(replay(one).confirmed for one in result.failures.values())


@pytest.mark.parametrize("shrink", [True, False])
def test_a_slow_controller_runs_in_other_worlds_only_once_its_failure_is_stored(
    monkeypatch, shrink
):
    made = []

    def other_worlds(*args):
        made.append(args)
        return OtherWorlds(*args)

    monkeypatch.setattr(changed_worlds, "OtherWorlds", other_worlds)
    result = run_unit(config(f"{HERE}:Straight", shrink=shrink), 0)
    assert result.failures
    # Nothing would make them later if failures are not shrunk.
    assert bool(made) == (not shrink)
    for failure in result.failures.values():
        assert failure_of(failure.world, failure.scenario) is not None
    assert made


@pytest.mark.parametrize("name", ["Counting", "Hiding"])
def test_a_run_that_is_no_loop_spends_the_budget_of_its_witness(name):
    result = run_unit(config(f"{HERE}:{name}"), 0)
    (failure,) = result.failures.values()
    duration = failure.world.certificate.duration
    assert failure.verdict == "stalled"
    assert failure.options.steps == max(math.ceil(20 * duration / 0.015), 600) < 4_000
    assert failure.scenario.options(failure.world) == failure.options
    assert replay(failure).confirmed


def test_a_class_that_keeps_its_state_to_itself_is_not_said_to_change_between_runs():
    result = run_unit(config(f"{HERE}:Keeping", Pace(1e-4)), 1)
    assert result.failures and result.worlds > 10
    assert not result.effort.differences


def test_a_run_that_was_ended_without_a_look_for_loops_is_done_again():
    scenario = Scenario(f"{HERE}:Straight")
    world = next(
        one
        for one in worlds(range(2 * ROUND))
        if simulate(one, scenario.controller).verdict == "loop"
    )
    options = scenario.options(world)
    run = prepare(world, scenario.controller, options)
    outcome = run.run(options.steps, find_loop=False, record=True)
    known = replace(episode_of(run, world, outcome, options), verdict=Verdict.STALLED)
    began = Effort.so_far()
    judged = judge(world, scenario, known=known)
    assert judged.failure is not None and judged.failure.verdict == "loop"
    assert not began.since().differences


def test_what_is_known_well_is_not_proved_again():
    first = run_unit(config(f"{HERE}:Counting"), 0)
    known = SearchState().after(first)
    for name in ("a", "b"):
        known.failures[next(iter(known.failures))[0], name] = next(iter(known.failures.values()))
    again = run_unit(config(f"{HERE}:Counting"), 4, known)
    assert not again.failures and again.verdicts["undecided"] == again.worlds > 0


class SoonOver(Deadline):
    """Is over in the second run."""

    looks = 0

    def to_begin_is_over(self):
        SoonOver.looks += 1
        return SoonOver.looks > 10


def test_a_unit_that_is_cut_counts_its_suspects():
    result = run_unit(config(f"{HERE}:Counting"), 0, deadline=SoonOver())
    assert result.cut and result.verdicts["undecided"] == result.worlds == 1


def test_a_unit_that_was_cut_ends_as_a_whole_one_without_repeating_its_runs(monkeypatch):
    name = f"{HERE}:Straight"
    whole = run_unit(config(name), 0)
    SoonOver.looks = -40
    cut = run_unit(config(name), 0, deadline=SoonOver())
    assert cut.cut and 0 < cut.worlds < whole.worlds
    assert len(cut.screened) == cut.worlds
    runs = Counter()
    monkeypatch.setattr(Straight, "reset", lambda self: runs.update(["resets"]) or ())
    resumed = run_unit(config(name), 0, screened=cut.screened)
    some = runs.pop("resets")
    assert run_unit(config(name), 0) == resumed == whole
    assert some < runs["resets"]


def run(controller, steps):
    world = World(np.zeros((8, 30), bool), Pose(0.35, 0.35, 0.0), Target(2.6, 0.35, 0.05))
    return world, simulate(world, controller, steps=steps, record=True)


def test_a_robot_that_comes_closer_is_no_suspect():
    assert symptom_of(*run(Straight, 40)) is None


def test_a_robot_that_stands_still_is_a_suspect():
    assert symptom_of(*run(Counting, 40)) == Symptom.RECURS
