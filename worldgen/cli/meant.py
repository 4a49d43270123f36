"""What a word that names nothing here most likely means.

It may be a word of another tool, a misspelt name or file, or a number in another form.
"""

from __future__ import annotations

import contextlib
import itertools
import re
import shlex
from collections.abc import Iterable
from pathlib import Path

import click

from worldgen.cli.names import CONTROLLER, NameKind, without_options
from worldgen.domain import DECIMAL
from worldgen.parameters.known_names import nearest

_MOST_FILES = 50  # Python files in which a class is looked for

# Spellings from other tools, the most likely meaning first.
OTHER_WORDS = {
    "c": ("controller",), "robot": ("controller",), "policy": ("controller",),
    "algorithm": ("controller",), "m": ("motion",), "model": ("motion",),
    "o": ("out", "picture"), "output": ("out", "picture"), "output-dir": ("out",),
    "dir": ("out",), "folder": ("out",), "file": ("out",), "save": ("out", "picture"),
    "out": ("picture",),
    "seconds": ("budget",),
    "png": ("picture",), "svg": ("picture",), "html": ("picture", "report"),
    "image": ("picture",), "plot": ("picture",), "gif": ("picture",),
    "n": ("count", "units", "seeds", "examples", "steps"),
    "num": ("count", "units", "seeds"), "number": ("count", "units"),
    "iterations": ("units", "steps"), "runs": ("units", "seeds"), "trials": ("units", "seeds"),
    "j": ("workers",), "jobs": ("workers",), "threads": ("workers",), "processes": ("workers",),
    "s": ("seed",), "t": ("budget", "steps"), "time": ("budget",), "timeout": ("budget",),
    "time-limit": ("budget",), "duration": ("budget",), "max-steps": ("steps",),
    "dt": ("time-step",), "step-size": ("time-step",), "world": ("family", "from"),
    "width": ("size",), "height": ("size",), "f": ("force", "family"), "overwrite": ("force",),
    "y": ("force",), "format": ("to", "from"), "type": ("to", "kind"), "lang": ("kind",),
    "language": ("kind",), "r": ("radius", "robot-radius"), "env": ("family",),
    "verdict": ("only",), "cause": ("only",), "controller": ("only",), "v": ("version",), "h": ("help",),
    "detour": ("oracle",),
}  # fmt: skip
NAMED = {"only": ("verdict", "cause", "controller"), "oracle": ("detour",)}
"""What ``--only FIELD=PATTERN`` and ``--oracle NAME=NUMBER`` name and people take for options."""
COMMANDS = {
    "generate": "", "gen": "", "make": "", "new": "", "create": "", "add": "",
    "simulate": "run", "sim": "run", "exec": "run", "start": "run",
    "play": "studio", "gui": "studio", "ui": "studio", "serve": "studio", "web": "studio",
    "test": "fuzz", "search": "fuzz", "check": "verify", "validate": "verify",
    "view": "show", "draw": "show", "plot": "show", "render": "show", "cat": "show",
    "convert": "export", "ls": "list", "rm": "prune", "minimize": "shrink", "minimise": "shrink",
    "rerun": "replay", "list": "families", "benchmark": "compare", "bench": "compare",
}  # fmt: skip
"""Commands of other tools; an empty one is dropped: `worldgen generate maze`."""

_DECIMAL_COMMA = re.compile(r"\A(\s*[+-]?\d+),(\d+)(?![\d,])")
_UNITS = {"k": 1e3, "cm": 1e-2, "mm": 1e-3, "ms": 1e-3, "min": 60.0, "h": 3600.0}
_PREFIXES = ("cmd:", "lib:", "learned:")
_PLAIN_NAME = re.compile(r"[\w-]+")


def better_names(kind: NameKind, text: str) -> str:
    """Return a value with each of its names, separated by commas, replaced by a better one."""
    # The command of a program and the names of behaviours have commas of their own.
    if text.startswith((*_PREFIXES, "behaviours")):
        return text
    return ",".join(_better_name(kind, one) for one in text.split(","))


def _better_name(kind: NameKind, text: str) -> str:
    """Return what a value that names nothing most likely means, or the value itself."""
    # Names that exist, and those with a prefix, are left alone.
    name = without_options(text)
    options = text.removeprefix(name)
    if name in kind.names() or name.startswith((*_PREFIXES, "behaviours")):
        return text
    place, colon, attribute = name.rpartition(":")
    # mine.py, mine:Robot and ./mine.py:robot are classes in a file; so is a class alone.
    if name.endswith(".py"):
        place = name
        attribute = ""
    elif colon and place.isidentifier() and Path(f"{place}.py").is_file():
        place = f"./{place}.py"
    # Look the class up in the file, and the file among its neighbours.
    if place.endswith(".py"):
        file = Path(place) if Path(place).is_file() else Path(other_file(place, "no-such-file"))
        defined = kind.in_file(file) if file.suffix == ".py" else []
        if attribute not in defined:
            attribute = nearest(attribute, defined) or "".join(defined[:1])
        spelt = place if file == Path(place) else str(file)
        dot = "./" if place.startswith("./") and not spelt.startswith("./") else ""
        found = f"{dot}{spelt}:{attribute}" if attribute else ""
    # Any other file is a program.
    elif kind is CONTROLLER and Path(name).is_file():
        found = f"cmd:{name}" if "/" in name else f"cmd:./{name}"
    else:
        defined_here = _in_files(kind) if _PLAIN_NAME.fullmatch(name) else {}
        alike = [one for one in defined_here if one.casefold() == name.casefold()]
        # A class may differ in case only; any other name is more likely to be a built-in one.
        meant = name if name in alike else "".join(alike[:1])
        near = meant or nearest(name, kind.names()) or nearest(name, defined_here)
        found = defined_here.get(near, near)
    return f"{found}{options}" if found else text


def existing_names(kind: NameKind, text: str) -> str:
    """Return the names of an example that exist here, or a built-in one."""
    if text.startswith("behaviours"):
        return text
    existing = [one for one in better_names(kind, text).split(",") if _names_something(kind, one)]
    return ",".join(dict.fromkeys(existing)) or built_in(kind)


def _names_something(kind: NameKind, text: str) -> bool:
    """Return True if a name is built in, or its file defines it."""
    name = without_options(text)
    file, _, attribute = name.rpartition(":")
    is_defined = file.endswith(".py") and attribute in kind.in_file(Path(file))
    is_program = name.startswith(_PREFIXES) and not missing_part(name)
    return name in kind.names() or is_defined or is_program


def built_in(kind: NameKind) -> str:
    """Return the name of one that exists everywhere."""
    return "turn-right" if kind is CONTROLLER else next(iter(kind.names()), "")


def _in_files(kind: NameKind) -> dict[str, str]:
    """Return the names that the Python files of this folder define, as one writes them."""
    files = itertools.islice(sorted(Path().glob("*.py")), _MOST_FILES)
    return {name: f"./{file}:{name}" for file in files for name in kind.in_file(file)}


def other_file(name: str, code: str, suffixes: Iterable[str] = ()) -> str:
    """Return the file that was meant, or a free name; empty if no file fits.

    Args:
        name: The file as it was written.
        code: Code of the error about it.
        suffixes: Suffixes of the files that the command reads.
    """
    path = Path(name)
    if code in ("file-exists", "not-a-folder"):
        return unused(name)
    try:
        if path.is_dir():
            return next((str(one) for one in sorted(path.glob("*.grid"))), "")
        names = sorted(one.name for one in path.parent.iterdir() if not one.name.startswith("."))
    except (OSError, ValueError):
        return ""
    if f"{path.name}.grid" in names:
        return f"{name}.grid"
    # A file of another kind would be refused.
    same = {Path(one).stem: one for one in names if Path(one).suffix == path.suffix}
    readable = [one for one in names if Path(one).suffix in suffixes]
    near = same.get(nearest(path.stem, same)) or nearest(path.name, readable)
    return str(path.with_name(near)) if near else ""


def unused(name: str) -> str:
    """Return a name to write to, which does not exist yet."""
    stem = name.rstrip("/")
    slash = "/" if name.endswith("/") else ""
    path = Path(stem)
    number = 2
    while path.exists() and number < 100:
        path = Path(stem).with_name(f"{Path(stem).stem}-{number}{Path(stem).suffix}")
        number += 1
    return f"{path}{slash}"


def missing_part(name: str) -> str:
    """Return the file in a controller's name if it does not exist; empty if it does."""
    bare = name.partition("+")[0]
    prefix = next((one for one in _PREFIXES if bare.startswith(one)), "")
    file = bare.removeprefix(prefix)
    if prefix == "cmd:":
        with contextlib.suppress(ValueError):
            file = next(iter(shlex.split(file)), "")
    elif not prefix and ".py:" in file:
        file = file.rpartition(":")[0]
    is_path = "/" in file or (prefix not in ("", "cmd:")) or file.endswith(".py")
    return file if is_path and ":" not in file and is_missing(file) else ""


def is_missing(text: str) -> bool:
    """Return True if a path leads nowhere, neither to a file nor into an archive."""
    if not text or text == "-" or set(text) & set("*?["):
        return False
    try:
        path = Path(text)
        return not path.exists() and not any(one.is_file() for one in path.parents)
    except (OSError, ValueError):
        return False


def better_values(parameter: click.Parameter, text: str) -> list[str]:
    """Return what a refused value may have meant, the most likely first."""
    # A choice is misspelt.
    kind = parameter.type
    if isinstance(kind, click.Choice):
        near = nearest(text, map(str, kind.choices))
        return [near] if near else []
    if isinstance(kind, click.types.IntParamType) and text[:2].lower() == "0x":
        with contextlib.suppress(ValueError):
            return [str(int(text, 16))]
    # 0,1 is 0.1 where a number need not be whole.
    if not isinstance(kind, click.types.IntParamType):
        text = _DECIMAL_COMMA.sub(r"\1.\2", text)
    found = DECIMAL.search(text)
    if found is None:
        return []
    # Read the number and its unit, then keep it within its bounds.
    number = float(found[0])
    unit = re.match(r"\s*([a-zA-Z]+)", text[found.end() :])
    word = unit[1].casefold() if unit else ""
    if isinstance(kind, click.types.IntParamType | click.types.FloatParamType):
        value = number * (
            _UNITS.get(word, 1.0) if word in ("k", "cm", "mm", "ms", "min", "h") else 1.0
        )
        low = getattr(kind, "min", None)
        high = getattr(kind, "max", None)
        value = max(value, low) if low is not None else value
        value = min(value, high) if high is not None else value
        is_whole = isinstance(kind, click.types.IntParamType)
        return [str(int(value)) if is_whole else f"{value:g}"]
    # A duration.
    return [f"{found[0]}{word[:1]}", found[0]]
