"""``worldgen check-scenarios``: published lengths agree, and differences are reported."""

import csv
import io
import json
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen

MAPS = Path(__file__).parents[2] / "corpora" / "maps"
ROWS = (".....", ".@@..", "..@..", "WW@SS", "WWTTS")


def octile(rows=ROWS):
    return f"type octile\nheight {len(rows)}\nwidth {len(rows[0])}\nmap\n" + "\n".join(rows) + "\n"


def problems(*rows, version="1", size=(5, 5), name="here.map"):
    lines = ["\t".join(map(str, (0, name, *size, *row))) for row in rows]
    return f"version {version}\n" + "\n".join(lines) + "\n"


@pytest.fixture
def check(tmp_path):
    """Return the command's JSON output for a map and a scenario file, and its exit code."""

    def run(scenario, rows=ROWS, options=()):
        (tmp_path / "here.map").write_text(octile(rows))
        (tmp_path / "here.map.scen").write_text(scenario)
        done = worldgen("check-scenarios", str(tmp_path), "--json", *options)
        return json.loads(done.out), done.code

    return run


@pytest.mark.gate
def test_every_problem_of_a_shipped_benchmark_map_agrees():
    done = worldgen("check-scenarios", str(MAPS))
    assert done.code == 0
    assert "shortest path as published" in done.out


def test_paths_stay_on_ground_on_water_or_among_trees(check):
    on_water, among_trees, into_water = (0, 3, 1, 4, 1.41421), (2, 4, 3, 4, 1), (0, 2, 0, 3, 0)
    found, code = check(problems(on_water, among_trees, into_water, (3, 3, 4, 1, 3)))
    assert (found["agree"], found["no_path"], code) == (3, 1, 1)  # the last is 1 + sqrt(2)


def test_a_wrong_length_is_told_with_ours(check):
    found, code = check(problems((0, 0, 4, 0, 4), (0, 0, 4, 0, 4.001)))
    assert (found["agree"], found["differ"], code) == (1, 1, 1)
    assert (
        "the shortest path has 4 cells, the published length is 4.001"
        in found["reports"][0]["fault"]
    )


def test_two_decimals_are_enough_in_version_1_0(check):
    assert check(problems((2, 0, 4, 2, 3.41), version="1.0"))[1] == 0
    assert check(problems((2, 0, 4, 2, 3.41)))[1] == 1


def test_a_path_that_is_not_there_is_told(check):
    found, code = check(problems((0, 0, 0, 4, 4)))
    assert (found["unreachable"], code) == (1, 1)


def test_the_map_is_scaled_to_the_problems(check):
    found, code = check(problems((6, 0, 8, 2, 2.82843), size=(10, 10)))
    assert (found["agree"], found["scaled"], code) == (1, 1, 0)


def test_swapped_sizes_are_told(check):
    found, code = check(problems((0, 0, 1, 0, 1), size=(2, 3)), rows=("...", "..."))
    assert (found["misfit"], code) == (1, 1)
    assert "swap the two" in found["reports"][0]["fault"]


def test_rows_are_drawn_by_seed(check):
    ten = problems(*((0, 0, n % 5, 0, n % 5) for n in range(10)))
    assert check(ten, options=("--rows", "3"))[0]["problems"] == 3


@pytest.mark.parametrize(
    ("scenario", "told"),
    [
        (problems((0, 0, 5, 0, 5)), "are not in the map"),
        (problems((0, 0, 1, 0, 1), name="other.map"), "do not include other.map"),
        (problems((0, 0, 1, 0, 1)) + problems((0, 0, 1, 0, 1), name="b.map")[10:], "use a file "
                                                                                   "for each map"),
        (problems((0, 0, 1, 0, 1)) + problems((0, 0, 1, 0, 1), size=(6, 6))[10:], "use a separate file for "
                                                                                  "each"),
        (problems((0, 0, 1, 0, 1), size=(99999, 99999)), "sides of 1 to"),
        (problems((0, 0, 1, 0, 1), size=(8000, 8000)), "the limit for solving"),
        ("version 2\n", "in place of"),
    ],
    ids=["outside", "no-map", "two-maps", "two-sizes", "beyond", "too-large", "no-scenario"],
)  # fmt: skip
def test_a_file_that_cannot_be_solved_is_told_and_the_rest_goes_on(check, scenario, told):
    found, code = check(scenario)
    assert (code, found["agree"]) == (1, 0)
    assert told in found["reports"][0]["fault"]


def test_the_table_has_a_line_a_file(check, tmp_path):
    check(problems((0, 0, 1, 0, 1)), options=("--csv", str(tmp_path / "out.csv")))
    (line,) = csv.DictReader(io.StringIO((tmp_path / "out.csv").read_text()))
    assert (line["problems"], line["agree"], line["fault"]) == ("1", "1", "")


def test_a_folder_without_scenarios_is_refused(tmp_path):
    done = worldgen("check-scenarios", str(tmp_path))
    assert done.code == 2
    assert done.error_code == "no-map-found"
