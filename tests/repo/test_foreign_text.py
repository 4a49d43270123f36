"""No text of a stranger reaches a terminal, a log or a page as it was, whatever the command."""

import ast
import importlib
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import click
import pytest

from fuzz.failure import Failure
from fuzz.shrink import snippet
from tests.helpers.command_line import worldgen
from tests.helpers.hostile_text import MARK, NAME, TEXT, faults, on_a_terminal
from worldgen.cli.main import cli
from worldgen.errors import FormatError
from worldgen.files.grid import dumps, loads, read_world, write_world
from worldgen.plugins.entry_points import points_of
from worldgen.world import Provenance

CORPUS = Path(__file__).parents[2] / "corpora"
LOOP = CORPUS / "failures/turn-right/swept/returns-to-a-wall-2.grid"
RAISING = f"""
class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        raise ValueError({TEXT!r})


def family(rng, *, size: int = 20):
    raise ValueError({TEXT!r})
"""
PROGRAM = f"""
import sys
sys.stderr.write({TEXT!r})
print({TEXT!r})
"""
FAMILY = f"""
from worldgen.family import family


@family("mine", version=1)
def mine(rng, *, size: int = 20):
    {TEXT!r}
    raise ValueError({TEXT!r})
"""
LIBRARY = r"""
#include "worldgen_controller.h"
static void act(const WgObservation *observation, double *memory, WgCommand *command)
{
    command->error = "Oops\033]0;x\007: text\033[2J\033[35;7;9m\n::error::OWNED\n##[error]OWNED";
}
WG_CONTROLLER(act, .memory_size = 1)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of a stranger's: every file has a name and a content that he would like shown."""
    folder = tmp_path_factory.mktemp("stranger")
    bare = read_world(LOOP)
    evil = {TEXT: TEXT, "error": TEXT, "oracle": TEXT, "objection": {TEXT: TEXT}}
    details = bare.failure.details | {"class": TEXT, "cause": TEXT, "found_by": TEXT, TEXT: TEXT}
    record = replace(bare.failure, details=details)
    worlds = {
        "named": replace(record, evidence={**record.evidence, TEXT: TEXT}),
        "oracle": replace(record, evidence={**record.evidence, **evil}),
        "unknown": replace(record, controller=TEXT, trace_digest=TEXT),
        "option": replace(record, parameters={**record.parameters, TEXT: TEXT}),
        "raises": replace(record, controller="./raises.py:Robot", verdict="crash", evidence=evil),
        # This one's oracle exists, so that replay runs the controller.
        "crashes": replace(record, controller="./raises.py:Robot", verdict="crash"),
        "program": replace(record, controller="cmd:python3 program.py"),
        "library": replace(record, controller="lib:./library.so:act", verdict="crash"),
        "verdict": replace(record, verdict="unheard-of"),
    }
    for name, failure in worlds.items():
        world = replace(
            bare, failure=failure, provenance=Provenance(TEXT, 1, 0, {TEXT: TEXT}, {TEXT: 1.0})
        )
        write_world(world, folder / f"{name}{NAME}.grid")
    (folder / "raises.py").write_text(RAISING)
    (folder / f"raises{NAME}.py").write_text(RAISING)
    (folder / "family.py").write_text(FAMILY)
    (folder / "library.c").write_text(LIBRARY)
    include = worldgen("--include").out.strip()
    build = ["cc", "-shared", "-fPIC", f"-I{include}", "library.c", "-o", "library.so"]
    subprocess.run(build, cwd=folder, check=True)
    # What every command needs is imported once, not in each child.
    for point in points_of("worldgen.formats"):
        point.load()
    importlib.import_module("fuzz.ci")
    importlib.import_module("sim.episode.batch")
    (folder / "program.py").write_text(PROGRAM)
    # Files that no reader accepts; each error quotes its fault.
    good = (folder / f"named{NAME}.grid").read_bytes()
    raw = TEXT.encode()
    broken = {
        "return.grid": b"%worldgen-grid 1\nstart = " + raw + b"\n%cells\n..\n%end\n",
        "toml.grid": b"%worldgen-grid 1\nstart = \x1b[2J\xc2\x9b\n%cells\n..\n%end\n",
        "key.grid": good.replace(b"cell_size", json.dumps(TEXT).encode() + b" = 1\ncell_size", 1),
        "motion.grid": good.replace(b'motion = "', b'motion = "\\u001B[2J'),
        "cells.grid": good.replace(b"%cells\n", b"%cells\n\x1b]0;x\x07", 1),
        "magic.grid": raw,
        "map.yaml": b"image: " + raw + b"\nresolution: 1\n",
        "bidi.yaml": "image: \u202e\u200b.pgm\nresolution: \u2066\n".encode(),
        "map.json": json.dumps({"type": TEXT}).encode(),
        "map.tmj": json.dumps(
            {"type": "map", "orientation": TEXT, "width": 2, "height": 2, "layers": []}
        ).encode(),
        "map.sdf": f"<sdf version='1.6'><world name='{MARK}\x9b'>&x;\x1b</world></sdf>".encode(),
        "map.map": b"type octile\nheight 2\nwidth 2\nmap\n..\n.\x1b[2J\n",
        "map.scen": b"version 1\n" + raw + b"\n",
        "map.txt": raw,
        "map.pgm": b"P5\n#" + raw + b"\n2 2\n255\n\0\0\0",
        "map.png": b"\x89PNG\r\n\x1a\n" + raw,
        "map.gltf": json.dumps({"asset": {"version": TEXT}, "extensionsRequired": [TEXT]}).encode(),
        "map.npy": b"\x93NUMPY" + raw,
        "map.csv": raw,
        "settings.toml": ("about = " + json.dumps(TEXT) + "\n[" + MARK + "]\n").encode(),
        "manifest.jsonl": json.dumps({"format": TEXT}).encode() + b"\n",
        "set.zip": raw,
    }
    for name, data in broken.items():
        stem, _, ending = name.partition(".")
        (folder / f"{stem}{NAME}.{ending}").write_bytes(data)
    return folder


def grids(folder):
    return sorted(file.name for file in folder.glob("*.grid"))


def maps(folder):
    return sorted(
        file.name for file in folder.iterdir() if file.suffix not in (".grid", ".py", ".c", ".so")
    )


PRINTING = (
    "print",
    "click.echo",
    "click.secho",
    "click.style",
    "sys.stdout.write",
    "sys.stderr.write",
    "traceback.print_exc",
    "traceback.print_exception",
)
BAD = (
    "./raises.py:Robot",
    f"./raises{NAME}.py:Robot",
    "cmd:python3 program.py",
    "lib:./library.so:act",
    TEXT,
)
ROBOT = ("--controller", "./raises.py:Robot")


def runs_of(folder):
    """Return the runs of each command: lists of arguments, by the command's words."""
    each = grids(folder)
    good = [name for name in each if name.startswith(("named", "raises", "crashes", "program"))]
    one = good[0]
    foreign = maps(folder)
    whole = str(folder)
    few = ("--units", 1, "--examples", 9, "--seed", 1, "--workers", 1)
    traps = (*few, "--family", "trap")
    return {
        "show": [[name] for name in [*each, NAME]],
        "verify": [each[:1], [one], [NAME], [whole]],
        "measure": [[one], [NAME], [whole]],
        "run": [[one, "--controller", name] for name in BAD] + [[NAME, *ROBOT]],
        "replay": [[name, "--show"] for name in each] + [[whole]],
        "shrink": [[name, "--out", f"out{k}{NAME}.grid"] for k, name in enumerate(good)]
        + [[one, "--snippet"], [NAME]],
        "explain": [[whole], [NAME]],
        "boundary": [[name] for name in good] + [[one, "--controller", TEXT]],
        "report": [[whole, "--out", f"report{NAME}.html"], [NAME, "--out", "no.html"]],
        "corpus list": [[whole], [NAME]],
        "corpus show": [[whole], ["--class", TEXT, whole]],
        "corpus merge": [[whole, "--out", f"merged{NAME}"]],
        "corpus diff": [[one, whole], [whole, one]],
        "corpus prune": [["--dry-run", whole]],
        "corpus export": [[whole, "--out", f"all{NAME}.zip"], [one, "--out", NAME]],
        "fuzz": [
            ["--controller", name, *traps, "--out", f"f{k}{NAME}", "-v"]
            for k, name in enumerate(BAD)
        ]
        + [["--controller", "turn-right", "--world", one, *few, "--out", f"w{NAME}"]]
        + [["--resume", NAME], ["--controller", "turn-right", "--baseline", whole, *traps]]
        + [["--controller", "turn-right", "--oracle", TEXT, *traps]],
        "find": [["--outcome", f"{TEXT}=reached", "--out", "x.grid"]],
        "compare": [
            [whole, "--controller", "turn-right"],
            [one, *ROBOT],
            [one, "--controller", TEXT],
        ],
        "audit": [[one, name] for name in foreign[:3]] + [[NAME, NAME]],
        "train": [[one, "--controller", TEXT, "--out", "x.q"], [NAME, "--out", "x.q"]],
        "check-family": [["./family.py:mine"], [f"./{NAME}.py:mine"], [TEXT]],
        "./family.py:mine": [["--seed", 1], ["--help"], ["--size", TEXT]],
        "import": [[name, "--out", f"i{k}.grid"] for k, name in enumerate([*foreign, *each, NAME])],
        "export": [
            [one, "--to", "ros", "--out", f"e{NAME}.yaml"],
            [one, "--to", TEXT, "--out", "x"],
            [NAME, "--to", "ros", "--out", "x.yaml"],
        ],
        "regenerate": [[name] for name in foreign if name.endswith((".jsonl", ".zip"))],
        "init": [[f"project{NAME}", "--controller", TEXT]],
        "demo": [["--out", f"demo{NAME}", "--controller", TEXT]],
        "studio": [[NAME], ["--host", TEXT]],
        "new-controller": [[TEXT], [NAME, "--out", f"new{NAME}"]],
        "controllers": [["./raises.py:Robot"], [TEXT], [f"./raises{NAME}.py:Robot"]],
        "behaviours": [[TEXT], [f"behaviours:{TEXT}"]],
        "formats": [[TEXT]],
        "help": [[TEXT]],
        "families": [[], [TEXT]],
        "oracles": [[], [TEXT]],
        "watchdog": [
            ["simple-progress", whole, "--worlds", 0],
            [TEXT, whole],
            ["oscillation", NAME],
        ],
        "maze": [["--size", TEXT], ["--out", f"maze{NAME}.grid"], ["--where", TEXT]],
        TEXT: [[]],
    }


def leaves():
    """Return the words of every command of every installed package."""
    found = []
    for point in points_of("worldgen.commands"):
        command = cli.get_command(click.Context(cli), point.name)
        below = command.commands if isinstance(command, click.Group) else None
        found += [point.name] if below is None else [f"{point.name} {name}" for name in below]
    return sorted(found)


@pytest.mark.parametrize("words", leaves())
def test_every_command_has_hostile_input(folder, words):
    assert words in runs_of(folder), f"{words} is new: give it a stranger's file in runs_of()"


QUICK = ("show", "verify", "corpus list", "maze", TEXT)


def _check(folder, tmp_path, words, *options):
    place = shutil.copytree(folder, tmp_path / "w")
    found = []
    for args in runs_of(place)[words]:
        code, output = on_a_terminal(
            *words.split(" ") if words != TEXT else [TEXT], *options, *args, folder=place
        )
        found += [f"{args}: {fault}" for fault in faults(output)]
        # A family that raises is reported as a fault of ours.
        allowed = (0, 1, 2, 3, 4) if words.startswith("./family") else (0, 1, 2, 4)
        found += [f"{args}: ended with {code}: {output[-300:]}"] if code not in allowed else []
    assert not found, "\n".join(found)


@pytest.mark.gate
@pytest.mark.parametrize("words", QUICK, ids=lambda words: words[:12].replace("\x1b", ""))
def test_no_control_character_of_a_stranger_reaches_the_terminal(folder, tmp_path, words):
    _check(folder, tmp_path, words)


@pytest.mark.gate
@pytest.mark.parametrize("words", [*sorted(set(leaves()) - set(QUICK)), "./family.py:mine"])
def test_no_control_character_of_a_stranger_reaches_the_terminal_from_any_command(
    folder, tmp_path, words
):
    _check(folder, tmp_path, words)


@pytest.mark.gate
@pytest.mark.parametrize("words", [*leaves(), "./family.py:mine"])
def test_no_control_character_of_a_stranger_s_code_reaches_the_terminal(folder, tmp_path, words):
    _check(folder, tmp_path, words, "--trust")


@pytest.mark.gate
@pytest.mark.parametrize("words", ["replay --show", "explain", "corpus show"])
@pytest.mark.parametrize(
    ("name", "text"),
    [("crashes", "ValueError: x\\x1b]52;c;"), ("library", "Oops\\x1b]0;x\\x07: text\\x1b[2J")],
)
def test_what_a_stranger_s_trusted_code_raises_is_printed_escaped(folder, words, name, text):
    file = next(file for file in grids(folder) if file.startswith(name))
    _, output = on_a_terminal(*words.split(" "), "--trust", file, folder=folder)
    assert text in output
    assert not faults(output)


@pytest.mark.gate
def test_what_a_stranger_s_trusted_program_prints_is_printed_escaped(folder):
    file = next(file for file in grids(folder) if file.startswith("program"))
    _, output = on_a_terminal("replay", "--show", "--trust", file, folder=folder)
    assert "x\\x1b]52;c;" in output
    assert not faults(output)


def test_styles_of_ours_survive_and_the_stranger_s_become_text(folder):
    name = next(name for name in grids(folder) if name.startswith("named"))
    code, output = on_a_terminal("show", name, folder=folder)
    assert code == 0
    assert "\x1b[38;" in output and "\x1b[35;7;9m" not in output and "\\x1b[35;7;9mred" in output
    assert "[red]b" in output


def test_a_test_module_holds_the_world_in_visible_text(folder):
    name = next(name for name in grids(folder) if name.startswith("oracle"))
    module = snippet(Failure.read(folder / name))
    assert module.isascii() and not faults(module)
    names = {}
    exec(module, names)
    assert names["FAILURE"].failure.evidence == read_world(folder / name).failure.evidence


def test_json_keeps_the_text_as_it_is(folder):
    name = next(name for name in grids(folder) if name.startswith("oracle"))
    found = json.loads(worldgen("show", folder / name, "--json").out)
    assert found["failure"]["evidence"][TEXT] == TEXT
    assert found["file"] == str(folder / name)


def test_a_line_of_json_holds_no_command_of_a_ci_service(folder):
    name = next(name for name in grids(folder) if name.startswith("oracle"))
    out = worldgen("show", folder / name, "--json").out
    assert not faults(out)


def test_reports_for_ci_hold_the_text_as_text(folder, tmp_path):
    paths = {name: tmp_path / f"report.{name}" for name in ("junit", "sarif", "summary")}
    options = [word for name, path in paths.items() for word in (f"--{name}", path)]
    names = [folder / name for name in grids(folder) if name.startswith(("named", "library"))]
    worldgen("replay", *names, *options)
    suite = ElementTree.fromstring(paths["junit"].read_bytes())
    assert len(suite.findall(".//testcase")) == len(names)
    json.loads(paths["sarif"].read_text())
    for path in paths.values():
        assert not faults(path.read_text()), path
    assert "<img" not in paths["summary"].read_text()


def test_a_page_holds_the_text_as_text(folder, tmp_path):
    page = tmp_path / "page.html"
    names = [folder / name for name in grids(folder) if name.startswith("named")]
    worldgen("report", *names, "--out", page)
    text = page.read_text()
    assert MARK in text
    assert "<img src=x>" not in text
    assert text.count("</script>") == text.count("<script")


@pytest.mark.parametrize("key", ["verdict", "motion"])
@pytest.mark.parametrize(
    "value", ["\x1b[2J", "loop\n::error::x", "two words", "Loop", "\u202eloop", "", "a" * 65, "-x"]
)
def test_a_record_whose_verdict_or_motion_is_no_word_is_refused(key, value):
    record = read_world(LOOP).failure
    text = LOOP.read_text().replace(
        f'{key} = "{getattr(record, key)}"', f"{key} = {json.dumps(value)}", 1
    )
    with pytest.raises(FormatError) as caught:
        loads(text.encode())
    assert (caught.value.code, caught.value.facts["key"]) == ("not-a-word", key)
    assert caught.value.line


@pytest.mark.parametrize("key", ["verdict", "motion"])
def test_an_unknown_word_stays_readable(key):
    record = read_world(LOOP).failure
    text = LOOP.read_text().replace(f'{key} = "{getattr(record, key)}"', f'{key} = "new-2"', 1)
    world = loads(text.encode())
    assert getattr(world.failure, key) == "new-2"
    assert dumps(world) == text.encode()


def test_only_the_command_line_s_own_functions_print():
    """A command that prints by itself would bypass the door."""
    root = Path(__file__).parents[2]
    allowed = {
        "worldgen/cli/output.py",
        "worldgen/support/progress.py",
        "worldgen/interop/players/gazebo_player.py",  # runs in Gazebo
        "sim/controllers/examples/process.py",  # an example program
    }
    found = []
    for package in ("worldgen", "sim", "fuzz", "worldgen_plugins"):
        for path in sorted((root / package).rglob("*.py")):
            name = path.relative_to(root).as_posix()
            text = path.read_text()
            # Parsing every file would take ten seconds.
            if name in allowed or not any(f"{call}(" in text for call in PRINTING):
                continue
            for node in ast.walk(ast.parse(text)):
                call = ast.unparse(node.func) if isinstance(node, ast.Call) else ""
                if call in PRINTING:
                    found.append(f"{name}:{node.lineno}: {call}")
    assert not found, f"print with say() or note() of worldgen.cli.output: {found}"
