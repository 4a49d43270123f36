"""Whose code runs: every command x every kind of code x every place where a file can name it.

Each piece of code leaves a mark when it is imported, started or loaded. The commands are those of
the entry points, so a new command is in the table without any change here.
"""

import contextlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import click
import pytest

from fuzz.campaign.configure import configure
from fuzz.ci.place import place_of
from fuzz.failure import Failure
from fuzz.regression.checks import fixed
from fuzz.studio.campaigns.answers import fuzz_command
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.options import CampaignOptions
from sim.episode import simulate
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.tiers import some
from worldgen.cli.main import cli
from worldgen.errors import InvalidParameter
from worldgen.files.grid import read_world
from worldgen.generation import generate
from worldgen.plugins import trust
from worldgen.sets.manifest import read_manifest

CLASS = """
import os
with open(os.environ["MARK"], "a") as file:
    file.write(f"ran {os.getpid()}\\n")
from sim import Command
class X:
    gain = 1.0
    def reset(self):
        return ()
    def act(self, observation, memory):
        return Command(0.0, 0.0), ()
def judge(trial):
    return {"odd": True}
from worldgen.family import family
@family("odd", version=1)
def odd(rng, *, size: int = 20):
    raise ValueError("it ran")
"""
LIBRARY = """
#include <stdio.h>
#include <stdlib.h>
__attribute__((constructor)) static void mark(void)
{
    FILE *file = fopen(getenv("MARK"), "a");
    if (file) { fputs("ran\\n", file); fclose(file); }
}
"""
PROGRAM = f"cmd:{sys.executable} program.py"
KINDS = {
    "file": "./odd.py:X",
    "field": "./odd.py:X+gain=2",
    "module": "odd_pack.odd:X",
    "program": PROGRAM,
    "library": "lib:./odd.so:act",
}

# Commands that run the controller of a record: all of them refuse.
RUNNERS = {
    "boundary": ("RECORD", "--axis", "speed"),
    "corpus export": ("FOLDER", "--out", "all.zip", "--force"),
    "corpus prune": ("FOLDER",),
    "corpus show": ("FOLDER",),
    "explain": ("RECORD",),
    "replay": ("RECORD",),
    "report": ("RECORD", "--out", "page.html", "--force"),
    "shrink": ("RECORD", "--out", "small.grid", "--force"),
}
# How to call the other commands with a stranger's files; any other gets RECORD for each argument.
CALLS = {
    "audit": ("RECORD", "line.csv"),
    "compare": ("RECORD", "--controller", "turn-right"),
    "corpus diff": ("FOLDER", "FOLDER"),
    "corpus export": ("FOLDER", "--out", "all.csv"),
    "corpus merge": ("FOLDER", "--out", "merged"),
    "export": ("RECORD", "--to", "png", "--out", "w.png"),
    "find": ("--outcome", "turn-right=loop", "--from", "RECORD", "--budget", "1s", "--out", "f.grid"),
    "fuzz": ("--controller", "turn-right", "--world", "RECORD", "--baseline", "FOLDER", "--units", "1",
             "--examples", "1", "--workers", "1", "--out", "new"),
    "import": ("RECORD", "--out", "again.grid"),
    "init": (),
    "demo": (),
    "run": ("RECORD", "--controller", "turn-right"),
    "studio": (),
    "train": ("RECORD", "--controller", "turn-right", "--out", "taught.json"),
}  # fmt: skip
# Servers, and commands that take no file of a stranger and work for seconds.
_ELSEWHERE = {"demo", "init", "studio"}


def leaves(group=cli, path=()):
    context = click.Context(cli)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from leaves(command, (*path, name))
        else:
            yield " ".join((*path, name)), command


COMMANDS = dict(leaves())


def call_of(name):
    """The arguments of a command; a command that the tables don't know gets the record."""
    if name in CALLS:
        return CALLS[name]
    if name in RUNNERS:
        return RUNNERS[name]
    arguments = [one for one in COMMANDS[name].params if isinstance(one, click.Argument)]
    return ("RECORD",) * len(arguments)


@pytest.fixture(scope="module")
def record():
    """The text of a record that names turn-right."""
    found = failure_of(generate("trap", 0, shape="U"), Scenario("turn-right"))
    return found.dumps().decode()


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    (folder / "odd.c").write_text(LIBRARY)
    build = ["cc", "-shared", "-fPIC", "-o", folder / "odd.so", folder / "odd.c"]
    if shutil.which("cc") is None or subprocess.run(build, check=False).returncode:
        pytest.skip("no C compiler")
    return folder / "odd.so"


@pytest.fixture
def stranger(tmp_path, monkeypatch, library):
    """A folder with code of every kind, of which this user has run nothing."""
    folder = tmp_path / "stranger"
    (folder / "odd_pack").mkdir(parents=True)
    (folder / "odd.py").write_text(CLASS)
    (folder / "odd_pack/__init__.py").write_text(CLASS)
    (folder / "odd_pack/odd.py").write_text(CLASS)
    (folder / "program.py").write_text(CLASS.partition("from")[0])
    shutil.copy(library, folder / "odd.so")
    (folder / "line.csv").write_text("t,x,y,heading\n0,0.5,0.5,0\n")
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("MARK", str(tmp_path / "mark"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.delenv("WORLDGEN_PYTEST_ROOT", raising=False)
    monkeypatch.setattr(trust, "_trust", trust._Trust())
    monkeypatch.setattr(trust, "_named_in", {})
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "odd_pack"]:
        del sys.modules[name]


@pytest.fixture
def ran(tmp_path):
    """How often a stranger's code ran."""
    mark = tmp_path / "mark"
    return lambda: mark.read_text().count("ran") if mark.exists() else 0


def naming(record, name, place=Path("failures/w.grid")):
    """Write a record that names this code, in a folder."""
    text = record.replace('controller = "turn-right"', f"controller = {json.dumps(name)}")
    assert text != record
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text)
    return place


def called(name, arguments, file):
    places = {"RECORD": str(file), "FOLDER": str(file.parent)}
    return worldgen(*name.split(), *(places.get(one, one) for one in arguments))


def is_refused(done):
    return (done.code, "not run" in done.err, "--trust" in done.err) == (2, True, True)


# Every command


@pytest.mark.parametrize("kind", some(KINDS))
@pytest.mark.parametrize("command", sorted({*COMMANDS} - _ELSEWHERE))
def test_no_command_runs_the_controller_that_a_record_names(stranger, ran, record, command, kind):
    file = naming(record, KINDS[kind])
    done = called(command, call_of(command), file)
    assert (ran(), done.code != 3) == (0, True), done.err


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", RUNNERS)
def test_a_command_that_needs_a_strangers_code_says_how_to_trust_it(
    stranger, ran, record, command, kind
):
    file = naming(record, KINDS[kind])
    done = called(command, RUNNERS[command], file)
    assert is_refused(done), (done.out, done.err)
    assert f"worldgen {command} --trust" in done.err
    # Nothing is known about a failure that did not run, so none is deleted.
    assert (ran(), file.exists()) == (0, True)


@pytest.mark.gate
@pytest.mark.parametrize("command", RUNNERS)
def test_the_corrected_command_runs_it(stranger, ran, record, command):
    file = naming(record, KINDS["file"])
    done = called(command, RUNNERS[command], file)
    line = next(one for one in done.err.splitlines() if "--trust" in one)
    again = worldgen(*shlex.split(line.partition("type: worldgen ")[2]))
    assert (ran(), again.code in (0, 1, 2)) == (1, True), again.err
    assert "not run" not in again.err


# Every place


@pytest.mark.parametrize("controller", [(), ("--controller", "turn-right")])
@pytest.mark.parametrize("command", ["replay", "shrink", "explain", "report", "corpus show"])
def test_no_command_runs_the_oracle_that_a_record_names(stranger, ran, record, command, controller):
    place = Path("failures/w.grid")
    place.parent.mkdir()
    found = 'evidence = { oracle = "./odd.py:judge", objection = { odd = true },'
    place.write_text(record.replace("evidence = {", found, 1))
    judges = command in ("replay", "shrink", "report")
    done = called(command, (*RUNNERS[command], *controller * (command == "replay")), place)
    # The other commands show what was found without judging it again.
    assert (ran(), is_refused(done)) == (0, judges), (done.out, done.err)


@pytest.mark.parametrize("command", ["replay", "report", "corpus show", "corpus prune", "explain"])
def test_an_archive_is_a_strangers_file_as_well(stranger, ran, record, command):
    file = naming(record, KINDS["file"])
    with zipfile.ZipFile("all.zip", "w") as archive:
        archive.write(file, "w.grid")
    arguments = [str(Path("all.zip")) if one in ("RECORD", "FOLDER") else one
                 for one in RUNNERS[command]]  # fmt: skip
    done = worldgen(*command.split(), *arguments)
    assert (ran(), done.code) == (0, 2), done.err


@pytest.mark.gate
@pytest.mark.parametrize("place", ["controller", "families", "oracles"])
@pytest.mark.parametrize("kind", some(KINDS))
def test_a_campaigns_folder_is_resumed_without_its_code(stranger, ran, place, kind):
    arguments = ("--units", "1", "--examples", "1", "--workers", "1", "--seed", "1", "--no-shrink")
    worldgen("fuzz", "--controller", "turn-right", *arguments, "--out", "campaign")
    file = Path("campaign/.campaign/campaign.json")
    stored = json.loads(file.read_text())
    configuration = stored["configuration"]
    if place == "controller":
        configuration["scenario"]["controller"] = KINDS[kind]
    elif kind in ("file", "module"):
        name = KINDS[kind].rpartition(":")[0]
        configuration[place] = [f"{name}:{'odd' if place == 'families' else 'judge'}"]
    else:
        pytest.skip("only a controller can be a program or a library")
    file.write_text(json.dumps(stored))
    done = worldgen("fuzz", "--resume", "campaign", "--units", "2")
    assert is_refused(done), done.err
    assert ran() == 0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"family": "fire"', '"family": "./odd.py:odd"'),
        ('"over": "maze"', '"over": "./odd.py:odd"'),
    ],
)
def test_a_sets_manifest_runs_no_family(stranger, ran, old, new):
    worldgen("fire", "--count", 2, "--seed", 1, "--size", 40, "--out", "set")
    manifest = Path("set/manifest.jsonl")
    text = manifest.read_text()
    assert old in text
    manifest.write_text(text.replace(old, new))
    done = worldgen("regenerate", "set", "--out", "again")
    assert (ran(), done.code) == (0, 2), done.err


# Every spelling


@pytest.mark.parametrize(
    "name",
    [
        "./odd.py:X",
        "odd.py:X",
        "../stranger/odd.py:X",
        "./odd_pack/../odd.py:X",
        "HERE/odd.py:X",
        "./link.py:X",
        "link/odd.py:X",
        "./odd.py:X+learned=learned.json",
        "./odd.py:X+slip=0.1",
        "behaviours:avoid,./odd.py:X,wander",
        "behaviours+by=priority:./odd.py:X+priority=5",
        "odd_pack:X",
        "odd:X",
        "program_of_none:X",
        f"cmd+deadline=5:{sys.executable} program.py",
        f"{PROGRAM} --flag",
        "lib:HERE/odd.so:act",
        "lib:./link.so:act",
        "learned:learned.json",
        "odd-name:X",
        "sim.controllers./tmp:X",
        "sim.controllers.examples.python.missing:X",
        "__main__:X",
        "q-learner+learned=learned,odd.json",
        "turn-right+learned=/etc/hostname",
        "./odd.py:X+gain=2+learned=learned.json",
        "odd_pack.odd:X+gain=2",
        "./link.py:X+gain=2:X",
        "q-learner+learned=learned.json",
    ],
)
def test_no_spelling_leads_past_the_rule(stranger, ran, record, name):
    Path("link.py").symlink_to("odd.py")
    Path("link.so").symlink_to("odd.so")
    Path("link").symlink_to(".")
    Path("learned.json").write_text("{}")
    Path("learned,odd.json").write_text("{}")
    shutil.copy("odd.py", "odd-name.py")
    file = naming(record, name.replace("HERE", str(stranger)))
    done = worldgen("replay", file)
    assert (ran(), done.code) == (0, 2), done.err


def test_a_file_whose_name_looks_like_options_is_another_file(stranger, ran, record):
    shutil.copy("odd.py", "mine.py")
    shutil.copy("odd.py", "mine.py:judge+o=odd.py")
    Path("failures").mkdir()
    found = 'evidence = { oracle = "./mine.py:judge+o=odd.py:judge-1", objection = { odd = true },'
    Path("failures/w.grid").write_text(record.replace("evidence = {", found, 1))
    assert worldgen("run", "failures/w.grid", "--controller", "./mine.py:X").code == 1
    count = ran()
    assert worldgen("replay", "failures/w.grid").code == 2
    assert ran() == count


def test_a_dotted_name_does_not_run_the_package_above_it(stranger, ran, record):
    worldgen("replay", naming(record, "odd_pack.missing:X"))
    worldgen("report", "failures", "--out", "page.html")
    assert ran() == 0


def test_finding_the_source_of_a_controller_runs_no_package_above_it(stranger, ran):
    assert place_of("odd_pack.odd:X", stranger).uri == "odd_pack/odd.py"
    assert ran() == 0


def test_a_program_in_another_folder_is_another_program(
    stranger, ran, record, tmp_path, monkeypatch
):
    file = naming(record, PROGRAM).resolve()
    assert worldgen("run", file, "--controller", PROGRAM).code != 2
    count = ran()
    assert count > 0
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy("program.py", other)
    monkeypatch.chdir(other)
    assert is_refused(worldgen("replay", file))
    assert ran() == count


# The reasons


def test_what_was_run_from_the_command_line_runs_again_even_after_an_edit(stranger, ran, record):
    file = naming(record, "./odd.py:X")
    assert is_refused(worldgen("replay", file))
    assert worldgen("run", file, "--controller", "./odd.py:X").code == 1
    Path("odd.py").write_text(CLASS.replace("0.0, 0.0", "0.0, 0.5"))
    done = worldgen("replay", file)
    assert "not run" not in done.err and ran() >= 1


@pytest.mark.gate
def test_fuzz_then_replay_asks_nothing_and_no_process_loads_a_file_twice(stranger, ran, tmp_path):
    arguments = ("--units", 2, "--examples", 2, "--seed", 1, "--workers", 2)
    worldgen("fuzz", "--controller", "./odd.py:X", *arguments, "--out", "found")
    done = worldgen("replay", "found")
    assert (done.code, "confirmed" in done.out + done.err) == (0, True), done.err
    processes = (tmp_path / "mark").read_text().splitlines()
    assert len(processes) == len(set(processes)) > 1


def test_a_name_on_this_command_line_is_a_reason(stranger, ran, record):
    file = naming(record, "./odd.py:X")
    done = worldgen("replay", file, "--controller", "odd.py:X")
    assert (ran(), "not run" in done.err) == (1, False)


@pytest.mark.gate
@pytest.mark.parametrize("table", ["fuzz", "run", "explain"])
def test_the_projects_settings_are_a_reason_for_every_command(stranger, ran, record, table):
    file = naming(record, "./odd.py:X")
    Path("pyproject.toml").write_text(f'[tool.worldgen.{table}]\ncontroller = "odd.py:X"\n')
    assert worldgen("report", file, "--out", "page.html").code == 0
    assert ran() == 1
    assert not trust.list_file().exists()


def test_settings_of_another_user_are_none(stranger, ran, record, monkeypatch):
    file = naming(record, "./odd.py:X")
    Path("pyproject.toml").write_text('[tool.worldgen.fuzz]\ncontroller = "./odd.py:X"\n')
    monkeypatch.setattr("worldgen.plugins.project.has_trusted_owner", lambda file: False)
    assert is_refused(worldgen("replay", file))
    assert ran() == 0


def test_a_file_that_another_user_has_replaced_is_not_the_one_that_was_run(
    stranger, ran, record, monkeypatch
):
    file = naming(record, "./odd.py:X")
    worldgen("run", file, "--controller", "./odd.py:X")
    count = ran()
    monkeypatch.setattr(trust, "has_trusted_owner", lambda path: path.suffix != ".py")
    assert is_refused(worldgen("explain", file))
    assert ran() == count


def test_what_was_read_as_data_is_not_loaded_as_code(stranger, ran, record):
    shutil.copy("odd.so", "taught.json")
    file = naming(record, "lib:./taught.json:act")
    worldgen("run", file, "--controller", "q-learner+learned=./taught.json")
    assert is_refused(worldgen("replay", file))
    assert ran() == 0


def test_the_question_about_data_says_that_it_is_read(stranger, record, monkeypatch):
    asked = []
    monkeypatch.setattr("worldgen.cli.main.is_at_terminal", lambda: True)
    monkeypatch.setattr("worldgen.cli.main.ask_user", asked.append)
    Path("taught.json").write_text("{}")
    worldgen("replay", naming(record, "q-learner+learned=./taught.json"))
    assert asked[0].endswith(f"Read {stranger / 'taught.json'}?")


def test_a_name_that_is_too_long_to_show_says_that_it_is_cut(stranger, record):
    long = f"{PROGRAM} {'x' * 300} last-word"
    assert "last-word" in worldgen("replay", naming(record, long)).err
    longer = f"{PROGRAM} {'x' * 3000} last-word"
    assert (
        f"... ({len(longer) - 400} more characters)"
        in worldgen("replay", naming(record, longer)).err
    )


def test_a_refusal_names_the_file_that_was_read_last_not_an_earlier_one(stranger, record):
    first = naming(record, "./odd.py:X", place=Path("a.grid"))
    second = naming(record, "./odd.py:X", place=Path("b.grid"))
    Failure.read(first)
    with pytest.raises(trust.CodeNotTrusted, match=r"b\.grid names"):
        Failure.read(second).run()


def test_without_a_place_to_remember_the_command_still_names_trust(
    stranger, ran, record, monkeypatch
):
    Path("file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(stranger / "file"))
    file = naming(record, "./odd.py:X")
    assert worldgen("run", file, "--controller", "./odd.py:X").code == 1
    assert is_refused(worldgen("replay", file))
    assert worldgen("replay", "--trust", file).code == 2 or ran() == 1


def test_trust_lasts_for_one_command(stranger, ran, record):
    file = naming(record, "./odd.py:X")
    assert "not run" not in worldgen("replay", "--trust", file).err
    assert is_refused(worldgen("replay", file))


def test_settings_cannot_say_that_everything_is_trusted(stranger, record):
    file = naming(record, "./odd.py:X")
    Path("pyproject.toml").write_text("[tool.worldgen.replay]\ntrust = true\n")
    done = worldgen("replay", file)
    assert (done.code, "there is no such option" in done.err) == (2, True)


@pytest.mark.parametrize(("answer", "times"), [(True, 1), (False, 0)])
def test_at_a_terminal_one_question_names_code_and_file(
    stranger, ran, record, monkeypatch, answer, times
):
    naming(record, "./odd.py:X")
    naming(record, "./odd.py:X", place=Path("failures/v.grid"))
    asked = []
    monkeypatch.setattr("worldgen.cli.main.is_at_terminal", lambda: True)
    monkeypatch.setattr(
        "worldgen.cli.main.ask_user", lambda question: asked.append(question) or answer
    )
    done = worldgen("replay", "failures")
    assert (len(asked), ran()) == (1, times)
    assert str(stranger / "odd.py") in asked[0] and "failures/" in asked[0]
    assert ("not run" in done.err) is not answer
    # A yes is remembered, a no is not.
    assert trust.list_file().exists() is answer


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX terminals")
def test_a_real_terminal_is_asked(stranger, ran, record):
    import pty

    file = naming(record, "./odd.py:X\x1b[2J")
    naming(record, "./odd.py:X", place=file)
    driver, terminal = pty.openpty()
    command = [sys.executable, "-m", "worldgen", "replay", str(file)]
    child = subprocess.Popen(command, stdin=terminal, stdout=terminal, stderr=terminal)
    os.close(terminal)
    seen = b""
    while b"[y/N]" not in seen:
        seen += os.read(driver, 1024)
    os.write(driver, b"n\n")
    with contextlib.suppress(OSError):  # Linux's way of saying that the terminal is closed
        while more := os.read(driver, 1024):
            seen += more
    assert child.wait(60) == 2
    os.close(driver)
    assert seen.count(b"is not run") == 1
    assert ran() == 0


# Python programs


def test_a_python_caller_names_code_by_passing_it(stranger, ran, record):
    world = read_world(naming(record, "./odd.py:X"))
    assert simulate(world, "./odd.py:X").steps > 0
    assert ran() == 1


@pytest.mark.parametrize("kind", KINDS)
def test_a_python_caller_who_passes_a_record_names_nothing(stranger, ran, record, kind):
    failure = Failure.read(naming(record, KINDS[kind]))
    for run in (failure.run, lambda: fixed(failure.stored)):
        with pytest.raises(trust.CodeNotTrusted, match=r"w\.grid"):
            run()
    assert ran() == 0


# Longer than any text that is searched for names.
FAR = "./" * 2100


@pytest.mark.parametrize(
    "name",
    [
        f"{FAR}odd.py:X",
        f"{PROGRAM}{' ' * 4100}",
        f"behaviours:{'drive,' * 800}./odd.py:X",
        f"lib:{FAR}odd.so:act",
    ],
)
def test_a_long_name_in_a_record_does_not_look_like_a_python_callers(stranger, ran, record, name):
    failure = Failure.read(naming(record, name))
    with pytest.raises(InvalidParameter):
        failure.run()
    assert ran() == 0


@pytest.mark.parametrize(
    "name", ["./odd.py:X", "behaviours:./odd.py:X", "behaviours:avoid,./odd.py:X", PROGRAM]
)
def test_a_record_runs_nothing_in_the_folder_that_its_reader_has_moved_to(
    stranger, ran, record, tmp_path, monkeypatch, name
):
    failure = Failure.read(naming(record, name))
    shutil.copytree(stranger, tmp_path / "other")
    monkeypatch.chdir(tmp_path / "other")
    with pytest.raises(trust.CodeNotTrusted):
        failure.run()
    assert ran() == 0


def test_an_oracle_in_a_record_runs_in_no_other_folder(
    stranger, ran, record, tmp_path, monkeypatch
):
    found = 'evidence = { oracle = "\\n./odd.py:judge\\n", objection = { odd = true },'
    Path("w.grid").write_text(record.replace("evidence = {", found, 1))
    failure = Failure.read(Path("w.grid"))
    shutil.copytree(stranger, tmp_path / "other")
    monkeypatch.chdir(tmp_path / "other")
    assert "not run" in replay(failure).reason
    assert ran() == 0


def test_a_family_in_a_manifest_is_not_a_python_callers(stranger, ran):
    worldgen("fire", "--count", 2, "--seed", 1, "--size", 40, "--out", "set")
    manifest = Path("set/manifest.jsonl")
    manifest.write_text(
        manifest.read_text().replace('"family": "fire"', '"family": "./odd.py:odd"')
    )
    with pytest.raises(trust.CodeNotTrusted):
        generate(read_manifest(manifest).entries[0].family)
    assert ran() == 0


@pytest.mark.parametrize(
    "use",
    [
        lambda failure: simulate(failure.world, "./odd.py:X"),
        lambda failure: failure.driven_by("./odd.py:X").run(),
        lambda failure: replay(failure, "./odd.py:X"),
        lambda failure: simulate(failure.world, Scenario("./odd.py:X").controller),
        lambda failure: simulate(failure.world, Scenario.parse("./odd.py:X+slip=0.1").controller),
        lambda failure: configure(CampaignOptions(controller="./odd.py:X"), 1),
        lambda failure: fixed(failure.stored, "./odd.py:X"),
    ],
)
def test_an_argument_may_run_after_a_record_was_read(stranger, ran, record, use):
    use(Failure.read(naming(record, "lib:./odd.so:act")))
    assert ran() == 1


def test_a_family_is_an_argument_after_a_record_was_read(stranger, ran, record):
    Failure.read(naming(record, "./odd_pack/odd.py:X"))
    with pytest.raises(Exception, match="it ran"):
        generate("./odd.py:odd")


def test_workers_know_what_their_parent_may_run(stranger, ran, record):
    from worldgen.plugins.workers import WorkerPool

    with trust.command_rule(None):
        trust.admit("./odd.py:X")
        pool = WorkerPool(1)
        assert pool.submit(trust.may_run, "./odd.py:X").result()
        assert not pool.submit(trust.may_run, "./odd_pack/odd.py:X").result()
        pool.end()


@pytest.mark.gate
def test_workers_import_nothing_from_the_current_folder(stranger, ran):
    """A new Python looks for its own modules in the current folder first, unless it is told not to."""
    for name in ("multiprocessing", "pickle", "selectors", "worldgen"):
        Path(f"{name}.py").write_text(CLASS.partition("from")[0])
    script = shutil.which("worldgen", path=Path(sys.executable).parent)
    arguments = "--controller turn-right --units 2 --examples 1 --seed 1 --workers 2 --no-shrink"
    command = [script, "fuzz", *arguments.split(), "--out", "found"]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 1
    assert ran() == 0


@pytest.mark.gate
@pytest.mark.parametrize(("stored", "code"), [("./odd.py:X", 1), ("odd_pack.odd:X", 2)])
def test_the_studio_resumes_a_campaign_with_no_code_but_the_controller_it_checked(
    stranger, ran, stored, code
):
    arguments = ("--units", "1", "--examples", "1", "--workers", "1", "--seed", "1", "--no-shrink")
    worldgen("fuzz", "--controller", "turn-right", *arguments, "--out", "campaign")
    file = Path("campaign/.campaign/campaign.json")
    content = json.loads(file.read_text())
    content["configuration"]["scenario"]["controller"] = stored
    file.write_text(json.dumps(content))
    command = fuzz_command(["--resume=campaign", "--units=2"], ["./odd.py:X"])
    done = subprocess.run(command, capture_output=True, check=False)
    assert ("not run" in done.stderr.decode(), ran() > 0) == (code == 2, code == 1), done.stderr


def test_a_campaign_of_the_studio_imports_nothing_from_the_current_folder(stranger, monkeypatch):
    from fuzz.studio.campaigns.answers import _flags

    monkeypatch.setattr(sys, "path", [one for one in sys.path if one not in ("", str(stranger))])
    assert _flags() == ("-P",)
