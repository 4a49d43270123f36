"""``worldgen measure``: one world as a list, several as a table, and output for programs."""

import csv
import io
import json
import os
from dataclasses import replace

import pytest

from tests.helpers.command_line import worldgen as run
from worldgen.difficulty import METRICS, measure
from worldgen.files.grid import read_world, write_world
from worldgen.generation import generate


@pytest.fixture
def folder(tmp_path):
    for seed in (1, 2):
        write_world(generate("trap", seed), tmp_path / f"w{seed}.grid")
    return tmp_path


def test_one_world_is_a_list_of_its_metrics_with_units(folder):
    result = run("measure", folder / "w1.grid")
    assert result.code == 0
    lines = {line.split()[0]: line for line in result.out.splitlines()[1:]}
    assert set(lines) == set(measure(generate("trap", 1)).as_dict())
    assert lines["bottleneck"].split()[1:3] == [f"{measure(generate('trap', 1)).bottleneck:g}", "m"]


def test_several_worlds_are_a_table_with_a_line_each(folder):
    lines = run("measure", folder).out.splitlines()
    assert [line.split()[0] for line in lines[2:]] == [
        str(folder / f"w{seed}.grid") for seed in (1, 2)
    ]


def test_json_gives_every_metric_that_has_a_value(folder):
    found = json.loads(run("measure", folder, "--json").out)["files"]
    assert found[1] == {
        "path": str(folder / "w2.grid"),
        "metrics": measure(generate("trap", 2)).as_dict(),
    }


def test_csv_has_a_column_for_every_metric(folder):
    rows = list(csv.reader(io.StringIO(run("measure", folder, "--csv").out)))
    assert rows[0] == ["path", *METRICS]
    values = {
        name: float(cell) for name, cell in zip(rows[0][1:], rows[1][1:], strict=True) if cell
    }
    assert values == measure(generate("trap", 1)).as_dict()


def test_csv_and_json_at_once_are_refused(folder):
    assert "use one of them" in run("measure", folder, "--csv", "--json").err


def test_what_is_measured_is_the_world_not_what_its_header_says(folder):
    path = folder / "w1.grid"
    text = path.read_text().replace(
        "\n\n[certificate]", "\nmetrics = { detour = 99.0 }\n\n[certificate]"
    )
    path.write_text(text)
    assert read_world(path).provenance.metrics == {"detour": 99.0}
    assert json.loads(run("measure", path, "--json").out)["metrics"]["detour"] < 99.0


def test_what_was_measured_before_a_broken_file_is_told(folder):
    (folder / "w2.grid").write_text("rubbish")
    result = run("measure", folder, "--json")
    assert result.code == 2
    assert json.loads(result.out)["path"] == str(folder / "w1.grid")


@pytest.mark.skipif(os.name == "nt", reason="no file may be called so there")
@pytest.mark.parametrize("command", ["measure", "verify"])
def test_a_files_name_cannot_steer_the_terminal(folder, command):
    (folder / "w1.grid").rename(folder / "\x1b[31mred\n.grid")
    (folder / "w2.grid").write_text("rubbish")
    (folder / "w2.grid").rename(folder / "\x1b[32mgreen.grid")
    result = run(command, folder)
    assert "\\x1b[31mred\\n.grid" in result.out
    assert "\\x1b[32mgreen.grid" in result.err
    assert "\x1b" not in result.out + result.err


def test_a_file_whose_witness_is_wrong_is_refused(folder):
    world = read_world(folder / "w1.grid")
    moved = replace(world, target=replace(world.target, x=world.start.x, y=world.start.y))
    write_world(moved, folder / "moved.grid")
    result = run("measure", folder / "moved.grid")
    assert result.code == 2 and result.error_code == "certificate-invalid"
