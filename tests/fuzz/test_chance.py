"""Exact answers about random controllers.

Known answers, checked answers, and answers that ordinary runs confirm.
"""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from fuzz.chance import Chance, chance_details, chance_of, in_words
from fuzz.evidence_checks.chance import check_chance
from fuzz.facts.proofs import certified
from fuzz.shrink import shrink
from fuzz.triage.judging import failure_of
from sim import RobotOptions, simulate, simulate_many
from sim.controllers.base import CompiledController
from sim.episode.chance import ARRIVED, explore
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.reference.sim import layout
from worldgen import Event, Pose, Target, Timeline, World, write_world
from worldgen.errors import InvalidParameter
from worldgen.timeline import CellState

COIN = RobotOptions(coin=2, lattice=8)
SENSES = ("bump", "heading", "random", "time_step", "top_speed")


def _wander(observation, memory, command):
    """Chooses east or west again in every step."""
    east = observation[layout.OBS_RANDOM] < 0.5
    turned = 0.0 if east else math.pi
    command[layout.CMD_TURN_RATE] = (turned - observation[layout.OBS_HEADING]) / observation[
        layout.OBS_TIME_STEP
    ]
    command[layout.CMD_SPEED], command[layout.CMD_DRAW] = observation[layout.OBS_TOP_SPEED], 1.0


def _choose(observation, memory, command):
    """Chooses east or west once and for all."""
    if memory[0] == 0.0:
        memory[0], command[layout.CMD_DRAW] = 1.0, 1.0
        if observation[layout.OBS_RANDOM] >= 0.5:
            command[layout.CMD_TURN_RATE] = math.pi / observation[layout.OBS_TIME_STEP]
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]


def _quarter(observation, memory, command):
    """Drives ahead; at a wall, makes a quarter turn to the left or to the right."""
    if observation[layout.OBS_BUMP] != 0.0:
        side = 1.0 if observation[layout.OBS_RANDOM] < 0.5 else -1.0
        command[layout.CMD_TURN_RATE] = side * math.pi / 2 / observation[layout.OBS_TIME_STEP]
        command[layout.CMD_DRAW] = 1.0
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]


def _peek(observation, memory, command):
    """Drives ahead while the number is low, but never uses it up.

    A number that was only read is there again in the next step.
    """
    command[layout.CMD_SPEED] = (
        observation[layout.OBS_TOP_SPEED] if observation[layout.OBS_RANDOM] < 0.5 else 0.0
    )


def _err(observation, memory, command):
    """Drives ahead or, depending on the coin, commands an invalid speed."""
    low = observation[layout.OBS_RANDOM] < 0.5
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED] if low else math.nan


def _waver(observation, memory, command):
    """Stands still, and uses up the number unless it is low.

    It always acts the same, but sees different numbers.
    """
    command[layout.CMD_DRAW] = 1.0 if observation[layout.OBS_RANDOM] >= 0.5 else 0.0


def _raise(observation, memory, command):
    """Drives ahead or, depending on the coin, raises an error."""
    if observation[layout.OBS_RANDOM] >= 0.5:
        raise ValueError("no way")
    command[layout.CMD_SPEED], command[layout.CMD_DRAW] = observation[layout.OBS_TOP_SPEED], 1.0


def _rarely(observation, memory, command):
    """Drives ahead or, very rarely, commands an invalid speed."""
    command[layout.CMD_SPEED] = (
        math.nan if observation[layout.OBS_RANDOM] < 0.0022 else observation[layout.OBS_TOP_SPEED]
    )


class Flip:
    """Drives ahead or not, depending on the first random number.

    In Python, so that its use of chance is not declared.
    """

    def reset(self):
        return ()

    def act(self, observation, memory):
        from sim import Command

        return Command(observation.top_speed if observation.random < 0.5 else 0.0), memory


wander = CompiledController("wander", _wander, randomised=True, senses=SENSES, needs=COIN)
choose = CompiledController("choose", _choose, (0.0,), randomised=True, senses=SENSES, needs=COIN)
quarter = CompiledController("quarter", _quarter, randomised=True, senses=SENSES, needs=COIN)
peek = CompiledController("peek", _peek, randomised=True, senses=SENSES, needs=COIN)
err = CompiledController("err", _err, randomised=True, senses=SENSES, needs=COIN)
waver = CompiledController("waver", _waver, randomised=True, senses=SENSES, needs=COIN)
raises = CompiledController("raises", _raise, randomised=True, senses=SENSES, needs=COIN)
rarely = CompiledController("rarely", _rarely, senses=SENSES)
unsaid = CompiledController("unsaid", _quarter)  # senses everything, including random numbers
free = replace(quarter, name="free", needs=RobotOptions(lattice=8))
astray = replace(wander, name="astray", needs=RobotOptions(lattice=8))
HERE = "tests.fuzz.test_chance"


def hall(target=(1.05, 0.25)):
    """Twelve cells by five; the start is in the middle of the left half."""
    return World(np.zeros((5, 12), bool), Pose(0.35, 0.25, 0.0), Target(*target, 0.05))


def answer(controller, world, **changes):
    return chance_of(world, f"{HERE}:{controller}", RunOptions(steps=4000, **changes))


def explored(controller, world):
    outcomes = explore(world, controller, RunOptions(), most=10_000)
    assert outcomes is not None
    return outcomes


@pytest.mark.parametrize(
    ("controller", "target", "chance"),
    [
        ("wander", (1.05, 0.25), "sure"),  # up and down a hall, for any length of time
        ("wander", (1.05, 0.45), "trap"),  # a target next to the line that it never leaves
        ("choose", (1.05, 0.25), "part"),  # a robot that starts to the west stays there
        ("peek", (1.05, 0.25), "part"),
    ],
)
def test_the_answer_is_the_known_one(controller, target, chance):
    assert answer(controller, hall(target)).chance == chance


@pytest.mark.parametrize("controller", ["choose", "err", "raises"])
def test_the_draws_that_lose_all_are_named(controller):
    found = answer(controller, hall())
    assert (found.draws, found.lost_after) == ((1,), 1)
    assert "lost forever, at the earliest after 1 steps with the draws 1 (" in in_words(found, {})


@pytest.mark.parametrize(("controller", "faces"), [(peek, {0, 1}), (waver, {0})])
def test_a_number_that_is_not_used_up_stays(controller, faces):
    found = explored(controller, hall())
    assert {face for face in found.faces.tolist() if face >= 0} == faces


def test_a_robot_on_a_lattice_ends_its_steps_on_it_and_in_no_wall():
    world = World(np.eye(9, dtype=bool)[::-1], Pose(0.25, 0.25, 0.3), Target(0.85, 0.85, 0.03))
    walls = shapely.union_all(
        [shapely.box(k / 10, 0.8 - k / 10, (k + 1) / 10, 0.9 - k / 10) for k in range(9)]
    )
    plain = CompiledController("plain", _quarter, randomised=True, senses=SENSES)
    trace = simulate(world, plain, record=True, steps=300, lattice=8).trace
    units = np.stack([trace.x, trace.y])[:, 1:] / world.cell_size * 8
    on = np.abs(units - np.rint(units)) < 1e-9
    assert on.mean() > 0.9 and trace.bump.any()
    assert (
        shapely.distance(shapely.points(trace.x, trace.y), walls).min() > world.robot_radius - 1e-9
    )


@pytest.mark.parametrize("value", [1, 3, 2048])
def test_a_lattice_that_the_poses_do_not_have_is_refused(value):
    with pytest.raises(InvalidParameter, match=f"lattice={value}"):
        RobotOptions(lattice=value)


def test_a_coin_gives_its_values_and_no_others():
    seen = set()

    class Looks:
        def reset(self):
            return ()

        def act(self, observation, memory):
            from sim import Command

            seen.add(observation.random)
            return Command(used_random=True), memory

    simulate(hall(), Looks(), steps=100, coin=4)
    assert seen == {0.0, 0.25, 0.5, 0.75}


@pytest.mark.parametrize(
    ("controller", "changes", "reason"),
    [
        ("free", {}, "a random number may be any number below 1"),
        ("unsaid", {}, "a random number may be any number below 1"),
        ("quarter", {"motion": "endpoint"}, "only the motion model swept"),
        ("quarter", {"robot": RobotOptions(slip=0.1)}, "its own random numbers"),
    ],
)
def test_what_cannot_be_looked_at_is_undecided_and_says_why(controller, changes, reason):
    found = answer(controller, hall(), **changes)
    assert found.chance == "undecided" and reason in found.reason


def test_a_world_that_changes_is_undecided():
    world = replace(hall(), timeline=Timeline.of([Event(1.0, 6, 2, CellState.SOLID)]))
    assert "the world changes" in answer("quarter", world).reason


def test_too_many_states_are_undecided():
    found = chance_of(hall(), f"{HERE}:quarter", RunOptions(), most=5)
    assert found.chance == "undecided" and "more than 5 states" in found.reason


@st.composite
def small_worlds(draw):
    """Six cells a side with a few solid ones."""
    walls = np.array(draw(st.lists(st.booleans(), min_size=36, max_size=36)), bool).reshape(6, 6)
    walls &= np.array(draw(st.lists(st.booleans(), min_size=36, max_size=36)), bool).reshape(6, 6)
    (ix, iy), (tx, ty) = (draw(st.tuples(st.integers(0, 5), st.integers(0, 5))) for _ in range(2))
    ty = draw(st.sampled_from([iy, ty]))
    walls[iy, ix] = walls[ty, tx] = False
    start, target = (
        Pose(0.1 * ix + 0.05, 0.1 * iy + 0.05, 0.0),
        Target(0.1 * tx + 0.05, 0.1 * ty + 0.05, 0.05),
    )
    return World(walls, start, target, robot_radius=0.04)


@given(small_worlds(), st.sampled_from([quarter, wander, choose]))
def test_ordinary_runs_agree_with_the_answer(world, controller):
    outcomes = explore(world, controller, RunOptions(), most=50_000)
    assume(outcomes is not None)
    verdicts = set(simulate_many(world, controller, seeds=200, steps=1000).verdicts)
    assert outcomes.chance != "sure" or "loop" not in verdicts
    assert outcomes.chance != "trap" or "reached" not in verdicts
    assert "reached" not in verdicts or outcomes.ranks[0] > 0


@given(small_worlds(), st.sampled_from([quarter, wander, choose]), st.integers(0, 2**32))
def test_the_check_accepts_what_is_explored_and_refuses_another_claim(world, controller, seed):
    outcomes = explore(world, controller, RunOptions(), most=50_000)
    assume(outcomes is not None)
    run = simulate(world, controller, record=True, seed=seed, steps=300)
    runs = [(run.trace, run.verdict)]
    for claim in ("sure", "trap", "part"):
        assert bool(check_chance(outcomes, claim, runs)) == (claim != outcomes.chance)


def test_the_check_refuses_states_that_are_not_closed():
    outcomes = explored(wander, hall())
    cut = replace(
        outcomes, following=(((0, len(outcomes.states)), (1, 0)), *outcomes.following[1:])
    )
    assert "was not explored" in check_chance(cut, "sure", [])


def test_the_check_refuses_ranks_that_lead_nowhere():
    outcomes = explored(wander, hall((1.05, 0.45)))
    assert "lower rank" in check_chance(
        replace(outcomes, ranks=(1,) * len(outcomes.ranks)), "sure", []
    )


def test_the_check_refuses_an_end_elsewhere_where_arrival_is_said_to_be_sure():
    assert "may end elsewhere" in check_chance(explored(err, hall()), "sure", [])


def test_the_check_refuses_a_loss_that_has_a_way_out():
    outcomes = explored(wander, hall())
    assert "some draw leads out" in check_chance(
        replace(outcomes, ranks=(*outcomes.ranks[:-1], 0)), "part", []
    )


def test_the_check_refuses_states_to_which_nothing_leads():
    outcomes = explored(wander, hall())
    more = replace(
        outcomes,
        following=(*outcomes.following, ((-1, 0),)),
        states=np.concatenate([outcomes.states] * 2),
    )
    assert "no earlier state leads" in check_chance(more, "sure", [])


def test_the_check_refuses_a_run_that_leaves_the_states():
    aside = hall((1.05, 0.45))
    outcomes, run = explored(wander, aside), simulate(aside, quarter, record=True, steps=200)
    assert "does not follow" in check_chance(outcomes, "trap", [(run.trace, run.verdict)])


def test_the_check_refuses_an_arrival_that_no_state_tells():
    outcomes = explored(wander, hall())
    never = tuple(
        tuple((v, 0 if after == ARRIVED else after) for v, after in entry)
        for entry in outcomes.following
    )
    run = simulate(hall(), wander, record=True, steps=20_000)
    assert run.verdict == "reached"
    assert "which no state allows" in check_chance(
        replace(outcomes, following=never), "trap", [(run.trace, run.verdict)]
    )


def test_a_failures_record_says_what_chance_there_was():
    assert chance_details(hall(), Scenario(f"{HERE}:choose")) == {"chance": "part", "states": 39}
    assert list(chance_details(hall(), Scenario(f"{HERE}:free"))) == [
        "failing_seeds",
        "failing_share_at_least",
    ]


@pytest.mark.gate
@pytest.mark.parametrize(
    ("controller", "code", "keys"),
    [
        ("wander", 0, {"chance": "sure"}),
        ("choose", 1, {"chance": "part", "draws": [1], "lost_after": 1}),
        ("free+lattice=2", 0, {"chance": "undecided", "failing_seeds": [0, 40]}),
        ("Flip", 1, {"chance": "undecided", "failing_seeds": [27, 40]}),
    ],
)
def test_the_command_says_so(tmp_path, controller, code, keys):
    write_world(hall(), tmp_path / "w.grid")
    result = worldgen(
        "chance", tmp_path / "w.grid", "--controller", f"{HERE}:{controller}", "--json"
    )
    assert result.code == code and keys.items() <= json.loads(result.out).items()


def test_one_seed_of_many_that_fails_is_told_by_the_exit_code(tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    told = worldgen(
        "chance", tmp_path / "w.grid", "--controller", f"{HERE}:rarely", "--seeds", 600, "--json"
    )
    found = json.loads(told.out)
    assert (found["failing_seeds"], found["failing_share_at_least"], told.code) == (
        [1, 600],
        0.0,
        1,
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [((), "--controller is missing"), (("--time-step", 0.1), "needs --controller")],
)
def test_without_a_controller_the_command_says_what_it_needs(tmp_path, options, says):
    write_world(hall(), tmp_path / "w.grid")
    result = worldgen("chance", tmp_path / "w.grid", *options)
    assert says in result.err and result.code == 2


def test_a_shrunk_failure_has_no_answer_of_the_world_that_it_came_from():
    failure = failure_of(
        certified(hall((1.05, 0.45))), Scenario(f"{HERE}:astray"), chance="sure", states=7
    )
    details = shrink(failure).failure.record.details
    assert not {"chance", "states"} & details.keys() and "failing_seeds" in details


def test_seeds_are_told_where_all_cannot_be_looked_at():
    words = in_words(
        Chance("undecided", "why"), {"failing_seeds": [3, 40], "failing_share_at_least": 0.0157}
    )
    assert words == (
        "undecided: why; 3 of 40 seeds fail, so at least a share of 0.0157 of all seeds fails, "
        "with 95 % confidence"
    )
