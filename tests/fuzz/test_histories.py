"""Worlds are grown where they lead a controller's state further than before."""

import math
import statistics

import pytest

from benchmarks.real.planting import DEEP, write
from fuzz.campaign.run import Campaign
from fuzz.campaign.store.journal import UnitRecord
from fuzz.campaign.unit import run_unit
from fuzz.facts.unrun import unrun_lines
from fuzz.layouts.grown_worlds import grown, grown_world, new_genome
from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.search import small
from fuzz.search.archive import archive_table
from fuzz.search.histories import Histories, extremes_of, is_extreme
from fuzz.search.task import SearchTask
from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import Elite, SearchState, UnitResult
from sim import Command, simulate
from sim.clock.controller_time import Effort
from sim.controllers import CONTROLLERS
from sim.controllers.lines_run import begin_lines, report_lines, watch_lines
from sim.scenario import Scenario
from sim.verdict import Verdict
from worldgen import generate
from worldgen.random_streams import RandomStream
from worldgen.reach import check_certificate

ROBOT = """
from sim import Command


class Robot:
    def reset(self):
        self.touched = 0
        return (0.0, 5.0)

    def act(self, seen, memory):
        self.touched += seen.bump
        turn = seen.target_heading - seen.heading
        if memory[0] > 1e9:
            turn = self.recover()
        return Command(seen.top_speed, turn / seen.time_step), (memory[0] + 1.0, memory[1])

    def recover(self):
        side = 1.0

        return side


class Other:
    def act(self, seen, memory):
        return Command(0.0, 0.0), memory
"""


def genomes(edits, count=30):
    stream = RandomStream(3)
    for _ in range(count):
        genome = new_genome(stream)
        for _ in range(edits):
            genome = grown(genome, stream)
        yield genome


def worlds(edits):
    return [world for one in genomes(edits) if (world := grown_world(one, {})) is not None]


def grow(config, unit=0, memory=None):
    result = UnitResult(strategy="archive")
    triage = Triage(config, result)
    small.grow(SearchTask("archive", config, unit, memory or SearchState(), triage))
    triage.end()
    return result


@pytest.fixture
def robot(tmp_path):
    file = tmp_path / "robot.py"
    file.write_text(ROBOT)
    return f"{file}:Robot"


def test_every_grown_world_has_a_witness_that_holds():
    assert all(check_certificate(one).valid for edits in (0, 3) for one in worlds(edits))


def test_growing_makes_ways_longer():
    before, after = (
        statistics.median(one.certificate.duration for one in worlds(edits)) for edits in (0, 6)
    )
    assert after > 2 * before


@pytest.mark.parametrize("fill", [0, 1, 127, 255])
def test_any_bytes_are_a_genome(fill):
    assert grown_world(bytes([fill]) * SCENE_BYTES, {}) is None or fill < 256
    assert len(grown(bytes([fill]) * SCENE_BYTES, RandomStream(1))) == SCENE_BYTES


def test_extremes_are_of_numbers_that_change(robot):
    episode = simulate(generate("trap", seed=1), robot, record=True, steps=50)
    found = extremes_of(CONTROLLERS.get(robot), episode.trace)
    steps = {cell: value for cell, value in found.items() if cell[0] == 0}
    assert steps == {(0, 0, 1): float(episode.steps), (0, 0, 0): 0.0}
    assert sum(cell[0] == 1 for cell in found) == 2  # self.touched, least and most


def test_only_worlds_in_which_the_robot_arrives_are_grown():
    histories = Histories({})
    cell = (0, 0, 1)
    assert histories.take(b"a", {cell: 3.0}, "undecided") and histories.is_empty
    assert histories.take(b"b", {cell: 3.0}, Verdict.REACHED)
    assert not histories.take(b"c", {cell: 3.01}, Verdict.REACHED)
    assert histories.brought[cell].layout == b"b"


def test_numbers_that_grow_get_most_of_the_worlds():
    start = new_genome(RandomStream(1))
    cells = [(0, 0, 1), (0, 1, 1)]
    histories = Histories({cell: Elite(start, 1.0, "reached") for cell in cells})
    stream = RandomStream(2)
    value = 1.0
    chosen = dict.fromkeys(cells, 0)
    for _ in range(200):
        genome = histories.draw(stream)
        parent = histories._parent
        if parent is not None:
            chosen[parent] += 1
            value *= 1.1 if parent == cells[0] else 1.0
        histories.take(genome, {cells[0]: value, cells[1]: 1.0}, Verdict.REACHED)
    assert chosen[cells[0]] > 3 * chosen[cells[1]] > 0


def test_extremes_are_stored_and_stay_off_the_map_of_behaviours():
    cell = (0, 3, 1)
    elite = Elite(bytes(SCENE_BYTES), 812.0, "reached")
    result = UnitResult(strategy="archive", elites={cell: elite}, lines=frozenset({4, 9}))
    again = UnitRecord.of(1, result, 0.5).result(lambda _: None)
    assert is_extreme(cell) and again.elites == result.elites and again.lines == result.lines
    assert archive_table(result.elites) is None


def test_a_controller_without_state_is_not_grown_for():
    result = grow(CampaignConfig(Scenario(f"{__name__}:Stateless"), seed=1))
    assert not result.elites and result.worlds < 10


class Stateless:
    """Drives straight to the target."""

    def reset(self):
        return ()

    def act(self, seen, _memory):
        turn = (seen.target_heading - seen.heading + math.pi) % (2 * math.pi) - math.pi
        return Command(seen.top_speed, turn / seen.time_step), ()


def test_lines_that_never_ran_are_named_with_their_function(robot):
    config = CampaignConfig(Scenario(robot), seed=1, examples=2, families=("features",))
    begin_lines()
    result = run_unit(config, 0)
    assert unrun_lines(robot, result.lines) == ["14 (act)", "18-20 (recover)"]
    assert unrun_lines(robot, []) == []


def test_lines_that_are_known_to_run_are_not_counted_again(robot):
    controller = CONTROLLERS.get(robot)
    begin_lines()
    watch = watch_lines(controller)
    code = type(controller).act.__code__
    simulate(generate("trap", seed=1), robot, steps=5)
    assert {11, 12, 13, 15} <= watch.ran()
    report_lines()
    assert watch_lines(controller).ran() == frozenset()
    assert len(type(controller).act.__code__.co_code) < len(code.co_code)
    watch_lines(controller).stop()


def test_each_campaign_of_a_process_counts_all_of_its_lines(robot):
    config = CampaignConfig(
        Scenario(robot), seed=1, examples=2, families=("features",), shrink=False
    )
    ran = []
    for _ in range(2):
        campaign = Campaign(config, units=1)
        list(campaign.run())
        ran.append(campaign.state.memory.lines)
    assert ran[0] == ran[1] and 11 in ran[0]


def test_lines_of_one_controller_do_not_count_for_the_next(robot):
    begin_lines()
    watch_lines(CONTROLLERS.get(robot))
    simulate(generate("trap", seed=1), robot, steps=5)
    assert watch_lines(CONTROLLERS.get("bug2")) is None
    before = Effort.so_far()
    report_lines()
    assert not before.since().lines


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["long_wall", "recovery"])
def test_a_fault_that_needs_a_history_is_found(name, tmp_path):
    robot = DEEP[name]
    correct = write(robot, tmp_path / "correct", faulty=False)
    config = CampaignConfig(Scenario(write(robot, tmp_path / "faulty", faulty=True)), seed=1)
    memory = SearchState()
    for unit in range(25, 29):
        result = grow(config, unit, memory)
        memory = memory.after(result)
        for failure in result.failures.values():
            found = simulate(failure.world, correct, failure.options)
            if found.verdict == Verdict.REACHED or failure.verdict == Verdict.CRASH:
                return
    pytest.fail("not found in four units")
