"""``[tool.worldgen]`` of a project's ``pyproject.toml`` gives options their defaults."""

import json
import os
from importlib.metadata import entry_points

import click
import pytest

from tests.helpers.command_line import worldgen
from worldgen.cli import configuration, main, output
from worldgen.cli.main import cli
from worldgen.errors import InvalidParameter
from worldgen.plugins import project as project_file

BLIND = """
class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return (1.0, 0.0), memory
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A folder with a controller, and a function that writes its ``pyproject.toml``."""
    (tmp_path / "robot.py").write_text(BLIND)
    monkeypatch.chdir(tmp_path)

    def write(text):
        (tmp_path / "pyproject.toml").write_text(text)
        return tmp_path

    yield write


def made(*options):
    result = worldgen("trap", *options, "--json", "--no-metrics", "--out", "w.grid", "--force")
    assert result.code == 0, result.err
    return json.loads(result.out)


def test_a_configured_value_is_a_default(project):
    project("[tool.worldgen.trap]\nseed = 5\nsize = 40\n")
    world = made()
    assert (world["seed"], world["params"]["size"]) == (5, 40)


def test_the_command_line_wins(project):
    project("[tool.worldgen.trap]\nseed = 5\n")
    assert made("--seed", 6)["seed"] == 6


def test_a_command_reads_its_own_table_only(project):
    project("[tool.worldgen.maze]\nseed = 5\n")
    assert made("--seed", 1)["seed"] == 1


def test_paths_and_controllers_are_relative_to_the_file(project, monkeypatch):
    folder = project(
        '[tool.worldgen.run]\ncontroller = "robot.py:Robot+sensor_noise=0.1"\ntrace = "out/t.csv"\n'
    )
    (folder / "out").mkdir()
    (folder / "below").mkdir()
    made("--seed", 1)
    monkeypatch.chdir(folder / "below")
    assert worldgen("run", "../w.grid", "--steps", 5).code == 1
    assert (folder / "out/t.csv").is_file()


def test_in_the_file_s_own_folder_a_name_stays_as_it_is_written(project):
    project('[tool.worldgen.fuzz]\ncontroller = "./robot.py:Robot"\n')
    result = worldgen("fuzz", "-v", "--units", 1, "--out", "robot.py")
    assert "pyproject.toml: controller = ./robot.py:Robot\n" in result.err


def test_a_single_value_stands_for_a_list_of_one(project):
    project('[tool.worldgen.regenerate]\nfamily = "maze"\n')
    result = worldgen("regenerate", ".")
    assert "family" not in result.err


def test_one_of_two_options_that_exclude_each_other_puts_the_configured_one_aside(project):
    project('[tool.worldgen.fuzz]\nbudget = "60s"\nworkers = 1\n')
    result = worldgen("fuzz", "--controller", "turn-left", "--units", 1, "--out", "robot.py")
    assert "not both" not in result.err


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("[tool.worldgen.trap]\nsied = 1\n", "sied: there is no such option; known: "),
        ("[tool.worldgen.trpa]\nseed = 1\n", "[tool.worldgen.trpa] is not a command; known: "),
        ("[tool.worldgen]\nseed = 1\n", "write it into a command's table"),
        ("[tool.worldgen.trap]\nseed = [1, 2]\n", "this option takes one value"),
        ("[tool.worldgen.trap]\nforce = 1\n", "write true or false"),
        ("[tool.worldgen.trap]\nseed = true\n", "write text or a number"),
        ("[tool.worldgen.trap]\nseed = 1979-05-27\n", "write text, a number, or true or false"),
        ("[tool.worldgen.trap\nseed = 1\n", "is not TOML"),
        ('[tool.worldgen.trap]\nseed = "much"\n', "much"),
    ],
)
def test_what_cannot_be_meant_is_refused(project, text, fault):
    project(text)
    result = worldgen("trap", "--out", "w.grid")
    assert (result.code, fault in result.err) == (2, True), result.err


def test_another_programs_broken_file_is_passed_over(project):
    project("[tool.other\nuses = 'worldgen'\n")
    assert made("--seed", 1)["seed"] == 1


def test_verbose_says_what_came_from_the_file(project):
    project("[tool.worldgen.trap]\nseed = 5\nsize = 40\n")
    result = worldgen("trap", "--out", "w.grid", "--size", 30, "-v")
    assert "pyproject.toml: seed = 5\n" in result.err
    assert "size" not in result.err


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners are checked on POSIX")
def test_a_file_that_a_stranger_put_above_the_folder_is_not_read(project, monkeypatch, tmp_path):
    folder = project("[tool.worldgen.trap]\nseed = 5\n")
    (folder / "mine").mkdir()
    monkeypatch.chdir(folder / "mine")
    monkeypatch.setattr(project_file, "has_trusted_owner", lambda file: False)
    assert made("--seed", 1)["seed"] == 1
    assert worldgen("trap", "--json").out.find('"seed": 5,') < 0


@pytest.fixture
def stranger(monkeypatch):
    """Another user, who owns every file whose name begins with pyproject."""
    strange = os.geteuid() + 1

    def owned(status):
        def seen(path, **options):
            found = status(path, **options)
            return (
                os.stat_result((*found[:4], strange, *found[5:10]))
                if path.name.startswith("pyproject")
                else found
            )

        return seen

    monkeypatch.setattr(project_file.Path, "stat", owned(project_file.Path.stat))
    monkeypatch.setattr(project_file.Path, "lstat", owned(project_file.Path.lstat))


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners are checked on POSIX")
@pytest.mark.parametrize(
    "text", ["[tool.worldgen.trap]\nseed = 5\n", "[tool.worldgen.trap\nseed = 5\n"]
)
def test_a_file_that_a_stranger_put_into_the_folder_itself_is_not_read(project, stranger, text):
    folder = project(text)
    assert made("--seed", 1)["seed"] == 1
    assert project_file.project_of(folder) is None
    assert project_file.has_trusted_owner(folder / "robot.py")


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners are checked on POSIX")
def test_a_link_that_a_stranger_put_into_the_folder_is_not_followed(project, monkeypatch):
    folder = project("[tool.worldgen.trap]\nseed = 5\n")
    mine, strange = os.stat_result, os.geteuid() + 1
    found = (folder / "pyproject.toml").lstat()
    monkeypatch.setattr(
        project_file.Path, "lstat", lambda path: mine((*found[:4], strange, *found[5:10]))
    )
    assert not project_file.has_trusted_owner(folder / "pyproject.toml")


def test_every_controller_of_several_in_one_value_is_relative_to_the_file(project, monkeypatch):
    folder = project(
        '[tool.worldgen.compare]\ncontroller = "./robot.py:Robot,turn-left,./other.py:Robot"\n'
    )
    (folder / "below").mkdir()
    monkeypatch.chdir(folder / "below")
    option = click.Option(["--controller", "controllers"], multiple=True)
    values = configuration.configured([option], ("compare",), (), ("compare",))
    assert values == {"controllers": ["../robot.py:Robot,turn-left,../other.py:Robot"]}


@pytest.mark.parametrize("flags", [("--seed", "1", "--seed", "2"), ("--metrics", "--no-metrics")])
def test_an_option_that_is_given_twice_is_refused(flags):
    result = worldgen("trap", *flags)
    assert (result.code, "is given twice; give it once" in result.err) == (2, True)


def test_run_with_two_controllers_points_to_compare():
    result = worldgen("run", "w.grid", "--controller", "turn-left", "--controller", "turn-right")
    assert (result.code, "worldgen compare runs several" in result.err) == (2, True)


def test_an_option_that_may_be_repeated_may_be():
    assert (
        "given twice"
        not in worldgen("fuzz", "--controller", "turn-left", "--family", "a", "--family", "b").err
    )


def test_a_switch_that_is_given_twice_says_the_same():
    assert worldgen("trap", "--seed", 1, "--json", "--json").code == 0


def test_a_quiet_command_prints_results_only(tmp_path):
    result = worldgen("trap", "--seed", 1, "--out", tmp_path / "w.grid", "--quiet")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_a_quiet_command_still_prints_errors_and_the_drawn_seed(tmp_path, drawn_seeds):
    assert worldgen("trap", "-q", "--out", tmp_path / "w.grid").err.startswith("seed ")
    assert (
        worldgen("trap", "-q", "--seed", 1, "--out", tmp_path / "w.grid").error_code
        == "file-exists"
    )


def test_a_hidden_package_is_an_error_even_if_quiet(monkeypatch, capsys):
    def hidden():
        raise InvalidParameter("hidden-package", "./numpy.py hides the package numpy", "rename it")

    monkeypatch.setattr(main, "check_hidden", hidden)
    monkeypatch.setattr(output, "is_quiet", lambda: True)
    assert main._our_fault(AttributeError("numpy has no array")) == 2
    assert "rename it" in capsys.readouterr().err


def commands(group, *names):
    """Return every command below a group with its full name; only one of the families."""
    context = click.Context(group)
    families = registered("worldgen.families") if group is cli else []
    for name in group.list_commands(context):
        found = group.get_command(context, name)
        if isinstance(found, click.Group):
            yield from commands(found, *names, name)
        elif name not in families[1:]:
            yield pytest.param(found, id="-".join((*names, name)))


def registered(group):
    return sorted(point.name for point in entry_points(group=group))


@pytest.mark.parametrize("command", [*commands(cli)])
def test_every_command_has_quiet_verbose_and_json(command):
    flags = {
        flag for parameter in command.get_params(click.Context(command)) for flag in parameter.opts
    }
    wanted = {"--quiet", "--verbose", "-q", "-v", "--json"}
    assert wanted - flags == ({"--json"} if command.name in ("help", "studio") else set())


def test_show_prints_the_facts_of_a_world_as_json(project):
    project("")
    made("--seed", 1)
    facts = json.loads(worldgen("show", "w.grid", "--json", "--picture", "w.png").out)
    assert (facts["file"], facts["certificate"], facts["pictures"]) == (
        "w.grid",
        "witness",
        ["w.png"],
    )
