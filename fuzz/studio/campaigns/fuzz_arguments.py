"""Translate the campaign page's requests into arguments of ``worldgen fuzz``.

The arguments are run, or shown for copying. Code in a file, or a file outside the opened folder,
appears in them only if it was named when the studio was started.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from fuzz.corpus import read_corpus
from fuzz.failure import Failure
from fuzz.oracles import ORACLES
from fuzz.search.registry import OWN_STRATEGIES
from fuzz.studio.requests.folder import KNOWN, Folder, Opened
from fuzz.studio.requests.limits import MOST_SECONDS, MOST_UNITS, MOST_WORKERS
from fuzz.studio.requests.messages import Request, seed_of
from fuzz.studio.requests.messages import field as part_of
from fuzz.studio.requests.running import check_registered, from_anywhere, label_in
from fuzz.unit.options import BASELINE_HELP, CampaignOptions
from sim.controllers import CONTROLLERS
from sim.motion import MOTIONS
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.whole import read_text
from worldgen.files.worlds import files_in
from worldgen.parameters import Parameter


def begun(message: Request, opened: Opened) -> list[str]:
    """Return the arguments that define a campaign, without fixed map, folder and budget.

    Args:
        message: The page's message.
        opened: The opened folder, and the controllers that were named at the start.

    Raises:
        InvalidParameter: If the message requests something that is not offered.
    """
    # Check everything that could name code in a file or a place outside the folder.
    checked: dict[str, Any] = {
        "controller": label_in(opened, part_of(message, "controller", str)),
        "motion": _one_of(message, "motion", MOTIONS.names()),
        "oracles": tuple(check_oracles(message.get("oracles", []))),
    }
    strategies = check_strategies(message.get("strategies"))
    checked["families"] = tuple(
        strategy for strategy in strategies if strategy not in OWN_STRATEGIES
    )
    checked["strategies"] = tuple(strategy for strategy in strategies if strategy in OWN_STRATEGIES)
    if message.get("database") is not None:
        checked["database"] = str(opened.folder.place(part_of(message, "database", str)))
    # The other options check their own values.
    words = []
    for option in CampaignOptions.declared():
        value = checked.get(
            option.name, None if option.name == "world" else message.get(option.name)
        )
        if value is not None:
            words += _words(option, option.accept(value, "campaign"))
    return [*words, f"--seed={seed_of(message)}"] if message.get("seed") is not None else words


def _words(option: Parameter, value: Any) -> list[str]:
    """Return an option in the form that the command line takes."""
    if isinstance(value, bool):
        return [option.flag if value else f"--no-{option.flag.removeprefix('--')}"]
    if isinstance(value, tuple):
        return [f"{option.flag}={one}" for one in value]
    if isinstance(value, float):
        return [f"{option.flag}={value!r}".removesuffix(".0")]
    return [f"{option.flag}={value}"]


def budget(message: Request, *, needed: bool) -> list[str]:
    """Return the budget's argument; none if it is neither given nor needed."""
    if message.get("units") is not None:
        return [f"--units={_whole(message, 'units', MOST_UNITS)}"]
    if message.get("seconds") is None and not needed:
        return []
    seconds = part_of(message, "seconds", float)
    if not 0.0 < seconds <= MOST_SECONDS:
        raise InvalidParameter(
            "out-of-range",
            "{seconds:g} s",
            "use a time above 0 and up to {most:g} s",
            seconds=seconds,
            most=MOST_SECONDS,
        )
    return [f"--budget={f'{seconds:f}'.rstrip('0').rstrip('.')}s"]


def workers(message: Request) -> list[str]:
    """Return the argument for the number of worker processes."""
    return (
        []
        if message.get("workers") is None
        else [f"--workers={_whole(message, 'workers', MOST_WORKERS)}"]
    )


def baseline(message: Request, folder: Folder) -> list[str]:
    """Return the arguments for known failures: the folder for them if requested, and others."""
    known = folder.place(KNOWN)
    wanted = message.get("known") is True and known.is_dir() and bool(files_in(known))
    places = [
        *([known] if wanted else []),
        *(folder.place(name) for name in _texts(message, "baseline")),
    ]
    for place in places:
        _check_baseline(place, place.relative_to(folder.root).as_posix())
    return [f"--baseline={place}" for place in places]


def _check_baseline(place: Path, name: str) -> None:
    """Refuse failures outside the folder, and those whose oracles are code from files.

    Oracles of known failures would run again.
    """
    if not place.is_dir():
        raise InvalidParameter(
            "wrong-kind-of-file",
            "{name} is not a folder of failures",
            "choose one in the opened folder",
            name=name,
        )
    for file in files_in(place):
        if file.is_symlink():
            raise InvalidParameter(
                "is-a-link",
                "{name}/ contains a link, {file}",
                "copy the file into it",
                name=name,
                file=file.name,
            )
    for entry in read_corpus([place]).entries:
        oracle = Failure.read(entry.path).oracle
        if oracle is not None:
            check_oracles([oracle])


def command_line(words: Sequence[str], message: Request, out: Path, folder: Folder) -> str:
    """Return the command that does the same at a terminal.

    Args:
        words: All arguments except the fixed map and the folder.
        message: The page's message; ``world_name`` is the file of a drawn map, if one is fixed.
        out: The campaign's folder.
        folder: The opened folder.

    Raises:
        InvalidParameter: If a drawn map has not been saved to a file.
    """
    drawn = message.get("world")
    # A command needs a file, so the drawn map must have been saved as it is now.
    if drawn is not None:
        place = folder.place(str(message.get("world_name") or "-"))
        if not place.is_file() or read_text(place) != part_of({"world": drawn}, "world", dict).get(
            "source"
        ):
            raise InvalidParameter(
                "not-saved",
                "the drawn map is not in a file yet, but the command must name one",
                "save it first",
            )
        words = [*words, f"--world={place}"]
    # Write options as users do, with a space. A value that begins with "-" needs the "=".
    arguments: list[str] = []
    for word in (*words, f"--out={out}"):
        option, equals, value = word.partition("=")
        arguments += [option, value] if equals and not value.startswith("-") else [word]
    line = shlex.join(["worldgen", "fuzz", *arguments])
    controller = part_of(message, "controller", str)
    return from_anywhere(line, controller, CONTROLLERS.names())


def options() -> dict[str, dict[str, Any]]:
    """Return the command's options that the page has fields for: ``help`` and ``default`` by name.

    Help that applies only to the command line is omitted, such as how to name a class in a file.
    """
    declared = {
        option.flag: {"help": option.help, "default": _plain(option.default)}
        for option in CampaignOptions.declared()
    }
    return declared | {"--baseline": {"help": BASELINE_HELP, "default": None}}


def _plain(default: object) -> object:
    return default if isinstance(default, int | float | str) else None


def check_strategies(names: object) -> list[str]:
    """Return strategies and families, refusing unregistered ones, which are code from files."""
    offered = (*OWN_STRATEGIES, *FAMILIES.names())
    return [
        _one_of({"strategies": one}, "strategies", offered)
        for one in part_of({"strategies": names}, "strategies", list)
    ]


def check_oracles(texts: object) -> list[str]:
    """Return oracles, refusing unregistered ones, which are code from files."""
    oracles = _texts({"oracles": texts}, "oracles")
    for text in oracles:
        if text.partition("=")[0].strip() not in ORACLES.names():
            raise InvalidParameter(
                "not-registered",
                "oracle {oracle!r} is not registered",
                "choose one of {known!l}",
                oracle=text[:40],
                known=list(ORACLES),
            )
    return oracles


def _one_of(message: Request, name: str, offered: Iterable[str]) -> str:
    value = part_of(message, name, str)
    check_registered(name, value, offered)
    return str(value)


def _texts(message: Request, name: str) -> list[str]:
    return (
        [part_of({name: one}, name, str) for one in part_of(message, name, list)]
        if name in message
        else []
    )


def _whole(message: Request, name: str, most: int) -> int:
    value: int = part_of(message, name, int)
    if not 1 <= value <= most:
        raise InvalidParameter(
            "out-of-range",
            "{name} is {value}",
            "use a whole number from 1 to {most}",
            name=name,
            value=value,
            most=most,
        )
    return value
