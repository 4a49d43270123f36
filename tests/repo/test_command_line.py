"""The command line as a whole: light to start, one line per error, one table of commands."""

import platform
import subprocess
import sys
from importlib.metadata import entry_points

import click
import pytest

from fuzz.cause import Cause
from fuzz.commands.help import TOPICS
from sim.verdict import Verdict
from tests.helpers.command_line import worldgen
from worldgen.cli.every_command import equip
from worldgen.cli.family_command import family_command
from worldgen.cli.help_sections import SECTIONS, sections_of
from worldgen.cli.overview import COMMANDS
from worldgen.robot_overrides import RobotOverrides

HEAVY = ("numpy", "scipy", "numba", "shapely", "trimesh", "hypothesis", "PIL", "sim", "fuzz")


def modules_after(*args):
    """Return the top-level modules that are loaded after a command has run in its own process."""
    code = (
        "import sys\nfrom worldgen.cli.main import main\n"
        f"sys.argv = ['worldgen', *{list(map(str, args))!r}]\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "names = {name.partition('.')[0] for name in sys.modules}\n"
        "print('MODULES', *names, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    found = set(done.stderr.rpartition("MODULES ")[2].split())
    assert "worldgen" in found
    return found


@pytest.mark.gate
@pytest.mark.parametrize("args", [["--help"], ["--version"], ["fuzz", "--help"], ["run", "--help"]])
def test_help_imports_nothing_heavy(args):
    allowed = {"sim", "fuzz"} if len(args) > 1 else set()
    assert not modules_after(*args) & (set(HEAVY) - allowed)


@pytest.mark.gate
def test_a_small_maze_imports_neither_numba_nor_scipy_nor_shapely(tmp_path):
    assert not modules_after("maze", "--size", 60, "--seed", 1, "--out", tmp_path / "w.grid") & {
        "numba", "scipy", "shapely", "trimesh", "hypothesis", "sim", "fuzz",
    }  # fmt: skip


OWN = {point.name: point.load() for point in entry_points(group="worldgen.commands")}
each_command = pytest.mark.parametrize("name", sorted(OWN))


def test_help_lists_every_command_once_under_its_job():
    listed = [name for summaries in COMMANDS.values() for name in summaries]
    assert sorted(listed) == sorted(OWN)


@each_command
def test_help_lists_a_command_with_its_own_summary(name):
    (summary,) = (summaries[name] for summaries in COMMANDS.values() if name in summaries)
    assert OWN[name].help.split("\n\n")[0].replace("\n", " ").strip() == summary


@each_command
def test_every_option_of_a_command_has_help(name):
    options = [p for p in OWN[name].params if isinstance(p, click.Option) and not p.hidden]
    assert [option.name for option in options if not option.help] == []


@each_command
def test_every_command_ends_its_help_with_examples_of_itself(name):
    command = OWN[name]
    commands = command.commands.values() if isinstance(command, click.Group) else [command]
    for one in commands:
        assert f"worldgen {name}" in (one.epilog or ""), one.name


@each_command
def test_each_option_is_in_one_section_of_help(name):
    command = equip(OWN[name], is_ours=True)
    context = click.Context(command)
    listed = [one for _, options in sections_of(command, context) for one in options]
    options = [one for one in command.get_params(context) if isinstance(one, click.Option)]
    assert sorted(map(id, listed)) == sorted(map(id, options))


def test_the_options_that_matter_come_first():
    lines = worldgen("fuzz", "--help").out.split("\nRuns:\n")[0].splitlines()
    flags = [line.split()[0] for line in lines if line.startswith("  --")]
    assert flags[0] == "--controller"
    assert len(flags) <= 10
    assert {"--budget", "--out", "--world", "--seed"} <= set(flags)


def test_every_name_in_a_section_of_help_is_an_option_of_some_command():
    known = {one.name for command in OWN.values() for one in command.params}
    known |= {one.name for one in family_command("maze").params}
    assert {name for names in SECTIONS.values() for name in names} <= known


def test_the_section_of_robot_and_goal_is_the_same_in_every_command():
    assert SECTIONS["Robot and goal"] == tuple(one.name for one in RobotOverrides.declared())


@pytest.mark.parametrize("topic", TOPICS)
def test_a_topic_of_help_fits_a_screen(topic):
    lines = worldgen("help", topic).out.splitlines()
    assert len(lines) <= 60
    assert max(map(len, lines)) <= 80


def test_help_explains_every_verdict_and_every_cause():
    assert set(Verdict) <= set(worldgen("help", "verdicts").out.split())
    assert set(Cause) <= set(worldgen("help", "causes").out.split())


def test_help_shows_the_help_of_a_command_and_suggests_one_for_another_word():
    assert worldgen("help", "replay").out == worldgen("replay", "--help").out
    done = worldgen("help", "reply")
    assert done.code == 2
    assert "did you mean 'replay'?" in done.err


def test_the_command_of_a_family_ends_its_help_with_examples():
    assert worldgen("maze", "--help").out.endswith(
        "  worldgen maze --where 'detour > 2' --out w.grid\n"
    )


def test_version_names_what_a_bug_report_needs():
    lines = worldgen("--version").out.splitlines()
    assert lines[0].startswith("worldgen, version ") and platform.python_version() in lines[1]
    assert all(name in lines[2] for name in ("numpy", "scipy", "shapely", "hypothesis"))


def test_a_misspelt_command_is_suggested():
    result = worldgen("mazw")
    assert result.code == 2 and "did you mean 'maze'?" in result.err


def test_a_fault_of_our_own_is_code_3_without_traceback(monkeypatch, tmp_path):
    def broken(path):
        raise RuntimeError("a bug")

    monkeypatch.setattr("worldgen.files.grid.read_world", broken)
    result = worldgen("show", tmp_path / "w.grid")
    assert result.code == 3 and "a bug in worldgen" in result.err and "Traceback" not in result.err


def test_a_full_disk_is_code_2_and_says_so():
    result = worldgen("maze", "--size", 20, "--seed", 1, "--out", "/dev/full", "--force")
    assert result.code == 2 and "No space left" in result.err


def test_a_folder_without_permission_is_code_2(tmp_path):
    result = worldgen("maze", "--size", 20, "--seed", 1, "--out", tmp_path / "absent" / "w.grid")
    assert result.code == 2 and "does not exist; make it first" in result.err


def test_python_runs_the_program_as_a_module(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "worldgen", "maze", "--size", "1", "--seed", "1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (
        done.returncode == 2
        and done.stderr.count("\n") <= 3
        and "outside 10 to 20000 cells" in done.stderr
    )


@pytest.mark.parametrize(
    "controller",
    ["learned:~nobody-here/x.json", "~nobody-here/x.py:A", "lib:~nobody-here/x.so:act"],
)
def test_a_home_folder_of_nobody_is_code_2(controller, tmp_path):
    world = tmp_path / "w.grid"
    worldgen("trap", "--size", 14, "--seed", 1, "--out", world)
    assert worldgen("run", world, "--controller", controller).code == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["show", "w.grid", "--budget", "3"], "there is no option --budget\n"),
        (["run", "w.grid", "--contoller", "bug2"], "; did you mean --controller?\n"),
        (["fuzz", "--unit", "3"], "; did you mean --units?\n"),
    ],
)
def test_an_unknown_option_gets_a_suggestion_only_if_one_is_spelt_alike(words, message):
    result = worldgen(*words)
    assert result.code == 2 and message in result.err
