"""``worldgen new-controller``: write a working example to start from."""

from __future__ import annotations

import importlib.resources
import keyword
import os
import re
import shlex
from pathlib import Path

import click

from worldgen.cli.output import PATH, emit_json, force_option, json_option, note, say
from worldgen.errors import InvalidParameter, OutputError
from worldgen.files.whole import write_bytes

EXAMPLES = (
    "\b\n  worldgen new-controller mine --kind python\n"
    "  worldgen new-controller my-robot --kind process --out robots/\n"
    "  worldgen new-controller fast --kind c --out fast.c --force"
)
KINDS = ("c", "cpp", "compiled", "python", "vector", "process")
_COMPILERS = {"c": "cc -std=c17 -O2 -shared -fPIC", "cpp": "c++ -std=c++20 -O2 -shared -fPIC"}


@click.command(epilog=EXAMPLES)
@click.argument("name")
@click.option(
    "--kind",
    type=click.Choice(KINDS),
    default="python",
    show_default=True,
    help="A C or C++ function in a shared library, one that numba compiles, a Python class for "
    "one robot, one for "
    "many robots at once with NumPy, or a separate program that speaks JSON lines.",
)
@click.option(
    "--out",
    type=PATH,
    metavar="DIR|FILE",
    help="Where to write it.  [default: ./NAME.py, .c or .cpp]",
)
@json_option
@force_option
def new_controller(name: str, kind: str, out: Path | None, as_json: bool, force: bool) -> None:
    """Write a working, commented controller to start from.

    All kinds follow the same rule: drive to the target and, after a bump, away from the wall for a
    while. The kinds in C and C++ and the compiled one run millions of steps per second, and their
    loops are proved. The Python class runs a few hundred thousand, and the vector class millions if
    it drives many robots; their loops are proved too. The process can be in any language and may
    hide state, so its loops are not proved: they are reported as stalled.
    """
    word = _word(name)
    path = _place(out, word, kind)
    example = f"library{_suffix(kind)}" if kind in _COMPILERS else f"{kind}.py"
    folder = importlib.resources.files("sim.controllers.examples")
    text = folder.joinpath(example).read_text(encoding="utf-8")
    write_bytes(path, _renamed(text, word).encode(), force=force)
    if kind == "process":
        path.chmod(path.stat().st_mode | 0o111 & ~_umask())
    controller = _reference(path, word, kind)
    build = _build(path, kind)
    if as_json:
        emit_json(
            {"file": str(path), "kind": kind, "controller": controller}
            | ({"build": build} if build else {})
        )
        return
    note(f"wrote {path}; next:")
    if build:
        say(build)
    say("worldgen trap --size 20 --seed 4 --out w.grid")
    say(f"worldgen run w.grid --controller {shlex.quote(controller)} --picture run.png")
    say(f"worldgen fuzz --controller {shlex.quote(controller)} --budget 30s --out failures/")


def _word(name: str) -> str:
    """Return the name as a Python identifier."""
    word = name.replace("-", "_")
    if (
        not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,63}", word)
        or keyword.iskeyword(word)
        or keyword.issoftkeyword(word)
    ):
        raise InvalidParameter(
            "not-a-controller-name",
            "{name!r} is not a name for a controller",
            "use up to 64 letters, digits, - and _, beginning with a letter, and no Python "
            "keyword, as in my-robot",
            name=name,
        )
    return word


def _suffix(kind: str) -> str:
    """Return the suffix of a file of this kind."""
    return f".{kind}" if kind in _COMPILERS else ".py"


def _place(out: Path | None, word: str, kind: str) -> Path:
    suffix = _suffix(kind)
    if out is None:
        return Path(f"{word}{suffix}")
    if out.is_dir():
        return out / f"{word}{suffix}"
    if kind != "process" and out.suffix != suffix:
        raise OutputError(
            "no-place-for-file",
            "{out} is neither an existing folder nor a {suffix} file",
            "create the folder, or name a {suffix} file",
            out=out,
            suffix=suffix,
        )
    return out


def _build(path: Path, kind: str) -> str:
    """Return the command that builds a shared library; empty if none is needed."""
    if kind not in _COMPILERS:
        return ""
    library = shlex.quote(str(path.with_suffix(".so")))
    return f'{_COMPILERS[kind]} -I"$(worldgen --include)" {shlex.quote(str(path))} -o {library}'


def _renamed(text: str, word: str) -> str:
    """Return the example under another name, without the directives for our linter."""
    text = re.sub(r"  # noqa: .*", "", text)
    return re.sub(r"\bExample\b", _title(word), re.sub(r"\bexample\b", word, text))


def _title(word: str) -> str:
    """Return the name of a class: ``MyRobot`` for ``my_robot``."""
    return "".join(part[:1].upper() + part[1:] for part in word.split("_"))


def _reference(path: Path, word: str, kind: str) -> str:
    """Return the name for ``--controller``."""
    place = str(path) if path.is_absolute() or str(path).startswith((".", "~")) else f"./{path}"
    if kind in _COMPILERS:
        return f"lib:{place.removesuffix(_suffix(kind))}.so:{word}"
    if kind == "process":
        return f"cmd:{shlex.quote(place)}"
    return f"{place}:{_title(word) if kind in ('python', 'vector') else word}"


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask
