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
from fuzz.studio.requests.protocol import Begin, CampaignBudget, OptionHelp
from fuzz.studio.requests.running import check_registered, from_anywhere, label_in
from fuzz.unit.options import BASELINE_HELP, CampaignOptions
from sim.controllers import CONTROLLERS
from sim.motion import MOTIONS
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.whole import read_text
from worldgen.files.worlds import files_in
from worldgen.parameters import Parameter


def begun(request: Begin, opened: Opened) -> list[str]:
    """Return the arguments that define a campaign, without fixed map, folder and budget.

    Raises:
        InvalidParameter: If the request names something that is not offered.
    """
    # Check everything that could name code in a file or a place outside the folder.
    check_registered("motion", request.motion, MOTIONS.names())
    check_strategies(request.strategies)
    check_oracles(request.oracles)
    is_own = [strategy in OWN_STRATEGIES for strategy in request.strategies]
    named = [*zip(request.strategies, is_own, strict=True)]
    checked: dict[str, Any] = {
        "controller": label_in(opened, request.controller),
        "families": tuple(one for one, own in named if not own),
        "strategies": tuple(one for one, own in named if own),
        "oracles": tuple(request.oracles),
        "vary": tuple(request.vary),
        "world": None,
    }
    # The other options check their own values.
    words = []
    for option in CampaignOptions.declared():
        value = checked.get(option.name, getattr(request, option.name, None))
        if value is not None:
            words += _words(option, option.accept(value, "campaign"))
    return words if request.seed is None else [*words, f"--seed={request.seed}"]


def _words(option: Parameter, value: Any) -> list[str]:
    """Return an option in the form that the command line takes."""
    if isinstance(value, bool):
        return [option.flag if value else f"--no-{option.flag.removeprefix('--')}"]
    if isinstance(value, tuple):
        return [f"{option.flag}={one}" for one in value]
    if isinstance(value, float):
        return [f"{option.flag}={value!r}".removesuffix(".0")]
    return [f"{option.flag}={value}"]


def spent(request: CampaignBudget, folder: Folder) -> list[str]:
    """Return the arguments for the budget, the worker processes and known failures."""
    words = []
    if request.units is not None:
        words.append(f"--units={request.units}")
    elif request.seconds is not None:
        words.append(f"--budget={f'{request.seconds:f}'.rstrip('0').rstrip('.')}s")
    if request.workers is not None:
        words.append(f"--workers={request.workers}")
    known = folder.place(KNOWN)
    wanted = request.known and known.is_dir() and bool(files_in(known))
    places = [*([known] if wanted else []), *map(folder.place, request.baseline)]
    for place in places:
        _check_baseline(place, place.relative_to(folder.root).as_posix())
    return [*words, *(f"--baseline={place}" for place in places)]


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


def command_line(words: Sequence[str], request: Begin, out: Path, folder: Folder) -> str:
    """Return the command that does the same at a terminal.

    Args:
        words: All arguments except the fixed map and the folder.
        request: The request.
        out: The campaign's folder.
        folder: The opened folder.

    Raises:
        InvalidParameter: If a drawn map has not been saved to a file.
    """
    # A command needs a file, so the drawn map must have been saved as it is now.
    if request.world is not None:
        place = folder.place(request.world_name or "-")
        if not place.is_file() or read_text(place) != request.world.source:
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
    return from_anywhere(line, request.controller, CONTROLLERS.names())


def options() -> dict[str, OptionHelp]:
    """Return the command's options that the page has fields for, by name.

    Help that applies only to the command line is omitted, such as how to name a class in a file.
    """
    declared = {
        option.flag: OptionHelp(option.help, _plain(option.default))
        for option in CampaignOptions.declared()
    }
    return declared | {"--baseline": OptionHelp(BASELINE_HELP, None)}


def _plain(default: object) -> str | int | float | None:
    return default if isinstance(default, int | float | str) else None


def check_strategies(names: Iterable[str]) -> None:
    """Refuse unregistered strategies and families, which are code from files."""
    offered = (*OWN_STRATEGIES, *FAMILIES.names())
    for name in names:
        check_registered("strategies", name, offered)


def check_oracles(texts: Iterable[str]) -> None:
    """Refuse unregistered oracles, which are code from files."""
    for text in texts:
        if text.partition("=")[0].strip() not in ORACLES.names():
            raise InvalidParameter(
                "not-registered",
                "oracle {oracle!r} is not registered",
                "choose one of {known!l}",
                oracle=text[:40],
                known=list(ORACLES),
            )
