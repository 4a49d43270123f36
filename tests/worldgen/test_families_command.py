"""``worldgen FAMILY``: options from the family, worlds to files or stdout, no world is lost."""

import json
import subprocess
import sys

import pytest

import worldgen.sets.making
from tests.helpers.command_line import worldgen as run
from worldgen.cli.family_command import family_command
from worldgen.difficulty import with_metrics
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, read_world, world_digest
from worldgen.generation import generate

every_family = pytest.mark.parametrize("name", FAMILIES.names())


@every_family
def test_every_parameter_is_an_option_with_its_help_and_bounds(name):
    options = {option.name: option for option in family_command(name).params}
    for known in FAMILIES.get(name).parameters:
        option = options[known.name]
        assert option.help == known.note and (
            known.bounds is None or known.bounds.rule in option.help
        )
        assert option.default == known.python_default


@every_family
def test_every_number_has_bounds_which_its_default_keeps_and_generate_too(name):
    for known in FAMILIES.get(name).parameters:
        if type(known.default) in (int, float):
            low = known.bounds.low - 1
            while low == known.bounds.chosen:
                low -= 1
            with pytest.raises(
                InvalidParameter, match=f"{known.name}=.* (outside|below|not above|above 0)"
            ):
                generate(name, 1, **{known.name: low})


@pytest.mark.gate
@every_family
def test_options_left_out_are_the_defaults_of_the_library(name, tmp_path):
    result = run(name, "--seed", 4, "--out", tmp_path / "w.grid")
    assert result.code == 0, result.err
    assert read_world(tmp_path / "w.grid") == with_metrics(generate(name, 4))


def test_options_reach_the_family(tmp_path):
    options = [
        "--size",
        61,
        "--algorithm",
        "backtracker",
        "--braid",
        0.5,
        "--passage",
        4,
        "--wall",
        2,
    ]
    run("maze", *options, "--robot-radius", 0.15, "--seed", 1, "--out", tmp_path / "w.grid")
    expected = generate(
        "maze", 1, size=61, algorithm="backtracker", braid=0.5, passage=4, wall=2, robot_radius=0.15
    )
    assert read_world(tmp_path / "w.grid") == with_metrics(expected)


def test_a_flag_reaches_the_family(tmp_path):
    run("trap", "--inside", "--turn", -1, "--seed", 1, "--out", tmp_path / "w.grid")
    assert read_world(tmp_path / "w.grid") == with_metrics(generate("trap", 1, inside=True))


def test_no_metrics_leaves_them_out():
    result = run("corridor", "--seed", 3, "--no-metrics")
    assert result.out.encode() == dumps(generate("corridor", 3))


def test_without_out_the_world_goes_to_stdout():
    result = run("corridor", "--seed", 3)
    assert result.out.encode() == dumps(with_metrics(generate("corridor", 3)))


def test_one_line_tells_what_was_made(tmp_path):
    path = tmp_path / "w.grid"
    result = run("corridor", "--size", 12, "--seed", 3, "--out", path)
    made = generate("corridor", 3, size=12).certificate
    assert result.out == ""
    assert result.err == (
        f"{path}: corridor 12 x 12 cells, witness {made.length:.4g} m in {made.duration:.4g} s, "
        f"seed 3\n"
    )


def test_a_drawn_seed_is_printed_and_makes_the_same_world(tmp_path, drawn_seeds):
    first = run("maze", "--out", tmp_path / "a.grid")
    seed = first.err.split()[1]
    run("maze", "--seed", seed, "--out", tmp_path / "b.grid")
    assert (
        first.err.startswith("seed ")
        and (tmp_path / "a.grid").read_bytes() == (tmp_path / "b.grid").read_bytes()
    )


def test_two_drawn_seeds_differ(drawn_seeds):
    assert run("maze").err.split()[1] != run("maze").err.split()[1]


def test_json_is_one_object_about_the_file(tmp_path):
    path = tmp_path / "w.grid"
    result = json.loads(run("trap", "--seed", 5, "--size", 20, "--out", path, "--json").out)
    world = generate("trap", 5, size=20)
    assert result == {
        "family": "trap",
        "version": world.provenance.version,
        "seed": 5,
        "params": dict(world.provenance.params),
        "file": str(path),
        "digest": world_digest(world),
        "result": "reachable",
        "witness_length": world.certificate.length,
        "witness_time": world.certificate.duration,
    }


def test_json_without_out_says_what_would_be_made():
    result = json.loads(run("trap", "--seed", 5, "--json").out)
    assert result["file"] is None and result["digest"] == world_digest(generate("trap", 5))


def test_count_writes_a_folder_of_rising_seeds(tmp_path):
    result = run(
        "maze", "--count", 3, "--seed", 8, "--size", 12, "--out", tmp_path / "a" / "b", "--json"
    )
    listed = json.loads(result.out)["files"]
    assert [entry["seed"] for entry in listed] == [8, 9, 10]
    for entry in listed:
        assert entry["file"] == str(tmp_path / "a" / "b" / f"maze-{entry['seed']}.grid")
        assert read_world(entry["file"]) == with_metrics(generate("maze", entry["seed"], size=12))


def test_seeds_of_a_count_wrap_at_64_bits(tmp_path):
    run("maze", "--count", 2, "--seed", 2**64 - 1, "--size", 12, "--out", tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "manifest.jsonl", "maze-0.grid", f"maze-{2**64 - 1}.grid",
    ]  # fmt: skip


def test_a_file_that_is_there_stays(tmp_path):
    path = tmp_path / "w.grid"
    path.write_text("mine")
    result = run("maze", "--seed", 1, "--out", path)
    assert result.code == 2 and result.error_code == "file-exists" and path.read_text() == "mine"


def test_force_overwrites_it(tmp_path):
    path = tmp_path / "w.grid"
    path.write_text("mine")
    assert run("maze", "--seed", 1, "--out", path, "--force").code == 0
    assert read_world(path) == with_metrics(generate("maze", 1))


def test_one_file_in_the_way_stops_a_count_before_it_begins(tmp_path):
    (tmp_path / "maze-9.grid").write_text("mine")
    result = run("maze", "--count", 3, "--seed", 8, "--out", tmp_path)
    assert result.code == 2 and result.error_code == "folder-not-empty"
    assert [path.name for path in tmp_path.iterdir()] == ["maze-9.grid"]


def _stop_at(monkeypatch, seed, error):
    real = worldgen.sets.making.generate

    def stopping(name, number, **params):
        if number == seed:
            raise error
        return real(name, number, **params)

    monkeypatch.setattr(worldgen.sets.making, "generate", stopping)


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (KeyboardInterrupt(), 130),
        (GenerationFailed("no-layout-found", "maze: none of 64 layouts"), 2),
    ],
    ids=["ctrl-c", "failed"],
)
def test_what_is_made_before_an_interruption_is_kept(tmp_path, monkeypatch, error, code):
    _stop_at(monkeypatch, 10, error)
    result = run("maze", "--count", 5, "--seed", 8, "--size", 12, "--out", tmp_path)
    assert result.code == code and f"{tmp_path}: 2 of 5 worlds are written" in result.err
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "manifest.jsonl",
        "maze-8.grid",
        "maze-9.grid",
    ]


@pytest.mark.gate
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--size", 5], "worldgen: size=5 cells is outside 10 to 20000 cells"),
        (["--size", "big"], "--size: 'big' is not a whole number"),
        (["--algorithm", "prism"], "'prism' is not one of 'wilson', 'aldous-broder'"),
        (["--braid", "nan"], "worldgen: maze: braid=nan is not finite"),
        (["--sise", 5], "there is no option --sise; did you mean --size?"),
        (["--seed", -1], "--seed: -1 is not a whole number from 0"),
        (["--count", 0], "--count: 0 is not a whole number of at least 1"),
        (["--turning-radius", 0], "--turning-radius: 0 is not a number above 0"),
        (["--count", 2], "--out is missing; --count 2 writes 2 files"),
        (["--out", "/no/such/folder/w.grid"], "the folder /no/such/folder does not exist"),
        (["--count", 2, "--out", __file__], "is a file; choose a folder for more than one world"),
        (
            ["--count", 2, "--out", "w.grid"],
            "w.grid names the file of one world; for 2 worlds, choose a folder or an archive",
        ),
        (["--out", "w.zip"], "w.zip names an archive; set the number of worlds with --count"),
    ],
    ids=lambda value: " ".join(map(str, value))[:30] if isinstance(value, list) else "",
)
def test_bad_options_are_one_clear_line_and_exit_2(options, message):
    seed = () if "--seed" in options else ("--seed", 1)
    result = run("maze", *options, *seed)
    assert result.code == 2 and message in result.err and result.out == ""
    assert "Traceback" not in result.err


def test_bad_parameters_leave_no_folder_behind(tmp_path):
    assert run("maze", "--count", 2, "--size", 5, "--out", tmp_path / "new").code == 2
    assert not (tmp_path / "new").exists()


def test_a_full_disk_is_told():
    result = run("maze", "--seed", 1, "--out", "/dev/full", "--force")
    assert result.code == 2 and result.error_code == "unwritable"


@pytest.mark.gate
def test_the_command_loads_nothing_heavy():
    code = (
        "import sys; from tests.helpers.command_line import worldgen; "
        "print(worldgen('maze', '--size', 60, '--seed', 1).code, "
        "[name for name in ('numba', 'scipy', 'shapely', 'PIL', 'hypothesis', 'rich') if name in "
        "sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "0 []\n"


def test_the_list_of_families_has_each_with_its_parameters():
    listed = json.loads(run("families", "--json").out)["families"]
    assert [one["name"] for one in listed] == FAMILIES.names()
    assert all(one["about"] and one["parameters"] for one in listed)
    lines = run("families").out.splitlines()
    assert [line.split()[0] for line in lines] == ["family", *FAMILIES.names()]
