"""The commands fuzz, replay, shrink and run: output, exit codes, one-line errors."""

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace

import pytest
from PIL import Image

from fuzz.facts.proofs import certified
from fuzz.triage.judging import failure_of
from sim.scenario import Scenario
from tests.helpers.campaign_folder import CORPUS
from tests.helpers.command_line import worldgen
from tests.helpers.halls import cup
from worldgen import read_world, write_world
from worldgen.interop.exporting import origin_of

FUZZ = (
    "fuzz",
    "--controller",
    "turn-right",
    "--units",
    1,
    "--examples",
    40,
    "--seed",
    5,
    "--workers",
    1,
)

COMPLETE = '''
from sim import Command

class Sits:
    """Starts in the target and has arrived."""
    def reset(self): return ()
    def act(self, observation, memory): return Command(), memory
'''

STRAIGHT = '''
import math
from sim import Command

class Straight:
    """Turns to the target and drives; in an empty room that always arrives."""
    def reset(self): return ()
    def act(self, observation, memory):
        turn = (observation.target_heading - observation.heading + math.pi) % math.tau - math.pi
        return Command(observation.top_speed, turn / observation.time_step), memory
'''


@pytest.fixture(scope="module")
def failures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign") / "failures"
    result = worldgen(*FUZZ, "--verbose", "--out", folder)
    assert result.code == 1
    return folder, result


@pytest.mark.gate
def test_fuzz_writes_a_file_a_failure_and_says_how_to_replay_it(failures):
    folder, result = failures
    files = sorted(folder.glob("*.grid"))
    assert files and all(f"worldgen replay {file}" in result.out for file in files)


@pytest.mark.gate
def test_fuzz_draws_each_failure_and_prints_its_seed(failures):
    assert "S start  G target" in failures[1].out and "seed 5: 1 unit," in failures[1].out


@pytest.fixture(scope="module")
def again(tmp_path_factory):
    """Run the same campaign again, and print JSON."""
    folder = tmp_path_factory.mktemp("again") / "failures"
    return folder, worldgen(*FUZZ, "--out", folder, "--json")


@pytest.mark.nightly
def test_fuzz_prints_one_json_object(again):
    summary = json.loads(again[1].out)
    assert {"seed", "worlds", "steps", "seconds", "failures"} <= set(summary) and again[1].code == 1
    assert set(summary["failures"][0]) == {
        "file",
        "verdict",
        "class",
        "solid_cells",
        "shrinking",
        "replay",
    }


@pytest.mark.gate
def test_equal_seeds_and_units_give_equal_files(failures, again):
    one, other = (
        {file.name: file.read_bytes() for file in folder.glob("*.grid")}
        for folder, _ in (failures, again)
    )
    assert one == other and one


def test_replay_confirms_every_file(failures):
    result = worldgen("replay", failures[0], "--json")
    summary = json.loads(result.out)
    assert result.code == 0 and summary["replayed"] == summary["confirmed"] == len(
        list(failures[0].glob("*.grid"))
    )


def test_replay_refuses_a_missing_controller_once(failures):
    result = worldgen("replay", failures[0], "--controller", "./absent.py:Robot")
    assert result.code == 2 and not result.out
    assert result.err.count("no such file") == 1


def test_replay_notices_a_digest_that_was_changed(failures, tmp_path):
    file = next(iter(failures[0].glob("*.grid")))
    text = file.read_text()
    digest = read_world(file).failure.trace_digest
    (tmp_path / "changed.grid").write_text(text.replace(digest, "0" * 16))
    result = worldgen("replay", tmp_path / "changed.grid")
    assert (
        result.code == 1 and "still fails: " in result.out and "; the trace digest is" in result.out
    )


def test_replay_counts_worlds_without_failure_in_a_folder_and_names_one_that_is_given(
    failures, tmp_path
):
    file = next(iter(failures[0].glob("*.grid")))
    (tmp_path / "z.grid").write_bytes(file.read_bytes())
    write_world(replace(read_world(file), failure=None), tmp_path / "a.grid")
    result = worldgen("replay", tmp_path)
    assert result.code == 0 and "skipped 1 world without a failure" in result.err
    assert "1 of 1 confirmed" in result.out
    named = worldgen("replay", tmp_path / "a.grid", tmp_path / "z.grid")
    assert named.code == 2 and f"{tmp_path}/a.grid: this world has no failure" in named.err


def test_replay_wants_a_witness(failures, tmp_path):
    file = next(iter(failures[0].glob("*.grid")))
    write_world(replace(read_world(file), certificate=None), tmp_path / "bare.grid")
    result = worldgen("replay", tmp_path / "bare.grid")
    assert result.code == 1 and "has no witness" in result.out


def test_replay_names_another_version_of_the_motion_model(failures, tmp_path):
    world = read_world(next(iter(failures[0].glob("*.grid"))))
    older = replace(
        world.failure, trace_digest="0" * 16, details={**world.failure.details, "motion_version": 0}
    )
    write_world(replace(world, failure=older), tmp_path / "older.grid")
    assert "recorded with version 0 of swept" in worldgen("replay", tmp_path / "older.grid").out


def test_replay_notices_a_wall_that_was_added(failures, tmp_path):
    file = max(failures[0].glob("*.grid"), key=lambda f: read_world(f).solid_cells)
    lines = file.read_text().splitlines(keepends=True)
    row = lines.index("%cells\n") + 1
    lines[row] = "#" * (len(lines[row]) - 1) + "\n"
    (tmp_path / "changed.grid").write_text("".join(lines))
    result = worldgen("replay", tmp_path / "changed.grid")
    assert result.code == 1 and "0 of 1 confirmed; 1 " in result.out


def test_a_controller_that_arrives_leaves_nothing_to_report(tmp_path):
    (tmp_path / "mine.py").write_text(COMPLETE)
    world = read_world_with_start_in_target(tmp_path)
    result = worldgen("run", world, "--controller", f"{tmp_path}/mine.py:Sits")
    assert result.code == 0 and result.out.startswith("reached")


def test_fuzz_of_a_controller_that_always_arrives_finds_nothing_and_ends_with_0(tmp_path):
    (tmp_path / "mine.py").write_text(STRAIGHT)
    world = read_world_with_start_in_target(tmp_path)
    controller = f"{tmp_path}/mine.py:Straight"
    result = worldgen(
        "fuzz", "--controller", controller, "--world", world, "--units", 3, "--examples", 40, "--seed", 1,
        "--workers", 1, "--out", tmp_path / "none",
    )  # fmt: skip
    assert (
        result.code == 0
        and "no failure of" in result.out
        and not list((tmp_path / "none").glob("*.grid"))
    )


@pytest.mark.gate
@pytest.mark.parametrize(
    ("body", "kind"), [("raise SystemExit(7)", "SystemExit"), ("1 / 0", "ZeroDivisionError")]
)
def test_fuzz_reports_a_controller_that_crashes_and_replays_it(body, kind, tmp_path):
    (tmp_path / "mine.py").write_text(
        f"class Bad:\n def reset(self): return ()\n def act(self, o, m): {body}\n"
    )
    options = (
        "--controller",
        f"{tmp_path}/mine.py:Bad",
        "--units",
        1,
        "--examples",
        40,
        "--seed",
        1,
        "--workers",
        1,
    )
    result = worldgen("fuzz", *options, "--out", tmp_path / "out")
    (tmp_path / "mine.py").write_text(
        "# edited\n" + (tmp_path / "mine.py").read_text()
    )  # its lines move
    assert result.code == 1 and worldgen("replay", tmp_path / "out").code == 0
    assert [file.name[:-10] for file in (tmp_path / "out").glob("*.grid")] == [
        f"crash-{kind}-mine.act"
    ]


def test_a_picture_of_an_unknown_kind_is_refused(tmp_path):
    world = read_world_with_start_in_target(tmp_path)
    result = worldgen("run", world, "--controller", "turn-left", "--picture", tmp_path / "x.bmp")
    assert result.code == 2 and "use a name that ends in .png, .svg, .html or .gif" in result.err


def test_a_run_is_an_animated_picture(tmp_path):
    world = read_world_with_start_in_target(tmp_path)
    worldgen("run", world, "--controller", "turn-left", "--picture", tmp_path / "run.gif")
    with Image.open(tmp_path / "run.gif") as picture:
        assert picture.n_frames >= 1 and picture.format == "GIF"


@pytest.fixture(scope="module")
def patient(tmp_path_factory):
    """A failure whose budget of 30 steps differs from the world's."""
    world = certified(cup())
    failure = failure_of(world, Scenario("turn-right"), steps=20_000)
    record = {**failure.record.parameters, "steps": 30}
    path = tmp_path_factory.mktemp("patient") / "failure.grid"
    write_world(replace(world, failure=replace(failure.record, parameters=record)), path)
    return path


@pytest.mark.parametrize(
    ("options", "steps"),
    [
        (("--controller", "turn-right"), 30),
        (("--controller", "turn-right", "--seed", 7), 30),
        (("--controller", "turn-right", "--steps", 40), 40),
        (("--controller", "turn-right", "--time-step", 0.01), None),
        (("--controller", "turn-right+beams=4"), None),
        (("--controller", "wall-left"), None),
    ],
)
def test_a_run_of_the_files_failure_has_its_budget(patient, options, steps):
    ended = json.loads(worldgen("run", patient, *options, "--json").out)["steps"]
    assert ended == steps if steps else ended > 100


def test_a_picture_of_a_run_shows_no_other_verdict(patient, tmp_path):
    worldgen("run", patient, "--controller", "bug2", "--picture", tmp_path / "run.svg")
    picture = (tmp_path / "run.svg").read_text()
    assert "bug2, swept: reached" in picture and "turn-right under swept" not in picture


def read_world_with_start_in_target(folder):
    path = folder / "easy.grid"
    path.write_text(
        "%worldgen-grid 1\ncell_size = 0.1\nrobot_radius = 0.07\nstart = [0.25, 0.25, 0.0]\n"
        "target = [0.25, 0.25, 0.05]\n\n%cells\n.....\n.....\n.....\n.....\n.....\n%end\n"
    )
    return path


def test_shrink_works_alone_on_a_failure_file(failures, tmp_path):
    source = next(iter(failures[0].glob("*.grid")))
    result = worldgen("shrink", source, "--out", tmp_path / "small.grid", "--json")
    summary = json.loads(result.out)
    assert result.code == 0 and summary["one_minimal"] and (tmp_path / "small.grid").exists()


def test_an_existing_file_is_not_overwritten(failures, tmp_path):
    source = next(iter(failures[0].glob("*.grid")))
    (tmp_path / "there.grid").write_text("mine")
    result = worldgen("shrink", source, "--out", tmp_path / "there.grid")
    assert result.code == 2 and (tmp_path / "there.grid").read_text() == "mine"


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("fuzz", "--controller", "turn-rihgt"), "did you mean 'turn-right'?"),
        (
            ("fuzz", "--controller", "turn-right", "--motion", "flying"),
            "no motion model is called 'flying'",
        ),
        (("fuzz", "--controller", "turn-right", "--family", "mace"), "did you mean 'maze'?"),
        (
            ("fuzz", "--controller", "turn-right", "--budget", "soon"),
            "is not a duration; write 30s, 5m or 1h",
        ),
        (
            ("fuzz", "--controller", "turn-right", "--units", "1", "--budget", "1s"),
            "use --budget or --units",
        ),
        (("fuzz", "--controller", "./absent.py:Robot"), "no such file"),
        (("fuzz", "--controller", "turn-right", "--world", "absent.grid"), "absent.grid"),
    ],
)
def test_bad_options_of_fuzz_are_one_line_and_code_2(args, message, tmp_path):
    result = worldgen(*args, "--seed", 1, "--out", tmp_path / "out")
    assert result.code == 2 and message in result.err and "Traceback" not in result.err


@pytest.mark.parametrize(
    ("seeds", "said"), [([39, 40], ", 39 of 40 seeds fail\n"), ([], "1-minimal\n")]
)
def test_replay_shows_for_how_many_seeds_a_failure_occurs_where_its_record_says_so(
    tmp_path, seeds, said
):
    loop = read_world(CORPUS / "thesis-1-loop-104.grid")
    details = {**loop.failure.details, "failing_seeds": seeds}
    write_world(replace(loop, failure=replace(loop.failure, details=details)), tmp_path / "a.grid")
    result = worldgen("replay", "--show", tmp_path / "a.grid")
    assert result.code == 0 and said in result.out


@pytest.mark.parametrize("command", ["replay", "shrink", "show", "verify"])
def test_a_missing_file_is_one_line_and_code_2(command, tmp_path):
    result = worldgen(command, tmp_path / "absent.grid")
    assert (
        result.code == 2 and result.error_code == "no-such-file" and "Traceback" not in result.err
    )


def test_a_folder_with_failures_of_no_campaign_is_not_written_into_without_force(
    failures, tmp_path
):
    for file in failures[0].glob("*.grid"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    result = worldgen(*FUZZ, "--out", tmp_path)
    assert result.code == 2 and result.error_code == "folder-holds-worlds"


def test_a_folder_that_cannot_be_written_is_refused_before_the_search(tmp_path):
    (tmp_path / "file").write_text("")
    result = worldgen(*FUZZ, "--out", tmp_path / "file" / "sub")
    assert result.code == 2 and result.error_code == "unwritable"


@pytest.mark.nightly
def test_ctrl_c_keeps_what_was_found(tmp_path):
    folder = tmp_path / "failures"
    command = [
        sys.executable,
        "-c",
        "from worldgen.cli.main import main; main()",
        "fuzz",
        "--controller",
        "turn-left",
    ]
    process = subprocess.Popen(
        [*command, "--budget", "10m", "--seed", "3", "--workers", "1", "--out", str(folder)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 120
    while not list(folder.glob("*.grid")) and time.monotonic() < deadline:
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    try:
        out, err = process.communicate(timeout=180)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130 and "Traceback" not in err and "are kept in" in err
    assert worldgen("replay", folder).code == 0 and "worldgen replay" in out


def test_a_fuzz_campaign_on_a_fixed_map_varies_the_poses_and_keeps_the_origin(tmp_path):
    text = "\n".join(
        [
            "#" * 14,
            *["#" + "." * 12 + "#"] * 5,
            "#" + "." * 6 + "#" * 6 + "#",
            *["#" + "." * 12 + "#"] * 5,
        ]
    )
    path = tmp_path / "map.grid"
    path.write_text(
        "%worldgen-grid 1\ncell_size = 0.1\nrobot_radius = 0.07\nstart = [0.25, 0.25, 0.0]\n"
        'target = [1.15, 1.05, 0.05]\n\n[provenance]\nfamily = "import"\nversion = 1\nseed = 0\n'
        f"params = {{ origin = [-3.0, 4.5] }}\n\n%cells\n{text}\n{'#' * 14}\n%end\n"
    )
    result = worldgen(*FUZZ, "--world", path, "--out", tmp_path / "out")
    found = [read_world(file) for file in (tmp_path / "out").glob("*.grid")]
    starts = {world.start for world in found}
    assert result.code == 1 and starts - {read_world(path).start}
    assert {origin_of(world) for world in found} == {(-3.0, 4.5)}


def test_write_world_round_trips_a_failure(failures, tmp_path):
    file = next(iter(failures[0].glob("*.grid")))
    write_world(read_world(file), tmp_path / "copy.grid")
    assert (tmp_path / "copy.grid").read_bytes() == file.read_bytes()


def test_a_baseline_that_is_not_there_is_refused_before_the_search(tmp_path):
    result = worldgen(
        "fuzz", "--controller", "bug1", "--out", tmp_path / "out", "--baseline", tmp_path / "absent"
    )
    assert (
        result.code == 2 and result.error_code == "no-such-file" and not (tmp_path / "out").exists()
    )
