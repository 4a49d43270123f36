"""Requested oracles: what they object to, and what they accept."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.oracles import ORACLES, NamedOracle, Trial, Violation
from fuzz.oracles.added_walls import walled_where_unnoticed, with_a_block_near_the_path
from fuzz.oracles.worlds import mirrored, scaled, shifted, turned
from fuzz.regression.checks import CONFIRMED, check
from fuzz.shrink import removable, shrink
from fuzz.shrink.predicate import StillFails
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.options.run import RunOptions
from sim.options.thesis import ThesisOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import CellState, Drive, Event, Pose, Robot, Target, Timeline, World, generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import loads, read_world
from worldgen.reach import check_certificate

BLOCK = certified(
    World(
        np.pad(np.ones((3, 3), bool), ((3, 3), (3, 6))),
        Pose(0.15, 0.45, 0.0),
        Target(1.05, 0.45, 0.05),
    )
)


def objection(text, controller="bug1", world=BLOCK, **options):
    trial = Trial(world, controller, RunOptions(steps=4000, **options))
    found = NamedOracle.parse(text).check(trial)
    return None if found is None else found.facts


def failing(text, controller="bug1", world=BLOCK):
    return failure_of(world, Scenario(controller), NamedOracle.parse(text))


@pytest.fixture
def chance(tmp_path):
    """A controller with its own randomness."""
    (tmp_path / "mine.py").write_text(
        "import math, random\nfrom sim import Command\n"
        "class Chance:\n"
        "    def reset(self): return ()\n"
        "    def act(self, o, memory):\n"
        "        turn = (o.target_heading - o.heading + math.pi) % math.tau - math.pi\n"
        "        return Command(o.top_speed, random.uniform(0.5, 1.0) * turn / o.time_step), "
        "memory\n"
    )
    return f"{tmp_path}/mine.py:Chance"


@pytest.fixture
def northerner(tmp_path):
    """A controller with an absolute frame: it drives north until y is 0.6 m, whatever it senses."""
    (tmp_path / "north.py").write_text(
        "import math\nfrom sim import Command\n"
        "class North:\n"
        "    def reset(self): return ()\n"
        "    def act(self, o, memory):\n"
        "        return Command(o.top_speed if o.y < 0.6 else 0.0, (math.pi / 2 - o.heading) / "
        "o.time_step), memory\n"
    )
    return f"{tmp_path}/north.py:North"


UP = certified(
    World(np.zeros((9, 9), bool), Pose(0.45, 0.15, math.pi / 2), Target(0.45, 0.5, 0.05))
)


def test_a_way_round_the_whole_block_is_a_detour_with_its_lengths():
    said = objection("detour=2")
    assert said["ratio"] > 2 and said["ratio"] == pytest.approx(
        said["path"] / said["witness"], rel=1e-4
    )
    assert said["witness"] == pytest.approx(BLOCK.certificate.length)


def test_a_way_within_the_bound_is_no_detour():
    ratio = objection("detour=2")["ratio"]
    assert (
        objection(f"detour={ratio + 0.01}") is None
        and objection(f"detour={ratio - 0.01}") is not None
    )


def test_a_run_that_does_not_arrive_makes_no_detour():
    assert objection("detour=1", world=replace(BLOCK, target=Target(0.45, 0.45, 0.01))) is None


def test_a_detour_stays_one_from_file_to_replay():
    failure = Failure.of(loads(failing("detour=2").dumps()))
    assert failure.record.verdict == "reached" and failure.record.details["class"] == "detour"
    assert replay(failure).confirmed


def test_a_replay_notices_a_detour_that_is_said_to_be_longer():
    failure = failing("detour=2")
    said = {**failure.record.evidence["objection"], "path": 99.0}
    record = replace(failure.record, evidence={**failure.record.evidence, "objection": said})
    outcome = replay(replace(failure, record=record))
    assert not outcome.confirmed and "the evidence is" in outcome.reason


def test_a_replay_notices_a_bound_that_the_run_keeps():
    failure = failing("detour=2")
    record = replace(failure.record, evidence={**failure.record.evidence, "oracle": "detour=500"})
    assert "finds nothing wrong" in replay(replace(failure, record=record)).reason


def test_a_replay_notices_that_the_oracle_is_not_here():
    failure = failing("detour=2")
    record = replace(
        failure.record, evidence={**failure.record.evidence, "oracle": "./gone.py:gone"}
    )
    assert "no such file" in replay(replace(failure, record=record)).reason


def test_a_detour_is_shrunk_to_a_1_minimal_one():
    failure = failing(
        "detour=2", world=certified(replace(BLOCK, walls=np.pad(BLOCK.walls, ((0, 4), (0, 3)))))
    )
    result = shrink(failure)
    assert (
        result.failure.record.evidence["objection"]["ratio"] > 2
        and replay(result.failure).confirmed
    )
    assert (
        result.failure.world.walls.size < failure.world.walls.size and result.after < result.before
    )
    assert removable(result.failure.world, StillFails.of(result.failure)) == [] == list(result.left)


def test_a_library_controller_repeats_itself():
    assert objection("repeat", "turn-random", seed=3) is None


def test_chance_without_a_seed_is_seen_in_the_first_step_that_differs(chance):
    said = objection(
        "repeat",
        chance,
        UP.__class__(UP.walls, Pose(0.45, 0.15, 0.0), UP.target, certificate=UP.certificate),
    )
    assert (
        said["step"] == 1 and said["poses"][0] != said["poses"][1] and said["repeatable"] is False
    )


def test_a_run_that_does_not_come_again_is_replayed_and_shrunk(chance):
    failure = failing("repeat", chance, certified(replace(UP, start=Pose(0.25, 0.15, 0.0))))
    assert replay(failure).confirmed
    small = shrink(failure).failure
    assert small.world.walls.size < failure.world.walls.size and replay(small).confirmed


def test_only_repeat_speaks_of_a_controller_that_is_not_the_same_twice(chance):
    assert failing("detour=1", chance, certified(replace(UP, start=Pose(0.25, 0.15, 0.0)))) is None


@pytest.mark.parametrize("oracle", ["turn=1", "shift=1", "scale=1"])
@pytest.mark.parametrize("controller", ["bug1", "turn-right", "vfh"])
@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_controller_without_an_absolute_frame_runs_alike_where_worlds_correspond(
    oracle, controller, motion
):
    assert objection(oracle, controller, motion=motion) is None


@pytest.mark.parametrize(
    ("oracle", "there"), [("turn", "loop"), ("shift", "loop"), ("scale", "loop")]
)
def test_an_absolute_frame_shows_where_worlds_correspond(oracle, there, northerner):
    said = objection(oracle, northerner, UP)
    assert said["kind"] == "only-here" and said["verdicts"] == ["reached", there]


def test_an_objection_to_a_turned_world_is_replayed_and_shrunk(northerner):
    failure = failing("turn", northerner, UP)
    small = shrink(failure).failure
    assert small.record.details["class"] == "turn-only-here" and small.record.details["one_minimal"]
    assert small.world.walls.size < UP.walls.size and replay(small).confirmed


def test_a_factor_also_compares_the_steps_of_runs_that_arrive():
    world = certified(replace(BLOCK, start=Pose(0.15, 0.35, 0.0)))
    assert objection("mirror=1.1", "bug2", world)["kind"] == "slower"
    assert (
        objection("mirror=1.5", "bug2", world) is None
        and objection("mirror", "bug2", world) is None
    )


def test_two_steps_of_half_the_duration_count_as_one():
    said = objection("finer=1", "bug1")
    assert (
        said["steps"][1] == pytest.approx(2 * said["steps"][0], rel=0.2)
        and objection("finer=1.2", "bug1") is None
    )


CHANGING = replace(UP, timeline=Timeline.of([Event(0.5, 1, 7, CellState.SOLID)]))


def test_four_quarters_and_two_mirrors_give_the_world_back():
    walls = np.pad(np.ones((2, 3), bool), ((5, 2), (0, 2)))
    world = replace(
        CHANGING,
        certificate=None,
        walls=walls,
        start=Pose(0.25, 0.15, 0.0),
        target=Target(0.4, 0.2, 0.1),
    )
    quarters = turned(turned(turned(turned(world))))
    twice = mirrored(mirrored(world))
    for same in (quarters, twice):
        assert (
            (same.walls == world.walls).all()
            and same.target == world.target
            and same.timeline == world.timeline
        )
        assert math.remainder(same.start.heading - world.start.heading, math.tau) == pytest.approx(
            0.0, abs=1e-12
        )


FOOTPRINT = ((0.2, 0.05), (-0.1, 0.05), (-0.1, -0.15))
GOAL = Target(0.4, 0.2, 0.1, 0.5, 0.2, "stop", 0.3, 0.4, "stop")
BODY = Robot(Pose(0.25, 0.15, 0.3), GOAL, 1.0, 2.0, FOOTPRINT, Drive(0.4, True, 0.7))


@pytest.mark.parametrize(
    ("change", "goal", "robot"),
    [
        pytest.param(turned, {"x": 0.7, "y": 0.4, "heading": 0.5 + math.pi / 2}, {}, id="turned"),
        pytest.param(
            mirrored,
            {"x": 0.6, "heading": math.pi - 0.5},
            {"footprint": tuple((x, -y) for x, y in FOOTPRINT)},
            id="mirrored",
        ),
        pytest.param(shifted, {"x": 0.7, "y": 0.7}, {}, id="shifted"),
        pytest.param(
            scaled,
            {"x": 0.8, "y": 0.4, "radius": 0.2, "arrival_speed": 0.6},
            {
                "speed": 4.0,
                "footprint": tuple((2 * x, 2 * y) for x, y in FOOTPRINT),
                "drive": Drive(0.8, True, 0.7),
            },
            id="scaled",
        ),
    ],
)
def test_a_changed_world_keeps_the_robot_s_goal_body_and_drive(change, goal, robot):
    changed = change(World(np.zeros((9, 10), bool), robots=[BODY])).robots[0]
    expected = replace(BODY, start=changed.start, target=replace(GOAL, **goal), **robot)
    assert changed.target.heading == pytest.approx(expected.target.heading)
    place = {name: pytest.approx(getattr(expected.target, name)) for name in ("x", "y")}
    assert {name: getattr(changed.target, name) for name in place} == place
    same_place = replace(
        changed.target, x=expected.target.x, y=expected.target.y, heading=expected.target.heading
    )
    assert replace(changed, target=same_place) == expected


def test_a_shift_moves_cells_places_and_events_alike():
    moved = shifted(CHANGING)
    assert (
        (moved.width, moved.height) == (12, 14)
        and moved.walls[:5].all()
        and moved.walls[:, :3].all()
    )
    assert (moved.start.x, moved.start.y, moved.target.x, moved.target.y) == (0.75, 0.65, 0.75, 1.0)
    assert [(event.ix, event.iy) for event in moved.timeline] == [(4, 12)]


def test_a_scale_doubles_every_length_and_the_speed():
    large = scaled(UP)
    assert (large.cell_size, large.robot_radius, large.robot_speed) == (
        0.2,
        2 * UP.robot_radius,
        4.0,
    )
    assert (large.start.x, large.target.radius) == (0.9, 0.1)


@pytest.fixture
def spy(tmp_path):
    """A controller that looks into the simulator: it stays where it is if there is any wall."""
    (tmp_path / "spy.py").write_text(
        "import sys\nfrom sim import Command\n"
        "class Spy:\n"
        "    def reset(self): return ()\n"
        "    def act(self, o, memory):\n"
        "        frame = sys._getframe()\n"
        "        while not hasattr(frame.f_locals.get('arena'), 'cells'): frame = frame.f_back\n"
        "        walls = frame.f_locals['arena'].cells.sum()\n"
        "        return Command(0.0 if walls else o.top_speed), memory\n"
    )
    return f"{tmp_path}/spy.py:Spy"


WIDE = certified(
    World(np.zeros((9, 19), bool), Pose(0.95, 0.15, math.pi / 2), Target(0.95, 0.5, 0.05))
)


def test_a_controller_that_knows_of_walls_which_it_cannot_sense_is_seen(spy):
    said = objection("wall", spy, WIDE)
    assert said["kind"] == "then-loop" and said["walls"] > 10


@pytest.mark.gate
def test_an_objection_to_walls_that_nobody_senses_is_replayed_and_shrunk(spy):
    small = shrink(failing("wall", spy, WIDE)).failure
    assert small.record.details["class"] == "wall-then-loop" and small.record.details["one_minimal"]
    assert small.world.walls.size < WIDE.walls.size and replay(small).confirmed


HALL = certified(replace(BLOCK, walls=np.pad(BLOCK.walls, ((0, 12), (0, 3)))))


@pytest.mark.parametrize("motion", ["swept", "endpoint", "stepped"])
def test_walls_far_from_a_robot_that_feels_its_way_change_nothing(motion):
    trial = Trial(HALL, "turn-right", RunOptions(motion, 4000))
    assert walled_where_unnoticed(trial).solid_cells > HALL.solid_cells + 10
    assert NamedOracle.parse("wall").check(trial) is None


@pytest.mark.gate
@pytest.mark.parametrize(
    "controller", ["vfh", "three-layer", "turn-right+signal=blocked", "vfh+beam_dropout=0.5"]
)
def test_walls_that_beams_or_a_signal_would_notice_are_not_added(controller):
    scenario, hall = Scenario.parse(controller), generate("maze", seed=4)
    trial = Trial(hall, scenario.controller, scenario.options(hall))
    there = trial.again(walled_where_unnoticed(trial))
    assert (there.steps, there.trace_digest) == (trial.episode.steps, trial.episode.trace_digest)


def test_a_witness_holds_between_the_walls_that_are_added():
    for add in (walled_where_unnoticed, with_a_block_near_the_path):
        world = add(Trial(HALL, "bug1", RunOptions(steps=4000)))
        assert check_certificate(world).valid and (world.walls >= HALL.walls).all()


def test_where_every_cell_is_sensed_there_is_no_room_for_walls():
    assert walled_where_unnoticed(Trial(UP, "vfh", RunOptions(steps=4000))) is None


def test_a_world_that_changes_is_not_asked_about_walls():
    assert (
        objection("wall", "bug1", CHANGING) is None and objection("block", "bug1", CHANGING) is None
    )


def test_walls_that_hold_up_the_thesis_s_signal_count_everywhere():
    with raises(InvalidParameter, "signal-everywhere"):
        objection("wall", "turn-right", motion="stepped", thesis=ThesisOptions(signal="blocked"))


def test_a_block_beside_the_way_shows_a_seeded_fault():
    world = read_world(
        Path(__file__).parents[1] / "data" / "faults" / "bug1-lost-wall-wrong-side.grid"
    )
    assert objection("block", world.failure.controller, world)["kind"] == "only-there"
    assert objection("block", "bug1", world) is None


def test_a_factor_also_says_how_much_longer_the_way_past_a_block_may_be():
    astray = replace(BLOCK, walls=np.pad(np.ones((2, 3), bool), ((3, 4), (3, 6))))
    assert objection("block", "bug1", astray) is None
    assert objection("block=1", "bug1", astray)["kind"] == "slower"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("detuor=5", {"code": "unknown-name", "name": "detuor", "near": "detour"}),
        ("detour", {"code": "needs-a-number", "name": "detour", "number": "bound"}),
        ("detour=far", {"code": "not-a-number", "number": "far"}),
        ("detour=nan", {"code": "not-a-number", "number": "nan"}),
        ("detour=0.5", {"code": "below-minimum", "bound": 0.5}),
        ("turn=0.5", {"code": "below-minimum", "factor": 0.5}),
        ("repeat=1.5", {"code": "out-of-range"}),
        ("", {"code": "empty-name"}),
    ],
)
def test_what_is_no_oracle_is_refused(text, expected):
    with raises(InvalidParameter, **expected):
        objection(text)


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("bad = 3", {"code": "not-a-function", "kind": "int"}),
        ("def bad(): return None", {"code": "wrong-signature"}),
        ("def bad(trial): return 1 / 0", {"code": "code-failed", "kind": "ZeroDivisionError"}),
        ("def bad(trial): return True", {"code": "wrong-oracle-answer", "answer": "True"}),
        ("def bad(trial): return {'way': float('inf')}", {"code": "wrong-oracle-answer"}),
        (
            "def bad(trial, deep=[]):\n deep.append(deep)\n return {'way': deep}",
            {"code": "wrong-oracle-answer", "most": 16},
        ),
        ("def bad(trial): raise SystemExit(3)", {"code": "code-failed"}),
        ("def loop(trial): return None", {"code": "name-is-a-verdict"}),
    ],
)
def test_an_oracle_that_is_none_is_refused(code, expected, tmp_path):
    (tmp_path / "mine.py").write_text(code + "\n")
    name = "loop" if "loop" in code else "bad"
    with raises(InvalidParameter, **expected):
        objection(f"{tmp_path}/mine.py:{name}")


def test_numbers_of_numpy_are_evidence_like_others(tmp_path):
    code = (
        "import numpy as np\ndef many(trial): return {'n': np.int64(3), 'x': np.float32(0.5), "
        "'b': [np.True_]}"
    )
    (tmp_path / "mine.py").write_text(code)
    said = objection(f"{tmp_path}/mine.py:many")
    assert said == {"n": 3, "x": 0.5, "b": [True]} and {type(said["n"]), type(said["x"])} == {
        int,
        float,
    }


def test_an_oracle_without_a_number_takes_none(tmp_path):
    (tmp_path / "mine.py").write_text(
        "def mine(trial): return {'kind': 'a/b c', 'x': [1, (2, 3)]}\n"
    )
    with raises(InvalidParameter, "takes-no-number"):
        NamedOracle.parse(f"{tmp_path}/mine.py:mine=3")
    oracle = NamedOracle.parse(f"{tmp_path}/mine.py:mine")
    found = oracle.check(Trial(BLOCK, "bug1", RunOptions(steps=4000)))
    assert found.bucket == "mine-a-b-c"
    assert found.facts["x"] == [1, [2, 3]]


def test_a_violation_is_described():
    found = Violation("detour-x", None, "detour=2", {"kind": "x", "ratio": 2.5})
    assert found.in_words == ", but oracle detour=2 objects: ratio 2.5"
    assert Violation("loop", None).in_words == ""


def test_a_detour_is_fixed_when_the_oracle_has_nothing_to_say(tmp_path):
    failing("detour=2").write(tmp_path / "w.grid")
    assert "reached, but oracle detour=2 objects: path" in check(tmp_path / "w.grid").reason
    assert check(tmp_path / "w.grid", controller="bug2").reason == ""
    assert check(tmp_path / "w.grid", CONFIRMED).reason == ""


def test_a_campaign_refuses_an_oracle_that_is_not_there_before_it_begins(tmp_path):
    result = worldgen(
        "fuzz",
        "--controller",
        "bug1",
        "--oracle",
        "detuor=5",
        "--units",
        1,
        "--seed",
        1,
        "--out",
        tmp_path / "f",
    )
    assert (
        result.code == 2 and result.error_code == "unknown-name" and not (tmp_path / "f").exists()
    )


@pytest.mark.gate
def test_a_campaign_finds_the_same_with_one_worker_and_with_two(tmp_path):
    fuzz = (
        "fuzz",
        "--controller",
        "bug1",
        "--oracle",
        "detour=3",
        "--units",
        2,
        "--examples",
        20,
        "--seed",
        2,
        "--no-shrink",
    )
    for workers in (1, 2):
        assert worldgen(*fuzz, "--workers", workers, "--out", tmp_path / str(workers)).code == 1
    one, two = (
        {file.name: file.read_bytes() for file in (tmp_path / n).glob("*.grid")} for n in "12"
    )
    assert one == two and "detour.grid" in one


def test_the_list_of_oracles_says_how_each_is_written():
    listed = json.loads(worldgen("oracles", "--json").out)["oracles"]
    assert [one["name"] for one in listed] == ORACLES.names()
    written = {one["name"]: one["written"] for one in listed}
    assert (written["detour"], written["repeat"], written["wall"]) == (
        "detour=NUMBER", "repeat[=NUMBER]", "wall",
    )  # fmt: skip
    assert len(worldgen("oracles").out.splitlines()) == len(listed) + 1
