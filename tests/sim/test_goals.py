"""Goals that ask for more than a touch: headings, ends of steps, stops, and no contact."""

import math
import subprocess
import sys
from dataclasses import astuple, dataclass, replace

import numpy as np
import pytest

from build_tools.cores import compiler
from sim import (
    Command,
    Commands,
    CompiledController,
    ProcessController,
    RunOptions,
    simulate,
    simulate_many,
)
from sim.controllers.shared.object_file import include_folder
from sim.episode.describe import describe_evidence
from sim.kernels import layout
from worldgen import CellState, Event, Pose, Target, Timeline, World
from worldgen.lattice import TURN, turn_to_lattice

STEP = 0.1  # s


def corridor(start=0.5, target=3.0, radius=0.05, heading=0.0, **goal):
    """A corridor of 8 m in which a robot of radius 0.2 m drives along the middle."""
    walls = np.ones((10, 80), bool)
    walls[1:-1, 1:-1] = False
    return World(
        walls,
        Pose(start, 0.5, heading),
        Target(target, 0.5, radius, **goal),
        robot_radius=0.2,
        robot_speed=2.0,
    )


@dataclass(frozen=True)
class Does:
    """Commands a list of speeds and turns per step, and then stands."""

    commands: tuple
    senses = ("time_step",)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        step = int(memory[0])
        if step >= len(self.commands):
            return Command(), memory
        speed, turn = self.commands[step]
        return Command(speed, turn / observation.time_step), (step + 1.0,)


def drive(world, *commands, motion="swept", **settings):
    return simulate(world, Does(commands), steps=60, time_step=STEP, motion=motion, **settings)


# Arriving.


def test_a_robot_that_passes_its_goal_between_two_steps_only_touches_it():
    ahead = [(2.0, 0.0)] * 30
    ends = {}
    for arrival in ("touch", "step", "stop"):
        run = drive(corridor(target=3.02, arrival=arrival, radius=0.01), *ahead)
        ends[arrival] = run.verdict
    assert ends == {"touch": "reached", "step": "loop", "stop": "loop"}
    assert drive(corridor(target=3.1, arrival="step"), *ahead).verdict == "reached"


def test_a_run_says_how_far_from_arriving_it_ends():
    # It stands 5 cm past the disc.
    past = drive(corridor(target=2.4, arrival="step", radius=0.05), *[(2.0, 0.0)] * 10)
    assert astuple(past.shortfall) == pytest.approx((0.05, 0.0, 0.0, 0.0), abs=1e-4)
    assert describe_evidence(past).endswith("; it ends 5 cm from the target's disc)")
    # It stands at the goal, but with another heading; and turns there for good.
    wanted = corridor(target=0.5, heading=0.0, arrival="stop")
    wanted = replace(wanted, target=replace(wanted.target, heading=1.5, heading_tolerance=0.1))
    still = drive(wanted)
    assert astuple(still.shortfall) == pytest.approx((0.0, 1.5, 0.0, 0.0), abs=1e-3)
    spins = drive(corridor(target=0.5, arrival="stop"), *[(0.0, 0.5)] * 60)
    assert astuple(spins.shortfall) == pytest.approx((0.0, 0.0, 0.0, 5.0), abs=1e-2)
    rolls = drive(corridor(target=0.5, arrival="stop", radius=0.3), *[(0.5, 0.0), (-0.5, 0.0)] * 30)
    assert astuple(rolls.shortfall) == pytest.approx((0.0, 0.0, 0.5, 0.0), abs=1e-3)
    assert "in the target's disc, still moving at 0.5 m/s" in describe_evidence(rolls)
    # A touch is plain, and an arrival lacks nothing.
    assert drive(corridor()).shortfall is None
    assert drive(corridor(target=0.5, arrival="step")).shortfall is None


def test_a_stop_needs_a_low_speed_and_no_turn_in_the_target():
    slowly = [(2.0, 0.0)] * 12 + [(0.5, 0.0), (0.5, 0.0)]
    world = corridor(radius=0.3, arrival="stop", arrival_speed=0.4)
    # It stops in step 15: it acts in that step, and arrives in it.
    assert (drive(world, *slowly).verdict, drive(world, *slowly).steps) == ("reached", 15)
    faster = replace(world, target=replace(world.target, arrival_speed=0.5))
    assert drive(faster, *slowly).steps == 13
    turning = [*slowly, *[(0.0, 0.2)] * 10]
    assert drive(world, *turning).steps == 25
    quick = replace(world, target=replace(world.target, arrival_turn_rate=2.0))
    assert drive(quick, *turning).steps == 15


@pytest.mark.parametrize("arrival", ["touch", "step", "stop"])
@pytest.mark.parametrize("off", [-1, 0, 1])
def test_a_heading_counts_up_to_the_tolerance_to_the_unit(arrival, off):
    tolerance = 1000
    exact = (tolerance + 0.5) * 2 * math.pi / TURN
    world = corridor(start=3.0, arrival=arrival, radius=0.2)
    goal = replace(world.target, heading=1.0, heading_tolerance=exact)
    units = round(1.0 * TURN / (2 * math.pi)) - tolerance - off
    turn = units * 2 * math.pi / TURN
    run = drive(replace(world, target=goal), (0.0, turn), (0.0, 0.0), (0.0, 0.0))
    assert (run.verdict == "reached") == (off <= 0)


def test_a_tolerance_is_rounded_down_to_the_lattice():
    for units in (1, 1000, 32767):
        radians = units * 2 * math.pi / TURN
        assert turn_to_lattice(math.nextafter(radians, 9.0) + 1e-12) == units
        assert turn_to_lattice(radians - 1e-12) == units - 1


def test_a_robot_that_turns_on_the_spot_in_its_target_arrives_when_it_has_the_heading():
    world = corridor(start=3.0)
    goal = replace(world.target, heading=2.0, heading_tolerance=0.05)
    turns = [(0.0, 0.2)] * 30
    # The turn of step 10 takes effect at once; the next step's move shows it.
    assert drive(replace(world, target=goal), *turns).steps == 11
    stop = replace(goal, arrival="stop", arrival_turn_rate=3.0)
    assert drive(replace(world, target=stop), *turns).steps == 10


def test_a_robot_that_turns_about_its_goal_s_heading_forever_loops():
    world = corridor(start=3.0, arrival="stop")
    goal = replace(world.target, heading=2.0, heading_tolerance=0.05)

    class Dithers:
        """Turns past the heading, to both sides in turn."""

        def reset(self):
            return (1.0,)

        def act(self, observation, memory):
            aim = observation.goal_heading + 0.2 * memory[0]
            turn = math.remainder(aim - observation.heading, math.tau)
            return Command(0.0, turn / observation.time_step), (-memory[0],)

    run = simulate(replace(world, target=goal), Dithers(), steps=500, time_step=STEP)
    assert (run.verdict, run.evidence.period) == ("loop", 2)


# Contact.


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_move_into_a_wall_slides_stops_or_fails(motion):
    aslant = [(1.0, 1.0)] + [(1.0, 0.0)] * 8
    runs = {
        contact: drive(
            corridor(start=2.0, target=7.0, contact=contact), *aslant, motion=motion, record=True
        )
        for contact in ("slide", "stop", "fail")
    }
    assert runs["fail"].verdict == "contact" and runs["fail"].evidence.cell[1] == 9
    end = runs["fail"].steps
    assert runs["fail"].trace.bump.tolist() == [False] * end + [True]
    for contact in ("slide", "stop"):
        seen = runs[contact].trace
        assert (seen.x[:end] == runs["fail"].trace.x[:end]).all()
        moved_on = float(seen.x[-1] - seen.x[end])
        assert moved_on > 0.1 if (contact, motion) == ("slide", "swept") else moved_on == 0.0
        assert seen.bump[end]


def test_a_touch_counts_before_a_contact_and_a_contact_before_the_end_of_the_step():
    # The last step leads over the target, into the wall behind it.
    ahead = [(2.0, 0.0)] * 9
    for arrival, verdict in (("touch", "reached"), ("step", "contact")):
        world = corridor(start=6.4, target=7.65, radius=0.02, arrival=arrival, contact="fail")
        assert drive(world, *ahead).verdict == verdict


def test_driving_along_a_wall_is_no_contact():
    world = corridor(start=1.0, target=3.0, radius=0.3, contact="fail")
    along = replace(world, start=Pose(1.0, 0.3), target=replace(world.target, x=3.0, y=0.3))
    assert drive(along, *[(1.0, 0.0)] * 25).verdict == "reached"


def test_what_a_stopped_move_has_left_is_lost_even_if_the_wall_goes_away():
    walls = np.ones((10, 80), bool)
    walls[1:-1, 1:-1] = False
    walls[:, 20] = True
    line = Timeline.of([Event(0.25, 20, iy, CellState.FREE) for iy in range(1, 9)])
    ends = {}
    for contact in ("slide", "stop", "fail"):
        world = replace(corridor(start=1.7, contact=contact), walls=walls, timeline=line)
        ends[contact] = drive(world, (2.0, 0.0), (2.0, 0.0), (0.0, 0.0), record=True)
    # In step 3 the robot meets the wall at once, and the wall opens in the middle of the step.
    x = {contact: run.trace.x[3] for contact, run in ends.items() if contact != "fail"}
    assert x["slide"] > 1.85 and x["stop"] == pytest.approx(1.8, abs=1e-3)
    assert (ends["fail"].verdict, ends["fail"].steps) == ("contact", 2)


def test_a_push_into_a_wall_is_a_contact():
    world = corridor(start=3.0, target=7.0, contact="fail")
    run = drive(world, pushes=(1.0, 0.0, 0.5, 0.0))
    assert (run.verdict, run.steps, run.evidence.cell[1]) == ("contact", 10, 9)


# The sense, and the same run for every form of controller.


class Aims:
    """Drives to the target, then takes up the heading that the goal asks for, and stands."""

    senses = ("target_distance", "target_heading", "heading", "goal_heading", "time_step")

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        is_there = memory[0] > 0.0 or observation.target_distance < 0.1
        aim = observation.goal_heading if is_there else observation.target_heading
        off = aim - observation.heading
        turn = off - math.tau * math.floor(off / math.tau + 0.5)
        speed = 0.0 if is_there else 0.5
        return Command(speed, min(1.0, max(-1.0, turn / observation.time_step))), (float(is_there),)


class AimsForMany(Aims):
    """The same for many robots."""

    def act_many(self, observation, memory):
        is_there = (memory[:, 0] > 0.0) | (observation.target_distance < 0.1)
        aim = np.where(is_there, observation.goal_heading, observation.target_heading)
        off = aim - observation.heading
        turn = off - math.tau * np.floor(off / math.tau + 0.5)
        speed = np.where(is_there, 0.0, 0.5)
        rate = np.minimum(1.0, np.maximum(-1.0, turn / observation.time_step))
        return Commands(speed, rate), is_there[:, np.newaxis].astype(float)


def _aims(observation, memory, command):
    is_there = memory[0] > 0.0 or observation[layout.OBS_TARGET_DISTANCE] < 0.1
    goal = observation[layout.OBS_GOAL_HEADING]
    aim = goal if is_there else observation[layout.OBS_TARGET_HEADING]
    off = aim - observation[layout.OBS_HEADING]
    turn = off - math.tau * math.floor(off / math.tau + 0.5)
    command[layout.CMD_SPEED] = 0.0 if is_there else 0.5
    command[layout.CMD_TURN_RATE] = min(1.0, max(-1.0, turn / observation[layout.OBS_TIME_STEP]))
    memory[0] = 1.0 if is_there else 0.0


AIMS_IN_C = """
#include "worldgen_controller.h"
#include <math.h>

static void aims(const WgObservation *seen, double *memory, WgCommand *command)
{
    const double whole = 2.0 * 3.141592653589793;
    int is_there = memory[0] > 0.0 || seen->target_distance < 0.1;
    double off = (is_there ? seen->goal_heading : seen->target_heading) - seen->heading;
    double turn = (off - whole * floor(off / whole + 0.5)) / seen->time_step;
    command->speed = is_there ? 0.0 : 0.5;
    command->turn_rate = turn > 1.0 ? 1.0 : turn < -1.0 ? -1.0 : turn;
    memory[0] = is_there;
}

WG_CONTROLLER(aims, .memory_size = 1,
              .senses = WG_SENSE_TARGET_DISTANCE | WG_SENSE_TARGET_HEADING | WG_SENSE_GOAL_HEADING)
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("aims")
    (folder / "aims.c").write_text(AIMS_IN_C)
    words = ["-std=c17", "-O1", "-ffp-contract=off", "-shared", "-fPIC", f"-I{include_folder()}"]
    files = [str(folder / "aims.c"), "-lm", "-o", str(folder / "aims.so")]
    subprocess.run([*compiler(), *words, *files], check=True)
    return f"lib:{folder}/aims.so:aims"


GOALS = {
    "stop": {"heading": -2.0, "arrival": "stop", "heading_tolerance": 0.01},
    "step": {"heading": 2.5, "arrival": "step", "contact": "fail"},
    "touch": {"heading": 3.0, "radius": 0.2},
    "plain": {},
}
RUN = RunOptions(steps=300, time_step=STEP)


def around_a_corner(**goal):
    world = corridor(start=1.0, radius=0.12)
    return replace(world, target=replace(world.target, **goal), start=Pose(1.0, 0.5, 0.4))


@pytest.mark.parametrize("goal", GOALS.values(), ids=GOALS)
def test_every_form_of_a_controller_arrives_in_the_same_steps(goal, library):
    world = around_a_corner(**goal)
    expected = simulate(world, Aims(), RUN, record=True)
    assert expected.verdict == "reached"
    for form in (AimsForMany(), library):
        run = simulate(world, form, RUN)
        assert (run.verdict, run.trace_digest) == (expected.verdict, expected.trace_digest)


@pytest.mark.gate
def test_a_function_and_a_program_arrive_in_the_same_steps():
    world = around_a_corner(**GOALS["stop"])
    expected = simulate(world, Aims(), RUN)
    run = simulate(world, CompiledController("aims", _aims, (0.0,), senses=Aims.senses), RUN)
    assert (run.verdict, run.trace_digest) == (expected.verdict, expected.trace_digest)
    with ProcessController([sys.executable, "-m", "sim.host", f"{__file__}:Aims"]) as program:
        run = simulate(world, program, RUN)
    # A program's memory is not part of its states.
    assert (run.verdict, run.steps) == (expected.verdict, expected.steps)


def test_robots_in_lockstep_sense_and_reach_their_own_goals(library):
    worlds = [around_a_corner(**goal) for goal in GOALS.values()]
    for controller in (AimsForMany(), library):
        runs = simulate_many(worlds, controller, RUN, digest=True)
        for row, world in enumerate(worlds):
            alone = simulate(world, controller, RUN)
            assert (runs.verdicts[row], int(runs.steps[row])) == (alone.verdict, alone.steps)
            assert f"{int(runs.digest[row]):016x}" == alone.trace_digest


def _counts(observation, memory, command):
    memory[0] = observation.size


@pytest.mark.gate
@pytest.mark.parametrize("beams", [0, 5])
def test_only_a_compiled_controller_that_declares_the_sense_gets_a_longer_array(beams):
    for senses, more in ((("bump", "beams"), 0), (("bump", "beams", "goal_heading"), 1), (None, 0)):
        declared = {} if senses is None else {"senses": senses}
        controller = CompiledController("counts", _counts, (0.0,), **declared)
        run = simulate(corridor(), controller, steps=2, time_step=STEP, beams=beams, record=True)
        assert run.trace.memory(2)[0] == layout.OBS_SIZE + beams + more
