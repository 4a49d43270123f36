"""The command ``worldgen show``."""

import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from tests.helpers.command_line import worldgen
from worldgen.commands.show import show
from worldgen.errors import FormatError, InvalidParameter, OutputError
from worldgen.files.grid import write_world
from worldgen.world import FailureRecord, Pose, Target, World


@pytest.fixture
def grid(tmp_path):
    path = tmp_path / "w.grid"
    write_world(
        World(np.eye(6, dtype=bool), Pose(0.25, 0.05), Target(0.35, 0.05, 0.05), robot_radius=0.04),
        path,
    )
    return path


def run(*words):
    return CliRunner().invoke(show, [str(word) for word in words])


def test_a_world_is_drawn_on_stdout_as_plain_text_when_it_is_no_terminal(grid):
    result = run(grid)
    assert result.exit_code == 0
    assert result.stdout.splitlines()[:8] == [
        "+------+",
        "|.....#|",
        "|....#.|",
        "|...#..|",
        "|..#...|",
        "|.#....|",
        "|#.SG..|",
        "+------+",
    ]
    assert "\x1b" not in result.stdout
    assert result.stderr == ""


@pytest.mark.parametrize(
    ("kind", "begin"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("html", b"<!DOCTYPE html>")]
)
def test_a_picture_file_is_written_and_named_on_stderr(grid, tmp_path, kind, begin):
    out = tmp_path / f"picture.{kind}"
    result = run(grid, "--picture", out)
    assert result.exit_code == 0
    assert out.read_bytes().startswith(begin)
    assert (result.stdout, result.stderr) == ("", f"wrote {out}\n")


def test_all_kinds_may_be_written_at_once(grid, tmp_path):
    outs = [tmp_path / f"p.{kind}" for kind in ("png", "svg", "html")]
    assert run(grid, *(word for out in outs for word in ("--picture", out))).exit_code == 0
    assert all(out.stat().st_size > 1000 for out in outs)


def test_an_existing_file_is_kept_unless_forced(grid, tmp_path):
    out = tmp_path / "p.svg"
    out.write_text("mine")
    assert isinstance(run(grid, "--picture", out).exception, OutputError)
    assert out.read_text() == "mine"
    assert run(grid, "--picture", out, "--force").exit_code == 0
    assert out.read_text() != "mine"


def test_bad_input_is_an_error_of_ours_with_a_sentence(grid, tmp_path):
    (tmp_path / "bad.grid").write_text("hello")
    assert isinstance(run(tmp_path / "bad.grid").exception, FormatError)
    assert isinstance(
        run(grid, "--picture", tmp_path / "p.png", "--pixels", 3).exception, InvalidParameter
    )


def test_a_failure_file_names_controller_motion_verdict_and_replay(tmp_path):
    failure = FailureRecord(
        "turn-right", "swept", 0, "loop", "0" * 16, evidence={"entry": 12, "period": 104}
    )
    path = tmp_path / "my failure.grid"
    write_world(
        World(np.zeros((6, 6), bool), Pose(0.3, 0.3), Target(0.5, 0.5, 0.05), failure=failure), path
    )
    lines = run(path).stdout.splitlines()
    assert lines[-2] == "failure: turn-right under swept: loop (entry 12, period 104)"
    assert lines[-1] == f"replay:  worldgen replay '{path}'"


def test_the_signal_and_the_witness_can_be_left_out(grid, tmp_path):
    plain, full = tmp_path / "plain.svg", tmp_path / "full.svg"
    run(grid, "--picture", plain, "--no-signal", "--no-witness")
    run(grid, "--picture", full)
    assert "radialGradient" in full.read_text()
    assert "radialGradient" not in plain.read_text()


def test_the_terminal_picture_needs_no_pillow(grid):
    code = (
        "import sys; from worldgen.commands.show import show; "
        f"show([{str(grid)!r}], standalone_mode=False); sys.exit('PIL' in sys.modules)"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], check=False, capture_output=True).returncode
        == 0
    )


@pytest.mark.parametrize("flag", ["--out", "--png", "--svg"])
def test_what_people_write_for_a_picture_is_answered_with_its_option(grid, tmp_path, flag):
    result = worldgen("show", grid, flag, tmp_path / "p.png")
    assert result.code == 2 and "did you mean --picture?" in result.err


def test_a_picture_of_an_unknown_kind_is_refused_before_the_work(tmp_path):
    result = worldgen("show", tmp_path / "missing.grid", "--picture", tmp_path / "p.bmp")
    assert result.code == 2 and "use a name that ends in .png, .svg or .html" in result.err


def test_a_folder_in_which_nobody_may_write_is_refused_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr("os.access", lambda path, mode: False)  # root may write everywhere
    result = worldgen("show", tmp_path / "missing.grid", "--picture", tmp_path / "p.png")
    assert (result.code, result.error_code) == (2, "unwritable")
