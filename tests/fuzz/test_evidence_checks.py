"""Evidence checks refuse false evidence and accept true evidence."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.evidence_checks import check_evidence
from sim import MOTIONS, Command, simulate
from sim.episode import prepare
from sim.episode.describe import describe_evidence
from sim.evidence import BurnedEvidence
from sim.options.run import RunOptions
from worldgen import CellState, Event, Pose, Target, Timeline, Witness, World

SWEPT, ENDPOINT = MOTIONS.get("swept"), MOTIONS.get("endpoint")


def wall_world(thickness=1):
    walls = np.zeros((12, 24), bool)
    walls[:, 12 : 12 + thickness] = True
    return World(walls, Pose(0.5, 0.55, 0.0), Target(2.05, 0.55, 0.05))


class Ahead:
    """Drives ahead."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(observation.top_speed, 0.0), memory


def run(world, motion="endpoint", controller=None, **settings):
    return simulate(world, controller or Ahead(), record=True, motion=motion, **settings)


class Rests(Ahead):
    """Drives for three steps and then stops."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(0.1 if memory[0] < 3.0 else 0.0, 0.0), (min(memory[0] + 1.0, 3.0),)


def loop_and_longer(controller=Ahead):
    world = World(np.zeros((9, 9), bool), Pose(0.45, 0.25, 0.0), Target(0.85, 0.85, 0.05))
    options = RunOptions(steps=5000)
    episode = simulate(world, controller(), options)
    entry, period = episode.evidence.entry, episode.evidence.period
    longer = (
        prepare(world, controller(), options)
        .run(entry + 2 * period, find_loop=False, record=True)
        .trace
    )
    return world, episode, longer


@pytest.mark.parametrize("controller", [Ahead, Rests])
def test_a_true_loop_holds(controller):
    world, episode, trace = loop_and_longer(controller)
    assert check_evidence("loop", world, trace, episode.evidence, SWEPT) == ""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"entry": 0}, "second period differs"),
        ({"period": 0}, "does not begin after step"),
        ({"state_digest": "0" * 16}, "differs from the evidence"),
        ({"period": 10**6}, "before the second period"),
    ],
)
def test_false_evidence_of_a_loop_is_refused(change, message):
    world, episode, trace = loop_and_longer()
    assert message in check_evidence(
        "loop", world, trace, replace(episode.evidence, **change), SWEPT
    )


def test_hidden_memory_is_no_loop():
    world, episode, trace = loop_and_longer()
    assert "does not declare" in check_evidence(
        "loop", world, replace(trace, complete=False), episode.evidence, SWEPT
    )


def test_a_true_tunnel_holds():
    episode = run(wall_world(), time_step=0.15)
    assert episode.verdict == "tunnel"
    assert check_evidence("tunnel", wall_world(), episode.trace, episode.evidence, ENDPOINT) == ""


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"step": 1}, "does not meet"),
        ({"cell": (3, 3)}, "is not solid"),
        ({"step": 99}, "has no step 99"),
    ],
)
def test_false_evidence_of_a_tunnel_is_refused(change, message):
    episode = run(wall_world(), time_step=0.15)
    evidence = replace(episode.evidence, **change)
    assert message in check_evidence("tunnel", wall_world(), episode.trace, evidence, ENDPOINT)


def test_an_overlap_is_measured_by_shapely():
    walls = np.zeros((12, 24), bool)
    walls[6, 9] = True  # its lower corners come within 0.6 cell of a robot that passes below
    world = World(walls, Pose(0.5, 0.54, 0.0), Target(2.05, 0.54, 0.05))
    episode = run(world, time_step=0.15)
    assert episode.verdict == "overlap"
    assert check_evidence("overlap", world, episode.trace, episode.evidence, ENDPOINT) == ""
    assert "is not solid" in check_evidence(
        "overlap", world, episode.trace, replace(episode.evidence, cell=(1, 1)), ENDPOINT
    )


def test_arriving_is_measured_at_the_last_step():
    world = World(np.zeros((9, 30), bool), Pose(0.45, 0.45, 0.0), Target(2.05, 0.45, 0.05))
    episode = run(world, "swept")
    assert episode.verdict == "reached"
    assert check_evidence("reached", world, episode.trace, episode.evidence, SWEPT) == ""
    elsewhere = replace(world, target=Target(2.05, 0.65, 0.05))
    assert "away from the target" in check_evidence(
        "reached", elsewhere, episode.trace, episode.evidence, SWEPT
    )


@pytest.mark.parametrize(("steps", "verdict"), [(60, "timeout"), (2000, "stalled")])
def test_stalled_and_timeout_differ_by_new_cells_in_the_second_half(steps, verdict):
    class Wander(Ahead):
        """Spirals: never repeats within the budget."""

        def reset(self):
            return (0.0,)

        def act(self, observation, memory):
            return Command(0.5, 20.0 / (1.0 + memory[0])), (memory[0] + 0.37,)

    world = World(np.zeros((9, 9), bool), Pose(0.45, 0.45, math.pi / 4), Target(0.85, 0.15, 0.001))
    episode = run(world, "swept", Wander(), steps=steps)
    other = {"timeout": "stalled", "stalled": "timeout"}[verdict]
    assert episode.verdict == verdict
    assert check_evidence(verdict, world, episode.trace, episode.evidence, SWEPT) == ""
    assert check_evidence(other, world, episode.trace, episode.evidence, SWEPT)


def burning(state, motion="swept", when=0.3):
    world = World(np.zeros((12, 24), bool), Pose(0.5, 0.55, 0.0), Target(2.05, 0.55, 0.05))
    events = [Event(when, 12, 5, state), Event(when + 9.0, 12, 5, CellState.FREE)]
    world = replace(world, timeline=Timeline.of(events))
    return world, run(world, motion, "turn-right" if motion == "stepped" else None)


@pytest.mark.parametrize("motion", ["swept", "endpoint", "stepped"])
def test_flames_that_meet_the_robot_are_confirmed(motion):
    world, episode = burning(CellState.BURNING, motion)
    assert episode.verdict == "burned"
    assert (
        check_evidence("burned", world, episode.trace, episode.evidence, MOTIONS.get(motion)) == ""
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"step": 3}, "is not burning in step 3"),
        ({"state": "solid"}, "is not solid"),
        ({"cell": (3, 3)}, "is not burning"),
        ({"step": 99}, "has no step 99"),
    ],
)
def test_false_evidence_of_a_burn_is_refused(change, message):
    world, episode = burning(CellState.BURNING)
    assert message in check_evidence(
        "burned", world, episode.trace, replace(episode.evidence, **change), SWEPT
    )


def test_flames_far_away_burn_nobody():
    world, episode = burning(CellState.BURNING)
    step = episode.evidence.step
    moved = replace(world, timeline=Timeline.of([Event(0.3, 20, 5, CellState.BURNING)]))
    assert "m away from cell" in check_evidence(
        "burned",
        moved,
        episode.trace,
        BurnedEvidence(step=step, cell=(20, 5), state="burning"),
        SWEPT,
    )


class Stands(Ahead):
    """Never moves, but counts, so that no state recurs."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(), (memory[0] + 1.0,)


def spent(controller):
    """A run that uses up its budget of 4,000 steps, while the witness takes 2 s."""
    witness = Witness(np.array([0.0, 2.0]), np.array([0.5, 2.05]), np.array([0.55, 0.55]), 0.1)
    world = replace(
        World(np.zeros((12, 24), bool), Pose(0.5, 0.55, 0.0), Target(2.05, 0.55, 0.05)),
        certificate=witness,
    )
    return world, simulate(world, controller, record=True, steps=4000)


@pytest.mark.parametrize("claimed", [30.0, 29.998, 30.002, None])
def test_a_stalled_runs_budget_is_the_stated_multiple_of_the_witness(claimed):
    world, episode = spent(Stands())
    assert episode.verdict == "stalled" and episode.evidence.witness_multiple == 30.0
    said = check_evidence(
        "stalled", world, episode.trace, replace(episode.evidence, witness_multiple=claimed), SWEPT
    )
    assert bool(said) == (claimed != 30.0) and (
        not said or "30.000 times the witness's time" in said
    )


def test_the_budget_is_said_in_steps_and_in_times_of_the_witness():
    assert (
        describe_evidence(spent(Stands())[1])
        == " (no new cell after step 0 of 4000, 30.0 times the witness's time)"
    )


# Goals that ask for more than a touch.


class TurnsThere(Ahead):
    """Drives to the target's place, then turns to a heading and stops."""

    senses = ("x", "heading", "goal_heading", "time_step")

    def __init__(self, turn=1.0, speed=0.0):
        self.turn, self.speed = turn, speed

    def act(self, observation, memory):
        if observation.x < 2.0:
            return Command(1.0, 0.0), memory
        off = math.remainder(observation.goal_heading - observation.heading, math.tau)
        turn = max(-self.turn, min(self.turn, off / observation.time_step))
        return Command(self.speed if abs(off) < 1e-4 else 0.0, turn), memory


def to_goal(motion="swept", controller=None, **goal):
    target = Target(2.05, 0.45, 0.05, **{"heading": 0.7, **goal})
    world = World(np.zeros((9, 30), bool), Pose(0.45, 0.45, 0.0), target)
    return world, run(world, motion, controller or TurnsThere())


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("arrival", ["touch", "step", "stop"])
def test_an_arrival_as_the_goal_asks_holds(arrival, motion):
    world, episode = to_goal(motion, arrival=arrival)
    assert episode.verdict == "reached"
    model = MOTIONS.get(motion)
    assert check_evidence("reached", world, episode.trace, episode.evidence, model) == ""


@pytest.mark.parametrize(
    ("goal", "change", "message"),
    [
        pytest.param({}, {"heading": 2.0}, "exceeds the goal's tolerance by 1.", id="heading"),
        pytest.param({"arrival": "step"}, {"x": 1.8}, "away from the target", id="place"),
        pytest.param(
            {"arrival": "step", "heading_tolerance": 1.0},
            {"arrival": "stop"},
            "the robot drives at 1 m/s",
            id="speed",
        ),
        pytest.param(
            {"arrival": "stop", "arrival_turn_rate": 2.0},
            {"arrival_turn_rate": 0.5},
            "the robot turns at 0.997",
            id="turn",
        ),
        pytest.param({"arrival": "stop"}, {"x": 1.8}, "away from the target", id="stops-elsewhere"),
    ],
)
def test_an_arrival_that_the_goal_does_not_accept_is_refused(goal, change, message):
    world, episode = to_goal(**goal)
    assert episode.verdict == "reached"
    other = replace(world, target=replace(world.target, **change))
    assert message in check_evidence("reached", other, episode.trace, episode.evidence, SWEPT)


def endless(**goal):
    """A robot that turns around for good at its target, recorded for two periods."""
    target = Target(0.45, 0.45, 0.05, **goal)
    world = World(np.zeros((9, 9), bool), Pose(0.45, 0.45, 0.0), target)
    options = RunOptions(steps=5000, time_step=0.1)
    episode = simulate(world, Spins(), options)
    assert episode.verdict == "loop"
    entry, period = episode.evidence.entry, episode.evidence.period
    longer = prepare(world, Spins(), options).run(entry + 2 * period, find_loop=False, record=True)
    return world, episode, longer.trace


class Spins(Ahead):
    """Turns around the same way for good, by 90 degrees in each step."""

    def act(self, observation, memory):
        return Command(0.0, math.pi / 2 / observation.time_step), memory


@pytest.mark.parametrize(
    ("goal", "change"),
    [
        pytest.param({"heading": 0.8}, {"heading": 1.6}, id="touch"),
        pytest.param({"heading": 0.8, "arrival": "step"}, {"heading": 1.6}, id="step"),
        pytest.param({"arrival": "stop"}, {"arrival_turn_rate": 20.0}, id="stop"),
        pytest.param({"arrival": "stop", "heading": 0.8}, {"arrival": "touch"}, id="any"),
    ],
)
def test_a_loop_holds_only_if_the_robot_never_arrives_in_it(goal, change):
    world, episode, trace = endless(**goal)
    assert check_evidence("loop", world, trace, episode.evidence, SWEPT) == ""
    heading = {} if "heading" in change else {"heading": None}
    other = replace(world, target=replace(world.target, **{**heading, **change}))
    wrong = check_evidence("loop", other, trace, episode.evidence, SWEPT)
    assert "arrives within the loop" in wrong or "passes through the target" in wrong


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_contact_is_where_a_step_was_to_lead_into_a_wall(motion):
    world = wall_world()
    world = replace(world, target=replace(world.target, contact="fail"))
    episode = run(world, motion, time_step=0.03)
    assert (episode.verdict, episode.evidence.cell) == ("contact", (12, 5))
    model = MOTIONS.get(motion)
    trace, evidence = episode.trace, episode.evidence
    assert check_evidence("contact", world, trace, evidence, model) == ""
    for change, message in (
        ({"step": evidence.step - 1}, "does not end in step"),
        ({"cell": (11, 5)}, "is not solid"),
        ({"cell": (12, 9)}, "away from cell" if motion == "swept" else "was to pass cell"),
    ):
        wrong = check_evidence("contact", world, trace, replace(evidence, **change), model)
        assert message in wrong
    slides = replace(world, target=replace(world.target, contact=None))
    assert "does not forbid" in check_evidence("contact", slides, trace, evidence, model)
    assert describe_evidence(episode) == f" (step {evidence.step}, wall cell (12, 5))"


def test_no_verdict_holds_after_a_contact_that_the_goal_forbids():
    world, episode, trace = loop_and_longer()
    assert trace.bump.any()
    strict = replace(world, target=replace(world.target, contact="fail"))
    wrong = check_evidence("loop", strict, trace, episode.evidence, SWEPT)
    assert wrong == f"the robot touches a wall in step {int(trace.bump.argmax())}"
