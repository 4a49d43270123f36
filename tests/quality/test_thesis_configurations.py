"""The ten configurations behave like the lost ones in the thesis's table."""

import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import thesis_table
from sim import RunOptions, Scenario, simulate
from sim.episode import prepare
from sim.verdict import NEVER
from tests.helpers.command_line import worldgen
from worldgen import read_world
from worldgen.reach.check.certificate import check_certificate

FOLDER = thesis_table.FOLDER
NAMES = thesis_table.NAMES
ROBOTS = thesis_table.ROBOTS
TICK = thesis_table.TICK


@pytest.fixture(scope="module")
def table():
    return thesis_table.run()


@pytest.fixture(scope="module")
def beside(table):
    return thesis_table.agreement(table, thesis_table.published())


@pytest.mark.gate
@pytest.mark.parametrize("first_seed", [100, 1000, 77_777])
def test_ranks_and_never_do_not_hang_on_the_seeds(first_seed):
    found = thesis_table.agreement(
        thesis_table.run(first_seed=first_seed), thesis_table.published()
    )
    assert (found.rankings, found.never) == (10, (5, 5)) and found.within[0] >= 8


def test_in_configuration_6_the_rules_do_what_the_prose_says():
    world = read_world(FOLDER / "config-06.grid")
    # The upper of its two obstacles comes first.
    inner = np.argwhere(world.walls[1:-1, 1:-1]) + 1
    obstacles = [inner[inner[:, 0] >= 15], inner[inner[:, 0] < 15]]
    touched = {}
    for rule in ("thesis-1", "thesis-2"):
        episode = simulate(world, rule, motion="stepped", steps=2000, record=True)
        places = np.column_stack((episode.trace.y, episode.trace.x))[episode.trace.bump]
        away = [
            np.linalg.norm(places[:, None] - (cells + 0.5) * 0.1, axis=2).min(axis=1)
            for cells in obstacles
        ]
        near = np.argmin(away, axis=0)[np.min(away, axis=0) < 0.15]
        touched[rule] = near.tolist()

    # Rule 1 collides with both; the first one leads rule 2 to the second, which catches it.
    assert set(touched["thesis-1"]) == {0, 1}
    assert touched["thesis-2"][0] == 0 and touched["thesis-2"][-1] == 1
    assert episode.verdict == "loop"

    # Had the first one not been present, rule 2 would have succeeded.
    walls = world.walls.copy()
    walls[tuple(obstacles[0].T)] = False
    free = replace(world, walls=walls, certificate=None)
    assert simulate(free, "thesis-2", motion="stepped", steps=2000).verdict == "reached"


def test_the_published_table_is_whole_and_in_whole_ticks():
    figures = thesis_table.published()
    assert set(figures) == {(world, robot) for world in NAMES for robot in ROBOTS}
    times = [time for own in figures.values() for time in own]
    # One figure is from the text, besides the table's thirty.
    assert times.count(math.inf) == 5 and len(times) == 31
    ticks = [time / TICK for time in times if time < math.inf]
    assert all(abs(tick - round(tick)) < 1e-9 for tick in ticks)


@pytest.mark.gate
def test_the_robots_rank_as_in_the_thesis(beside):
    assert beside.rankings == 10


@pytest.mark.gate
def test_never_comes_where_the_thesis_says_so_and_nowhere_else(beside):
    assert beside.never == (5, 5)


def test_every_never_of_the_two_rules_without_chance_is_a_proved_loop(table):
    never = {
        (cell.world, cell.label): cell.detail
        for row in table.cells
        for cell in row[:2]
        if cell.verdict in NEVER
    }
    assert sorted(never) == [
        ("config-05", "thesis-2"), ("config-06", "thesis-2"), ("config-08", "thesis-1"), ("config-09", "thesis-1"),
    ]  # fmt: skip
    rectangle = {key: detail == "period 104" for key, detail in never.items()}
    assert (
        rectangle.pop(("config-09", "thesis-1")) is False
    )  # "the shape traced is not that of a rectangle"
    assert all(rectangle.values())


def test_times_of_the_two_rules_without_chance_are_within_one_per_cent(beside):
    assert abs(beside.largest) <= 0.01


def test_every_published_time_of_the_random_rule_lies_in_the_middle_of_our_seeds(beside):
    assert beside.within[0] >= beside.within[1] - 1 and beside.within[1] == 9


@pytest.mark.gate
def test_the_random_rule_is_lost_in_configuration_5_for_a_million_ticks():
    world, lost = read_world(FOLDER / "config-05.grid"), 0
    for seed in range(10):
        options = Scenario("thesis-3", RunOptions("stepped", time_step=TICK, seed=seed)).options(
            world, 1_000_000
        )
        outcome = prepare(world, "thesis-3", options).run(
            1_000_000, find_loop=False, record=False, digest=False
        )
        lost += outcome.verdict in ("timeout", "stalled")
    assert lost >= 8


@pytest.mark.parametrize("name", NAMES)
def test_a_configuration_has_the_start_of_the_thesis_and_a_proof(name):
    world = read_world(FOLDER / f"{name}.grid")
    side = world.walls.shape[0] * world.cell_size
    assert (
        world.walls.shape[0] == world.walls.shape[1]
        and world.walls[[0, -1]].all()
        and world.walls[:, [0, -1]].all()
    )
    assert (world.start.x, world.start.y) == pytest.approx((0.35, side - 0.35))
    assert check_certificate(world).valid
    middle = world.target.x > 0.6 * side and world.target.y < 0.4 * side
    assert middle or name == "config-10"


def test_the_target_of_configuration_10_is_at_the_centre_and_few_collisions_lead_to_it():
    world = read_world(FOLDER / "config-10.grid")
    centre = np.array(world.walls.shape) * world.cell_size / 2
    assert np.abs(centre - [world.target.x, world.target.y]).max() <= 0.3
    for robot in ROBOTS[:2]:
        assert simulate(world, robot, motion="stepped").collisions <= 8


@pytest.mark.nightly
def test_a_configuration_is_found_again_by_the_command_in_its_folder(tmp_path):
    outcome = "thesis-1=reached@2554, thesis-2=loop@104"
    sketch = FOLDER / "sketches" / "config-05.grid"
    result = worldgen(
        "find", "--from", sketch, "--leash", 4, "--motion", "stepped", "--outcome", outcome,
        "--units", 3, "--seed", 3, "--workers", 1, "--out", tmp_path / "again.grid",
    )  # fmt: skip
    assert result.code == 0, result.err
    assert (tmp_path / "again.grid").read_bytes() == (FOLDER / "config-05.grid").read_bytes()


@pytest.mark.gate
def test_the_table_of_the_documentation_is_what_the_study_prints():
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    printed = CliRunner().invoke(thesis_table.main, []).output
    assert f"```text\n{printed}```" in page
