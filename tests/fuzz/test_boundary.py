"""Boundaries: neighbouring values at which a robot arrives and fails, each proved.

And the strategy that finds them.
"""

import json
from collections import deque
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.boundary import (
    AXES,
    BoundaryRuns,
    Subject,
    describe_boundaries,
    nearest_boundary,
    subject_of,
)
from fuzz.boundary.axes import index_of, three_digits
from fuzz.campaign.unit import run_unit
from fuzz.find import AxisScan
from fuzz.shrink.queue import shrunk_or_same
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState
from sim import simulate
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen import Pose, Target, World, check_certificate, write_world
from worldgen.generation import generate

AHEAD = '''
from sim import Command

class Ahead:
    """Drives on as it stands; what is in the way stops it."""
    def reset(self): return ()
    def act(self, observation, memory): return Command(observation.top_speed, 0.0), memory
'''


def gap_world():
    """A gap 0.2 m wide straight ahead, and another one 0.4 m wide next to it.

    The wider robot must drive around.
    """
    walls = np.zeros((12, 12), bool)
    walls[:, 6] = True
    walls[2:4, 6] = walls[6:10, 6] = False
    return World(walls, Pose(0.25, 0.3, 0.0), Target(0.95, 0.3, 0.05))


@pytest.fixture
def ahead(tmp_path):
    (tmp_path / "ahead.py").write_text(AHEAD)
    return Scenario(f"{tmp_path}/ahead.py:Ahead")


@given(st.integers(-3000, 3000))
def test_numbers_of_three_digits_have_an_index_each_and_rise_with_it(index):
    assert index_of(three_digits(index)) == index and three_digits(index) < three_digits(index + 1)


def test_a_number_of_more_digits_goes_to_the_nearest():
    assert three_digits(index_of(0.123499)) == 0.123 and three_digits(index_of(9.9999)) == 10.0


def test_a_robot_that_drives_ahead_begins_to_fail_where_it_is_wider_than_the_gap(ahead):
    looks = BoundaryRuns(Subject(gap_world(), ahead), AXES["radius"])
    found = nearest_boundary(looks, index_of(0.07))
    assert found.record() == {"axis": "radius", "fails_at": 0.101, "passes_at": 0.1}


def test_with_room_to_spare_no_gap_counts_that_just_fits(ahead):
    looks = BoundaryRuns(Subject(gap_world(), ahead), AXES["radius"], spare=0.02)
    assert looks(index_of(0.2)) is None and not looks(index_of(0.196)).arrives


def test_from_the_failing_side_the_same_boundary_is_found(ahead):
    found = nearest_boundary(
        BoundaryRuns(Subject(gap_world(), ahead), AXES["radius"]), index_of(0.15)
    )
    assert (found.passes.value, found.fails.value) == (0.1, 0.101)


def test_both_ends_of_a_boundary_carry_a_witness(ahead):
    found = nearest_boundary(
        BoundaryRuns(Subject(gap_world(), ahead), AXES["radius"]), index_of(0.07)
    )
    assert all(check_certificate(look.subject.world).valid for look in (found.passes, found.fails))


def test_there_is_no_boundary_where_the_robot_always_arrives(ahead):
    empty = replace(gap_world(), walls=np.zeros((12, 12), bool))
    assert (
        nearest_boundary(BoundaryRuns(Subject(empty, ahead), AXES["speed"]), index_of(2.0)) is None
    )


def test_a_scan_tells_arriving_from_failing_from_having_no_way(ahead):
    found = scanned(Subject(gap_world(), ahead), range(index_of(0.05), index_of(0.4) + 1, 90))
    assert [(one.outcome, one.first, one.last) for one in found][:2] == [
        ("arrives", 0.05, 0.1),
        ("fails", 0.101, 0.2),
    ]
    assert {one.outcome for one in found[2:]} == {"no proof"}


def scanned(subject, indices):
    scan = AxisScan(subject, AXES["radius"], indices)
    deque(scan.run(), maxlen=0)
    return scan.stretches()


def test_a_scan_narrows_down_every_change_between_two_of_its_values(ahead):
    # It arrives at the first value, has no proof at the last, and fails at some in between.
    found = scanned(
        Subject(gap_world(), ahead),
        range(index_of(0.09), index_of(0.4) + 1, index_of(0.4) - index_of(0.09)),
    )
    assert [one.outcome for one in found] == ["arrives", "fails", "no proof"]
    assert [index_of(after.first) - index_of(before.last) for before, after in pairwise(found)] == [
        1,
        1,
    ]


def test_ctrl_c_reports_the_values_that_were_run(gap, monkeypatch):
    whole, left = BoundaryRuns._run, [10]

    def run_or_stop(self, index):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return whole(self, index)

    monkeypatch.setattr(BoundaryRuns, "_run", run_or_stop)
    result = worldgen("boundary", *gap, "radius", "--json")
    assert result.code == 130 and "run so far" in result.err
    assert sum(one["runs"] for one in json.loads(result.out)["stretches"]) == 10


def test_the_depth_of_a_trap_is_varied_and_nothing_else():
    subject = Subject(generate("trap", 7), Scenario("turn-right"))
    deep, shallow = (AXES["depth"].at(subject, depth).world for depth in (6.0, 2.0))
    assert deep.target == shallow.target and deep.solid_cells == shallow.solid_cells + 8


def test_only_a_trap_has_a_depth():
    assert AXES["depth"].index(Subject(gap_world(), Scenario("turn-right"))) is None


def test_a_shrunk_failure_says_where_it_begins_in_its_own_world():
    world = generate("trap", 7)
    proved = failure_of(world, Scenario("turn-right"))
    small = shrunk_or_same(proved).failure
    said = next(one for one in small.record.details["boundaries"] if one["axis"] == "speed")
    for at, arrives in ((said["passes_at"], True), (said["fails_at"], False)):
        run = AXES["speed"].at(Subject(small.world, Scenario("turn-right")), at)
        assert (simulate(run.world, "turn-right").verdict == "reached") is arrives


def test_what_a_record_says_of_its_boundaries_is_put_in_words():
    said = [{"axis": "radius", "fails_at": 0.083, "passes_at": 0.082}, {"axis": "luck"}, 7]
    failure = failure_of(generate("trap", 7), Scenario("turn-right"), boundaries=said)
    assert describe_boundaries(failure) == "begins at radius 0.083 m (0.082 passes)"


@pytest.mark.parametrize(
    "listed",
    [
        3,
        {"axis": "radius"},
        [{"axis": "radius", "fails_at": True, "passes_at": 0.1}],
        [{"axis": "radius", "fails_at": "0.1", "passes_at": 0.1}],
        [{"axis": 7, "fails_at": 0.1, "passes_at": 0.2}],
        [{"axis": "luck", "fails_at": 0.1, "passes_at": 0.2}],
        [[], None],
    ],
)
def test_a_record_of_boundaries_that_is_malformed_is_passed_over(listed):
    failure = failure_of(generate("trap", 7), Scenario("turn-right"))
    assert describe_boundaries(failure.noting(boundaries=listed)) == ""


CONFIG = CampaignConfig(Scenario("turn-right"), seed=4, examples=160, families=("boundary",))


@pytest.fixture(scope="module")
def found():
    first = run_unit(CONFIG, 0)
    return first, run_unit(CONFIG, 1, SearchState().after(first))


def failures_of(found, *, bounded):
    """Return the units' failures whose record has a boundary, or those without one."""
    failures = [failure for result in found for failure in result.failures.values()]
    chosen = [
        failure for failure in failures if ("boundaries" in failure.record.details) is bounded
    ]
    assert chosen
    return chosen


def test_every_failure_of_the_boundary_strategy_replays(found):
    for bounded in (True, False):
        assert all(replay(failure).confirmed for failure in failures_of(found, bounded=bounded))


def test_a_failure_of_the_boundary_strategy_that_does_not_say_where_it_begins_has_no_boundary_on_some_axis(
    found,
):
    for failure in failures_of(found, bounded=False):
        subject = subject_of(failure)
        starts = {axis: axis.index(subject) for axis in AXES.values()}
        assert any(
            start is not None
            and nearest_boundary(BoundaryRuns(subject, axis, spare=0.05), start) is None
            for axis, start in starts.items()
        )


def test_at_the_value_that_passes_the_robot_arrives(found):
    for failure in failures_of(found, bounded=True):
        said, record = failure.record.details["boundaries"][0], failure.record
        subject = Subject(
            failure.world,
            Scenario(
                "turn-right", RunOptions(time_step=record.parameters["time_step"], seed=record.seed)
            ),
        )
        before = AXES[said["axis"]].at(subject, said["passes_at"])
        world = before.world
        assert (
            simulate(world, "turn-right", before.scenario.options(world, 100_000)).verdict
            == "reached"
        )


def test_a_unit_is_the_same_again_with_the_same_memory(found):
    again = run_unit(CONFIG, 1, SearchState().after(found[0]))
    assert {k: w.dumps() for k, w in again.failures.items()} == {
        k: w.dumps() for k, w in found[1].failures.items()
    }


def test_what_is_known_to_fail_is_where_boundaries_are_looked_for():
    on_a_map = replace(CONFIG, fixed_map=gap_world())
    met = run_unit(replace(on_a_map, families=("map",)), 0, SearchState())
    assert met.failures
    memory = SearchState().after(met)
    assert (
        run_unit(on_a_map, 2, memory).worlds > 0
        and run_unit(on_a_map, 2, SearchState()).worlds == 0
    )


@pytest.fixture
def gap(tmp_path, ahead):
    write_world(gap_world(), tmp_path / "gap.grid")
    return (tmp_path / "gap.grid", "--controller", ahead.controller, "--axis")


def test_the_command_says_where_a_controller_begins_to_fail(gap):
    result = worldgen("boundary", *gap, "radius")
    assert (
        result.code == 1
        and "to 0.1 m: arrives" in result.out
        and "radius 0.101 to 0.14" in result.out
    )


def test_the_command_prints_one_json_object(gap):
    said = json.loads(worldgen("boundary", *gap, "radius", "--json").out)
    assert said["axis"] == "radius" and [one["outcome"] for one in said["stretches"]] == [
        "arrives",
        "fails",
    ]
    assert said["stretches"][1]["first"] == 0.101


def test_a_controller_that_arrives_at_every_value_is_exit_code_0(gap):
    assert worldgen("boundary", *gap, "speed").code == 0


def test_a_world_that_is_no_trap_has_no_depth(gap):
    result = worldgen("boundary", *gap, "depth")
    assert result.code == 2 and result.error_code == "not-a-trap"


def test_a_world_without_failure_needs_a_controller(gap):
    result = worldgen("boundary", gap[0], "--axis", "radius")
    assert result.code == 2 and "--controller" in result.err
