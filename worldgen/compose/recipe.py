"""Recipes: small TOML files that become families.

The provenance of every world holds the recipe's whole text and the ``.grid`` files that it reads,
so the world can be rebuilt from its own file. For larger maps and other formats, provenance holds
only the SHA-256 of their cells: the same file must be present to rebuild the world.
"""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

import numpy as np

from worldgen.compose.piece import Piece
from worldgen.compose.recipe_run import RecipeCells, RecipeRun
from worldgen.compose.recipe_text import MAX_BYTES, RecipeText, read_recipe, words_of
from worldgen.compose.sources import drawn, first_possible, of_world, read
from worldgen.compose.values import Scalar, is_drawn
from worldgen.compose.where import DRAWN
from worldgen.errors import FormatError, GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES, MARGIN, Bounds, Build, Family, family
from worldgen.files.grid import loads
from worldgen.interop.format.foreign_map import read_bounded
from worldgen.parameters import find_parameter
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, decide
from worldgen.world import Value, World

# Bump this whenever an existing recipe would make a different world.
VERSION = 1
_PLAIN = re.compile(r"[A-Za-z0-9_-]{1,60}\Z")
# Limit on the bytes of .grid files in provenance, which is part of every world's file.
_MOST_CARRIED = 256 << 10
_DIGEST = "sha256:"


def family_from_recipe(
    recipe: str | Path, *, folder: Path | None = None, files: Mapping[str, str] | None = None
) -> Family:
    """Create the family that a recipe describes, with the parameters that the recipe declares.

    Args:
        recipe: A path, or the text itself, which is recognised by its line breaks.
        folder: Folder of its ``file`` parts; defaults to the recipe's own folder, or to the
            working directory if ``recipe`` is text.
        files: Files stored in a world's provenance, by name: their text, or ``sha256:`` and their
            digest.

    Raises:
        FormatError: If the recipe cannot be read or breaks a rule; the error has the line.
    """
    source = None
    if isinstance(recipe, Path) or "\n" not in recipe:
        path = Path(recipe)
        source = str(path)
        folder = folder or path.parent
        try:
            text = read_bounded(path, MAX_BYTES).decode("utf-8")
        except UnicodeDecodeError as error:
            raise FormatError(
                "not-utf8",
                "is not UTF-8 text at byte {byte}",
                "save it as UTF-8",
                byte=error.start,
                source=source,
            ) from error
    else:
        text = recipe

    # Line endings must not matter, because the text becomes part of each world's provenance.
    text = text.replace("\r\n", "\n")
    read_text = read_recipe(text, source)
    _check_families(read_text, source)
    pieces, kept = _read_pieces(read_text, folder or Path(), dict(files or {}), source)
    constants: dict[str, Value] = {"recipe": text, "made_with": _versions(read_text)}
    if kept:
        constants["files"] = {**kept}
    try:
        made = family(f"recipe:{read_text.name}", version=read_text.version)(
            _builder(read_text, pieces)
        )
    # A parameter may have the name of an option that every family has.
    except InvalidParameter as error:
        raise FormatError.of(error.message, source=source) from error
    return replace(made, constants=constants, changes=_changes(read_text, pieces))


def _versions(recipe: RecipeText) -> dict[str, Value]:
    """Return the versions of the code that a recipe's worlds depend on, for provenance."""
    found: dict[str, Value] = {"compose": VERSION}
    for part in recipe.parts.values():
        if part.source == "family":
            found |= {name: FAMILIES.get(name).version for name in words_of(part.value)}
    return found


def _changes(recipe: RecipeText, pieces: Mapping[str, Piece]) -> bool:
    """Return True if a recipe's worlds may change over time."""
    families = [
        name
        for part in recipe.parts.values()
        if part.source == "family"
        for name in words_of(part.value)
    ]
    return any(FAMILIES.get(name).changes for name in families) or any(
        len(p.timeline) for p in pieces.values()
    )


def _check_families(recipe: RecipeText, source: str | None) -> None:
    """Reject unknown families, parameters they do not have, and values of the wrong type."""
    for part in recipe.parts.values():
        if part.source != "family":
            continue
        for name in words_of(part.value):
            try:
                # Other forms of a family's name load a Python file. A world from a stranger must
                # not run code when it is rebuilt.
                if not _PLAIN.match(name):
                    raise InvalidParameter(
                        "unknown-name",
                        "family={name!r} is not a registered family",
                        "register your own as a package (docs/reference/families.md)",
                        name=name[:60],
                    )
                for key, spec in part.params.items():
                    parameter = find_parameter(key, FAMILIES.get(name).parameters, name)
                    if isinstance(spec, bool | int | float | str):
                        parameter.accept(spec, name)
            except InvalidParameter as error:
                message = error.message.behind("{place}: ", place=part.place)
                raise FormatError.of(message, line=part.line, source=source) from error


def _read_pieces(
    recipe: RecipeText, folder: Path, given: dict[str, str], source: str | None
) -> tuple[dict[str, Piece], dict[str, str]]:
    """Read a recipe's drawings and files.

    Returns:
        The pieces by part name, and the text or digest of each file for provenance.
    """
    pieces: dict[str, Piece] = {}
    kept: dict[str, str] = {}
    for part in recipe.parts.values():
        text = str(part.value)
        try:
            if part.source == "rows":
                pieces[part.name] = drawn(text)
            elif part.source == "file":
                # A recipe may come from a stranger, so it must not read files outside its folder.
                pure = PurePosixPath(text)
                if pure.is_absolute() or ".." in pure.parts or "\\" in text or "\0" in text:
                    raise InvalidParameter(
                        "outside-folder",
                        "file={text!r} lies elsewhere",
                        "put it next to the recipe, or in a folder next to it",
                        text=text[:60],
                    )
                carried = sum(len(content) for name, content in kept.items() if name != text)
                pieces[part.name], kept[text] = _read_file(folder / text, given.get(text), carried)
        except (FormatError, InvalidParameter) as error:
            inner = f"{error.place}: " if isinstance(error, FormatError) and error.place else ""
            message = error.message.behind("{place}: {file}", place=part.place, file=inner)
            raise FormatError.of(message, line=part.line, source=source) from error
    return pieces, kept


def _read_file(path: Path, given: str | None, carried: int) -> tuple[Piece, str]:
    """Return a file's piece, and its entry in the provenance; ``given`` is an existing entry."""
    if given is not None and not given.startswith(_DIGEST):
        return of_world(loads(given.encode(), str(path))), given
    piece = read(path)
    digest = _DIGEST + _digest(piece)
    if given is not None and given != digest:
        raise InvalidParameter(
            "file-changed",
            "{path} has changed since the world was made from it",
            "restore the old file",
            path=path,
        )
    if given is None and path.suffix == ".grid":
        data = read_bounded(path)
        if carried + len(data) <= _MOST_CARRIED:
            return piece, data.decode("utf-8")
    return piece, digest


def _digest(piece: Piece) -> str:
    """Return the SHA-256 of a map's contents.

    Hashing the file itself would not do, because some formats keep their cells in a second file.
    """
    events = b"".join(column.tobytes() for column in piece.timeline.columns)
    settings = repr((piece.solid.shape, piece.cell_size, dict(piece.marks))).encode()
    return hashlib.sha256(np.packbits(piece.solid).tobytes() + events + settings).hexdigest()


def _builder(recipe: RecipeText, pieces: Mapping[str, Piece]) -> Build:
    """Return a function that lays out a world, with the recipe's parameters."""
    by_chance = _is_drawn(recipe)

    def build(rng: RandomStream, **values: Any) -> World:
        params: dict[str, Scalar] = {name: values[name] for name in recipe.parameters}
        work = RecipeCells()
        if not by_chance:
            margin = params.get(MARGIN, 0.0)
            return _only(
                recipe.name, RecipeRun(recipe, pieces, params, rng, work).piece().layout(), margin
            )
        return first_possible(
            lambda stream: RecipeRun(recipe, pieces, params, stream, work).piece().layout(), rng
        )

    # ``family`` reads parameters from a function's signature, annotations and docstring, so give
    # it those that a handwritten family would have.
    listed = recipe.parameters.items()
    rng = inspect.Parameter("rng", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    own = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=known.default)
        for name, known in listed
    ]
    build.__signature__ = inspect.Signature([rng, *own])  # type: ignore[attr-defined]
    build.__annotations__ = {
        name: Literal.__getitem__(known.choices)
        if known.choices
        else Annotated[type(known.default), Bounds(known.least, known.most)]
        for name, known in listed
    }
    notes = "\n".join(f"    {name}: {known.help}" for name, known in listed)
    build.__doc__ = f"{recipe.about}\n\nArgs:\n    rng: The only source of randomness.\n{notes}\n"
    return build


def _only(name: str, world: World, margin: Scalar) -> World:
    """Check the only world of a recipe without randomness.

    If this world cannot be solved, no other seed helps, so fail immediately with a message that
    explains it.

    Raises:
        GenerationFailed: If the world cannot be solved; the error carries the reason.
    """
    decision = decide(world, margin=float(margin))
    if decision.result != REACHABLE:
        raise GenerationFailed(
            "not-reachable",
            "recipe {name}: its world is {result}: {reason}; nothing in it is random, so no other "
            "seed helps: move a part, the start or the target",
            name=name,
            result=decision.result,
            reason=decision.reason,
        )
    return world


def _is_drawn(recipe: RecipeText) -> bool:
    """Return True if a recipe's worlds differ between seeds."""
    for part in recipe.parts.values():
        if part.source == "family" and "seed" not in part.options:
            return True
        specs = [part.value, *part.options.values(), *part.params.values()]
        for step in part.steps:
            specs += [step.value, *step.options.values()]
            if step.options.get("at") in DRAWN:
                return True
        if any(is_drawn(spec) for spec in specs):
            return True
    return False
