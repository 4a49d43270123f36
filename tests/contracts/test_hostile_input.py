"""Every command x every path it takes x every hostile file, folder and place.

The commands and their paths are those of the command line, so a new one is in the table without any
change here. No input gives a traceback or a wait without end, and no file of the user's is lost.
"""

import contextlib
import os
import shutil
import signal
from pathlib import Path

import click
import pytest

from tests.helpers.command_line import worldgen
from worldgen.cli.main import cli

pytestmark = pytest.mark.gate

CORPUS = Path(__file__).parents[2] / "corpora"
LOOP = CORPUS / "failures/turn-right/swept/returns-to-a-wall-2.grid"
SECONDS = 60  # in which a refusal must come, on a busy machine

# What a command needs besides its paths.
ALSO = {
    "boundary": ["--axis", "speed"],
    "compare": ["--controller", "turn-right", "--steps", "20"],
    "demo": ["--controller", "turn-right"],
    "find": ["--controller", "turn-right", "--controller", "bug2", "--where", "turn-right=fails"],
    "fuzz": ["--controller", "turn-right", "--units", "1", "--examples", "1", "--seed", "1"],
    "init": ["--controller", "turn-right", "--units", "1"],
    "run": ["--controller", "turn-right", "--steps", "20"],
    "train": ["--episodes", "1", "--steps", "5"],
}
ENDINGS = {"picture": ".png", "outs": ".png", "table": ".csv", "trace": ".csv", "curve": ".png"}
NOT_READ = {"out", "picture", "chart", "transcript", "junit", "sarif", "summary", "scen", "report"}
NOT_READ |= ENDINGS.keys()


def leaves(command, words=()):
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            yield from leaves(command.get_command(context, name), (*words, name))
    elif not command.hidden:
        yield " ".join(words), command


COMMANDS = dict(leaves(cli))


def paths_of(name):
    return [one for one in COMMANDS[name].params if isinstance(one.type, click.Path)]


READ = [(name, one.name) for name in COMMANDS for one in paths_of(name) if one.name not in NOT_READ]
WRITTEN = [(name, one.name) for name in COMMANDS for one in paths_of(name) if one.name in NOT_READ]


def hostile(folder):
    """Write what no command can read, and return the places by kind."""
    good = LOOP.read_bytes()
    contents = {
        "empty": b"",
        "noise": bytes(range(256)) * 16,
        "cut": good[:200],
        "nul": good.replace(b"%cells", b"\0%cells", 1),
        "huge number": good.replace(b"cell_size = ", b"cell_size = 1" + b"0" * 5_000, 1),
        "no text": good.replace(b"cell_size", b"\xff\xfe", 1),
        "one long line": b"%worldgen-grid 1\n" + b"x" * 3_000_000,
    }
    places = {kind: folder / f"{kind.replace(' ', '-')}.grid" for kind in contents}
    for kind, place in places.items():
        place.write_bytes(contents[kind])
    (folder / "folder.grid").mkdir()
    (folder / "loop.grid").symlink_to(folder / "loop.grid")
    (folder / "dangling.grid").symlink_to(folder / "nowhere.grid")
    return places | {
        "missing": folder / "missing.grid",
        "folder": folder / "folder.grid",
        "link to itself": folder / "loop.grid",
        "dangling link": folder / "dangling.grid",
        "below a file": folder / "empty.grid" / "w.grid",
        "long name": folder / ("x" * 300 + ".grid"),
        "device": Path(os.devnull),
    }


KINDS = (
    "empty", "noise", "cut", "nul", "huge number", "no text", "one long line", "missing",
    "folder", "link to itself", "dangling link", "below a file", "long name", "device",
)  # fmt: skip


def line(name, folder, given, place):
    """Return the words of a command whose paths are usual ones, but for one of them."""
    words = [*name.split(), *ALSO.get(name, [])]
    for one in COMMANDS[name].params:
        is_path = isinstance(one.type, click.Path)
        if one.name == given:
            value = place
        elif not (is_path and one.required):
            continue
        elif one.name in NOT_READ:
            value = (
                folder / f"new{ENDINGS.get(one.name, '.zip' if name == 'corpus export' else '')}"
            )
        else:
            value = folder / "good.grid"
        option = [max(one.opts, key=len)] if isinstance(one, click.Option) else []
        words += [*option, value]
    return words


class Late(BaseException):
    """The time of a command is over; nothing else catches it."""


@contextlib.contextmanager
def in_time():
    """Raise an error if the block waits for something that never comes."""

    def stop(*_):
        raise Late

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def contents(folder):
    return {
        file.relative_to(folder): file.read_bytes() for file in folder.rglob("*") if file.is_file()
    }


def refusal(words, folder):
    """Run a command and return its result, after the checks that hold for every command."""
    before = contents(folder)
    with in_time():
        result = worldgen(*words)
    after = contents(folder)
    for file, data in before.items():
        # A workflow's summary gets another section, as its runner expects.
        assert after[file].startswith(data) if "--summary" in words else after[file] == data
    assert "Traceback" not in result.err
    assert "bug in worldgen" not in result.err
    assert result.code in (0, 1, 2, 4)
    if result.code == 2:
        assert result.err.strip()
    return result


@pytest.fixture
def folder(tmp_path, monkeypatch):
    folder = tmp_path / "work"
    folder.mkdir()
    shutil.copy(LOOP, folder / "good.grid")
    monkeypatch.chdir(folder)
    return folder


# Places for new files: a folder may be missing or empty.
NEW = {("init", "folder"), ("studio", "path")}
UNREADABLE = [
    (*one, kind)
    for one in READ
    for kind in KINDS
    if one not in NEW or kind not in ("folder", "missing")
]


@pytest.mark.parametrize(("name", "given", "kind"), UNREADABLE)
def test_what_cannot_be_read_is_refused(name, given, kind, folder):
    place = hostile(folder)[kind]
    result = refusal(line(name, folder, given, place), folder)
    if not (kind == "folder" and name.startswith("corpus")):
        assert result.code == 2, result.out


# Every command that writes, and every option that names a file to write.
OURS = b"my own notes\n"


def occupied(folder):
    """Write what is in the way of new files, and return the places by kind."""
    mine = folder / "mine"
    mine.write_bytes(OURS)
    (folder / "full").mkdir()
    (folder / "full" / "notes.grid").write_bytes(OURS)
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "link").symlink_to(mine)
    return {
        "below a file": mine / "new",
        "no such folder": folder / "no" / "such" / "new",
        "long name": folder / ("x" * 300),
        "link to itself": folder / "loop",
        "link to a file": folder / "link",
        "a file": mine,
        "a full folder": folder / "full",
        "no permission": Path("/proc/new"),
        "full disk": Path("/dev/full"),
    }


OCCUPIED = (
    "below a file", "no such folder", "long name", "link to itself", "link to a file", "a file",
    "a full folder", "no permission", "full disk",
)  # fmt: skip


# The demo takes a minute, and makes folders that are missing.
@pytest.mark.parametrize("kind", OCCUPIED)
@pytest.mark.parametrize(("name", "given"), [one for one in WRITTEN if one[0] != "demo"])
def test_what_is_in_the_way_is_not_replaced(name, given, kind, folder):
    place = occupied(folder)[kind]
    result = refusal(line(name, folder, given, place), folder)
    # A link may be replaced, a folder made, and a summary gets another section.
    if not kind.startswith("link") and kind != "no such folder" and given != "summary":
        assert result.code == 2, result.out
