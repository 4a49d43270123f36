"""Comparisons: every number matches its runs."""

import csv
import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.stats import binomtest

from sim import Scenario, simulate
from sim.compare.comparison import NamedWorld, compare, standing
from sim.compare.picture import draw_comparison
from sim.compare.report import as_text, describe_outcome
from sim.controllers import names_in
from sim.outcome import FleetEpisode
from tests.helpers.command_line import worldgen
from tests.helpers.fleets import EAST, WEST, fleet_world, passage
from tests.helpers.fleets import hall as empty_hall
from tests.helpers.raising import raises
from tests.sim.test_thesis_options import hall
from tests.sim.test_thesis_vectors import VECTORS, world_of
from worldgen import InvalidParameter, InvalidWorld, Pose, generate, read_world, write_world
from worldgen.render.marks import rgb
from worldgen.render.sheet import series_colour
from worldgen.support.intervals import interval_95
from worldgen.world import Robot, Target

EMPTY = NamedWorld("empty", hall((15, 15)))
WALL = NamedWorld("wall", hall((24, 24), walls=[(x, 15) for x in range(10, 19)]))
LOOP = NamedWorld("loop", world_of(VECTORS["demo-7"]))
FLEET = NamedWorld(
    "fleet",
    fleet_world(
        empty_hall(),
        Robot(Pose(0.5, 0.5, EAST), Target(3.5, 0.5, 0.05)),
        Robot(Pose(3.5, 0.5, WEST), Target(0.5, 0.5, 0.05)),
        Robot(Pose(0.5, 1.5, EAST), Target(1.5, 1.5, 0.05)),
    ),
)
CONFIGURATIONS = Path(__file__).parents[2] / "corpora" / "thesis"


def scenarios(*texts, motion="stepped", seed=0):
    return {text: Scenario.parse(text, motion=motion, time_step=0.015, seed=seed) for text in texts}


@pytest.fixture(scope="module")
def table():
    return compare([EMPTY, WALL, LOOP], scenarios("thesis-1", "thesis-2", "thesis-3"), seeds=20)


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "worlds"
    folder.mkdir()
    for world in (EMPTY, WALL, LOOP):
        write_world(world.world, folder / f"{world.name}.grid")
    return folder


@given(st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_interval_is_the_exact_one(counts):
    count, total = counts
    expected = binomtest(count, total).proportion_ci(0.95, method="exact")
    assert interval_95(count, total) == pytest.approx((expected.low, expected.high), abs=1e-9)


@pytest.mark.parametrize(
    ("times", "best", "worst"),
    [
        ([3.0, 2.0, math.inf], (1,), (2,)),
        ([2.0, 2.0, 5.0], (0, 1), (2,)),
        ([math.inf, math.inf], (), ()),
        ([4.0, 4.0], (0, 1), ()),
        ([math.inf, 4.0, math.inf], (1,), (0, 2)),
    ],
)
def test_who_was_best_and_who_was_worst(times, best, worst):
    assert standing(times) == (best, worst)


def test_every_cell_without_chance_is_the_run_itself(table):
    for row, world in zip(table.cells, table.worlds, strict=True):
        for cell in row[:2]:
            episode = simulate(world.world, cell.label, motion="stepped", steps=cell.budget)
            run = cell.runs[0]
            assert (run.verdict, run.steps, run.time) == (
                episode.verdict,
                episode.steps,
                episode.time,
            )
            assert cell.evidence == episode.evidence or episode.verdict == "reached"


def test_every_run_with_chance_is_the_run_with_its_seed(table):
    cell = table.cells[1][2]
    assert [run.seed for run in cell.runs] == list(range(20))
    for run in cell.runs:
        episode = simulate(
            WALL.world, "thesis-3", motion="stepped", seed=run.seed, steps=cell.budget
        )
        assert (run.verdict, run.steps) == (episode.verdict, episode.steps)


def test_the_time_of_one_with_chance_is_the_median_of_those_that_arrive(table):
    cell = table.cells[1][2]
    times = sorted(run.time for run in cell.runs if run.verdict == "reached")
    middle = len(times) // 2
    assert cell.time == pytest.approx((times[middle] + times[-middle - 1]) / 2)
    assert cell.shown.time in times and cell.percentile(50) == times[math.ceil(len(times) / 2) - 1]


def test_an_exact_loop_says_its_period_and_counts_as_never(table):
    cell = table.cells[2][0]
    assert cell.detail == f"period {cell.evidence.period}" and cell.rank_time == math.inf
    assert f"never (loop, period {cell.evidence.period})" in as_text(table)


def test_totals_add_up_and_compare_times_only_where_everybody_arrives(table):
    for total, column in zip(table.totals(), zip(*table.cells, strict=True), strict=True):
        assert (
            total.reached + sum(total.failures.values())
            == total.runs
            == sum(len(cell.runs) for cell in column)
        )
        assert total.mean_time == pytest.approx(
            sum(column[row].time for row in table.common) / len(table.common)
        )
    assert 2 not in table.common


def test_a_world_with_a_cut_does_not_count_in_the_totals():
    worlds = [
        NamedWorld(str(share), generate("corridor", 1, blocked=share)) for share in (0.0, 1.0)
    ]
    result = compare(worlds, scenarios("bug2", motion="swept"))
    (total,) = result.totals()
    assert result.cells[1][0].reached == 0 and result.blocked == (1,)
    assert (total.runs, total.reached, total.failures) == (1, 1, {})
    assert "cannot be reached: 1.0." in str(as_text(result))
    (none,) = compare(worlds[1:], scenarios("bug2", motion="swept")).totals()
    assert (none.runs, none.reached, none.interval) == (0, 0, None)


def waverer(folder):
    """Return the name of a controller that draws random numbers."""
    (folder / "mine.py").write_text(
        "from sim import Command\n"
        "class Waverer:\n"
        "    def reset(self):\n"
        "        return ()\n"
        "    def act(self, observation, memory):\n"
        "        return Command(observation.top_speed, 20.0 * observation.random - 10.0, "
        "used_random=True), memory\n"
    )
    return f"{folder}/mine.py:Waverer"


def test_a_controller_that_draws_random_numbers_runs_with_every_seed(tmp_path):
    name = waverer(tmp_path)
    cell = compare([EMPTY], scenarios(name, motion="swept"), seeds=3, steps=300).cells[0][0]
    assert cell.random and [run.seed for run in cell.runs] == [0, 1, 2]
    assert cell.interval == interval_95(cell.reached, 3)


def test_switches_that_draw_random_numbers_make_a_controller_random():
    cell = compare([WALL], scenarios("thesis-1+slip=0.2", seed=5), seeds=4).cells[0][0]
    assert [run.seed for run in cell.runs] == [5, 6, 7, 8] and len(
        {run.steps for run in cell.runs}
    ) > 1


def test_a_world_without_room_is_named():
    outside = NamedWorld("cramped", replace(EMPTY.world, start=Pose(0.05, 0.05, 0.0)))
    with raises(InvalidWorld, "start-in-wall", world="cramped"):
        compare([outside], scenarios("thesis-1"))


def test_what_cannot_run_is_refused_before_the_first_run():
    told = []
    with raises(InvalidParameter, "unknown-name", name="thesis-9"):
        compare([EMPTY], scenarios("thesis-1", "thesis-9"), progress=told.append)
    assert not told


def test_a_run_too_long_to_prove_has_no_arrival_and_is_not_never(tmp_path):
    world = NamedWorld(
        "drifting", read_world(CONFIGURATIONS.parent / "thesis-faults" / "thesis-1-drifting.grid")
    )
    cell = compare([world], scenarios("thesis-1"), steps=2_100_000).cells[0][0]
    assert (cell.verdict, cell.is_unended, cell.detail) == ("stalled", True, "")
    assert describe_outcome(cell) == "no arrival (stalled)"


def test_the_command_prints_the_table_and_the_totals(folder):
    result = worldgen("compare", folder, "--controller", "thesis-1,thesis-2", "--motion", "stepped")
    assert result.code == 0
    lines = result.out.splitlines()
    assert lines[0].split() == ["world", "thesis-1", "thesis-2", "best", "worst"]
    assert [line.split()[0] for line in lines[1:4]] == ["empty", "loop", "wall"]
    assert any(line.startswith("arrived") for line in lines)


def test_csv_json_and_picture_hold_what_was_printed(folder, tmp_path):
    out, sheet = tmp_path / "new.csv", tmp_path / "sheet.png"
    arguments = [
        "compare",
        folder,
        "--controller",
        "thesis-1,thesis-3",
        "--motion",
        "stepped",
        "--seeds",
        5,
    ]
    result = worldgen(*arguments, "--csv", out, "--picture", sheet, "--json")
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    cells = [cell for row in json.loads(result.out)["worlds"] for cell in row["cells"]]
    assert [int(row["reached"]) for row in rows] == [cell["reached"] for cell in cells]
    assert [row["time"] for row in rows] == [
        "never" if cell["verdict"] == "loop" else str(cell["time"]) if cell["time"] else ""
        for cell in cells
    ]
    assert Image.open(io.BytesIO(sheet.read_bytes())).width > 600


def test_worlds_of_one_name_in_two_folders_are_told_apart(folder, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    write_world(EMPTY.world, other / "empty.grid")
    result = worldgen(
        "compare", folder / "empty.grid", other, "--controller", "turn-left", "--json"
    )
    names = [row["world"] for row in json.loads(result.out)["worlds"]]
    assert names == [str(folder / "empty"), str(other / "empty")]


def test_each_controller_drives_all_robots_of_a_world():
    columns = scenarios("right-hand", "naive", "turn-random", motion="swept")
    mixed = compare([FLEET, EMPTY], columns, seeds=3)
    alone = compare([EMPTY], columns, seeds=3)
    for cell in mixed.cells[0]:
        for run in cell.runs:
            episode = simulate(FLEET.world, cell.label, seed=run.seed, steps=cell.budget)
            assert isinstance(episode, FleetEpisode)
            assert (run.verdict, run.steps, run.time, run.area_covered) == (
                episode.verdict,
                episode.steps,
                episode.time,
                episode.area_covered,
            )
    # A world with one robot has the same cells whatever other worlds are compared.
    assert mixed.cells[1] == alone.cells[0]
    right_hand, naive, chance = mixed.cells[0]
    assert right_hand.arrives and right_hand.time == right_hand.runs[0].time
    assert (naive.verdict, naive.detail, naive.is_unended) == ("deadlock", "1 of 3 arrive", True)
    assert chance.random and [run.seed for run in chance.runs] == [0, 1, 2]


def test_a_python_controller_that_draws_runs_fleets_with_every_seed(tmp_path):
    name = waverer(tmp_path)
    cell = compare([FLEET], scenarios(name, motion="swept"), seeds=3, steps=40).cells[0][0]
    assert cell.random and [run.seed for run in cell.runs] == [0, 1, 2]


def test_the_legend_of_a_picture_is_never_cut_off():
    names = ["bug2", "three-layer+beam_noise=0.1", "thesis-3+slip=0.2"]
    drawn = draw_comparison(compare([EMPTY], scenarios(*names, motion="swept"), steps=5))
    picture = np.asarray(Image.open(io.BytesIO(drawn)).convert("L"))
    # The legend's line is drawn to near the right edge, but not beyond it.
    ink = np.flatnonzero((picture[14:36] < 250).any(axis=0))
    assert picture.shape[1] - 40 < ink.max() < picture.shape[1] - 2


def test_the_command_compares_fleets_as_text_csv_json_and_picture(tmp_path):
    folder = tmp_path / "worlds"
    folder.mkdir()
    for world in (FLEET, EMPTY):
        write_world(world.world, folder / f"{world.name}.grid")
    table = tmp_path / "new.csv"
    sheet = tmp_path / "sheet.png"
    arguments = ["compare", folder, "--controller", "right-hand,naive"]
    told = worldgen(*arguments, "--csv", table, "--picture", sheet)
    assert told.code == 0 and "never (deadlock, 1 of 3 arrive)" in told.out
    found = json.loads(worldgen(*arguments, "--json").out)
    fleet = next(row for row in found["worlds"] if row["world"] == "fleet")
    assert fleet["robots"] == 3 and fleet["best"] == ["right-hand"]
    assert fleet["cells"][1]["evidence"]["waiting"] == [1, 2]
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert [(row["world"], row["reached"]) for row in rows[2:]] == [("fleet", "1"), ("fleet", "0")]
    assert Image.open(io.BytesIO(sheet.read_bytes())).width > 600


def test_a_controller_has_one_colour_for_all_robots_that_it_drives():
    picture = draw_comparison(compare([FLEET], scenarios("right-hand", "naive", motion="swept")))
    sheet = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"))
    # Below the legend, only paths and the dots at their ends have a controller's pure colour. The
    # last controller's paths are on top. The third robot's path is a metre above the others', a
    # quarter of the panel's width.
    rows = np.flatnonzero((sheet[40:] == rgb(series_colour(1))).all(axis=2).any(axis=1))
    assert np.ptp(rows) > 50


def test_a_motion_for_one_robot_names_the_world_of_several():
    with raises(InvalidParameter, "motion-for-one-robot", world="fleet", column="turn-left"):
        compare([FLEET], scenarios("turn-left"))


@pytest.mark.gate
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{}", "--controller", "thesis-1,thesis-1"], "named twice"),
        (["{}", "--controller", "thesis-1,"], "an empty text is not a name"),
        (["{}", "{}/empty.grid", "--controller", "thesis-1"], "given twice"),
        (["{}/none", "--controller", "thesis-1"], "none"),
        (["{}", "--controller", "thesis-1", "--picture", "a.svg"], "use a name that ends in .png"),
        (["{}", "--controller", "thesis-1", "--motion", "stepd"], "stepped"),
        (["{}", "--controller", "thesis-1", "--csv", "{}/empty.grid"], "--force"),
        (["{}", "--controller", ",".join(f"thesis-1+sensor_range={40 + k}" for k in range(9)), "--picture", "a.png"],
         "name fewer"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(folder, arguments, message):
    result = worldgen("compare", *(text.format(folder) for text in arguments))
    assert result.code == 2 and message in result.err and "Traceback" not in result.err


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("turn-left,bug1+sensor_noise=0.1", ["turn-left", "bug1+sensor_noise=0.1"]),
        ("cmd:python x.py --a 1,2", ["cmd:python x.py --a 1,2"]),
        ("cmd:./a --map b,c.png,turn-left", ["cmd:./a --map b,c.png", "turn-left"]),
        ("cmd:./a --b 1,2,cmd+memory=none:./c", ["cmd:./a --b 1,2", "cmd+memory=none:./c"]),
        ("cmd:./a,./mine.py:Robot", ["cmd:./a", "./mine.py:Robot"]),
        ("thesis-1,", ["thesis-1", ""]),
    ],
)  # fmt: skip
def test_a_comma_in_a_command_line_belongs_to_it_unless_a_controller_follows(text, names):
    assert names_in(text) == names


def test_the_command_names_worlds_in_which_no_controller_can_arrive(tmp_path):
    write_world(passage(), tmp_path / "swap.grid")
    result = worldgen("compare", str(tmp_path), "--controller", "naive,pibt")
    assert "worlds in which no controller can arrive: swap" in result.err


def test_the_command_refuses_controllers_assigned_to_single_robots(tmp_path):
    write_world(passage(), tmp_path / "swap.grid")
    result = worldgen("compare", str(tmp_path), "--controller", "1=bug2,2=vfh")
    assert result.code == 2 and "drives all robots of a world with the same" in result.err
