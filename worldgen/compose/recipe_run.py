"""Run a recipe: build its parts in order, each from a random stream that only it uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

from worldgen.compose.piece import Piece
from worldgen.compose.recipe_text import ROBOT, Part, RecipeText, Step
from worldgen.compose.sizes import TooLarge, check_size, whole
from worldgen.compose.sources import above, beside, of_family, rectangle, row_size
from worldgen.compose.values import Scalar, Spec, value_of
from worldgen.domain import MASK64, MAX_SIDE
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.family import FAMILIES, check_choice
from worldgen.random_streams import RandomStream

# Limit on the cells of all intermediate pieces together, so that a small file cannot keep the
# machine busy for hours.
MOST_WORK = 64_000_000
MOST_TIMES = 100  # repetitions of one step

OptionValues: TypeAlias = dict[str, Any]


@dataclass
class RecipeCells:
    """Count the cells that a recipe has made so far, and enforce ``MOST_WORK``."""

    cells: int = 0

    def check(self, cells: int) -> None:
        """Check that ``cells`` more are allowed, before building them.

        Raises:
            TooLarge: If the total would exceed ``MOST_WORK``.
        """
        if self.cells + cells > MOST_WORK:
            raise TooLarge(
                "too-large",
                "the recipe makes more than {most} cells along the way",
                "use smaller or fewer parts",
                most=MOST_WORK,
            )

    def spend(self, cells: int) -> None:
        """Add ``cells`` to the count.

        Raises:
            TooLarge: If the total would exceed ``MOST_WORK``.
        """
        self.check(cells)
        self.cells += cells


class RecipeRun:
    """Build one layout of a recipe.

    Args:
        recipe: The recipe to run.
        ready: Pieces of its drawings and files, by part name.
        params: Values of its parameters.
        rng: The only source of randomness.
        work: Cells made so far, including those of earlier attempts whose parts did not fit.
    """

    def __init__(
        self,
        recipe: RecipeText,
        ready: Mapping[str, Piece],
        params: Mapping[str, Scalar],
        rng: RandomStream,
        work: RecipeCells,
    ) -> None:
        self._recipe = recipe
        self._ready = ready
        self._params = params
        self._rng = rng
        self._work = work
        self._made: dict[str, Piece] = {}

    def piece(self) -> Piece:
        """Build the part that becomes the world, and give it the recipe's robot.

        Raises:
            InvalidParameter: If a value or a part does not fit; the message names its place.
            InvalidWorld: If there is no room for the robot.
            GenerationFailed: If a part with a fixed seed cannot be generated.
        """
        made = self._part(self._recipe.world)
        cell_size, radius, speed = (float(self._params[name]) for name in ROBOT)
        if made.cell_size is not None and made.cell_size != cell_size:
            raise InvalidParameter(
                "cell-sizes-differ",
                "the world's cells are {cell_size:g} m wide, but the parameter cell_size is "
                "{parameter:g} m",
                "write cell_size = {cell_size:g} under [parameters]",
                cell_size=made.cell_size,
                parameter=cell_size,
            )
        return made.for_robot(radius=radius, speed=speed, cell_size=cell_size)

    def _part(self, name: str) -> Piece:
        if name not in self._made:
            part = self._recipe.parts[name]
            rng = self._rng.child("part", name)
            with _at(part.place):
                piece = self._count(self._source(part, rng))
            for number, step in enumerate(part.steps):
                with _at(step.place):
                    piece = self._count(self._step(piece, step, rng.child("step", number)))
            self._made[name] = piece
        return self._made[name]

    def _count(self, piece: Piece) -> Piece:
        self._work.spend(piece.width * piece.height)
        return piece

    def _value(self, spec: Spec, rng: RandomStream, label: str) -> Any:
        return value_of(spec, self._params, rng.child(label))

    def _source(self, part: Part, rng: RandomStream) -> Piece:
        value = self._value(part.value, rng, part.source)
        options = {key: self._value(spec, rng, key) for key, spec in part.options.items()}
        if part.source == "family":
            return self._family(str(value), part, options.get("seed"), rng)
        if part.source in ("rows", "file"):
            return self._ready[part.name]
        if part.source == "box":
            width, height = _numbers(value, 2, "box")
            fill = options.get("fill", "free")
            check_choice("fill", fill, ("free", "solid"))
            return rectangle(width, height, solid=fill == "solid")
        if part.source == "part":
            return self._part(str(value))
        upwards = part.source == "above"
        pieces = [self._part(name) for name in value]
        width, height = row_size(pieces, options.get("gap", 0), upwards=upwards)
        # Placing each piece creates a copy of the whole row.
        self._work.spend(width * height * (len(pieces) - 1))
        return (above if upwards else beside)(pieces, **options)

    def _family(self, name: str, part: Part, seed: Any, rng: RandomStream) -> Piece:
        made_by = FAMILIES.get(name)
        known = made_by.defaults()
        params = {key: self._params[key] for key in ROBOT if key in known}
        for key, spec in part.params.items():
            value = self._value(spec, rng.child("params"), key)
            # TOML has separate integers and floats; accept 2 where a family expects 2.0.
            params[key] = (
                float(value) if type(known.get(key)) is float and type(value) is int else value
            )

        # ``size`` means cells per side in every family that has it, so a layout that is too large
        # can be refused before it is generated.
        side = params.get("size", known.get("size"))
        if type(side) is int and side > 0:
            check_size(f"{name} of size={side}", side, side)
            self._work.check(side * side)
        if seed is not None:
            return of_family(made_by, whole("seed", seed, 0, MASK64), **params)
        return of_family(made_by, rng.child("layout"), **params)

    def _step(self, piece: Piece, step: Step, rng: RandomStream) -> Piece:
        if step.verb == "place":
            return self._place(piece, step, rng)
        value = self._value(step.value, rng, step.verb)
        options = {key: self._value(spec, rng, key) for key, spec in step.options.items()}
        if step.verb == "mask":
            return piece.masked(self._part(str(value)))
        return _STEPS[step.verb](piece, value, options)

    def _place(self, piece: Piece, step: Step, rng: RandomStream) -> Piece:
        times = 1
        if "times" in step.options:
            times = whole("times", self._value(step.options["times"], rng, "times"), 0, MOST_TIMES)

        # Evaluate the options again for each repetition, so that each one is drawn independently.
        for time in range(times):
            draw = rng.child(time)
            options = {
                key: self._value(spec, draw, key)
                for key, spec in step.options.items()
                if key != "times"
            }
            at = options.get("at", [0, 0])
            options["at"] = at if isinstance(at, str) else _point(at, "at")
            if "margin" in options:
                whole("margin", options["margin"], 0, MAX_SIDE)
            if "anchor" in options:
                _word(options["anchor"], "anchor")
            part = self._part(str(self._value(step.value, draw, "place")))
            piece = self._count(piece.place(part, seed=draw.child("where"), **options))
        return piece


@contextmanager
def _at(place: str) -> Iterator[None]:
    """Prefix errors with the place in the recipe where they occur.

    Parts nest, so an error may pass several of these. Only the innermost adds its place, because it
    is the most precise.
    """
    try:
        yield
    except _Placed:
        raise
    except TooLarge as error:
        raise _PlacedTooLarge.of(error.message.behind("{place}: ", place=place)) from error
    except (InvalidParameter, InvalidWorld) as error:
        raise _Placed.of(error.message.behind("{place}: ", place=place)) from error
    except GenerationFailed as error:
        raise GenerationFailed.of(error.message.behind("{place}: ", place=place)) from error


class _Placed(InvalidParameter):
    """Carry an error whose message already names its place."""


class _PlacedTooLarge(_Placed, TooLarge):
    """Carry a ``TooLarge`` error whose message already names its place."""


def _numbers(value: Any, count: int, name: str) -> list[int]:
    if not isinstance(value, list) or len(value) != count:
        raise InvalidParameter(
            "wrong-form",
            "{name}={value!r} is not a list of {count} whole numbers",
            "write one",
            name=name,
            value=value,
            count=count,
        )
    return [whole(name, item, -MAX_SIDE, MAX_SIDE) for item in value]


def _point(value: Any, name: str) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InvalidParameter(
            "wrong-form",
            "{name}={value!r} is not a place",
            "write [x, y] in cells",
            name=name,
            value=value,
        )
    return value[0], value[1]


def _word(value: Any, name: str) -> str:
    if not isinstance(value, str):
        raise InvalidParameter(
            "wrong-type",
            "{name}={value!r} is not a word",
            "write one in quotes",
            name=name,
            value=value,
        )
    return value


def _pad(piece: Piece, value: Any, options: OptionValues) -> Piece:
    sides = (
        _numbers(value, 4, "pad")
        if isinstance(value, list)
        else [whole("pad", value, 0, MAX_SIDE)] * 4
    )
    return piece.pad(*sides, fill=options.get("with", "nothing"))


def _keep(piece: Piece, value: Any, options: OptionValues) -> Piece:
    check_choice("keep", value, ("walls", "floor"))
    return piece.walls() if value == "walls" else piece.floor()


def _dig(piece: Piece, value: Any, options: OptionValues) -> Piece:
    if "to" not in options:
        raise InvalidParameter(
            "missing-key",
            "a passage needs both ends, from and to",
            'write {{ dig = "a", to = [8, 3] }}',
        )
    ends = [end if isinstance(end, str) else _point(end, "dig") for end in (value, options["to"])]
    return piece.dig(ends[0], ends[1], width=options.get("width", 2))


def _mark(piece: Piece, value: Any, options: OptionValues) -> Piece:
    if "at" not in options:
        raise InvalidParameter("missing-key", "a mark is somewhere", "write at = [x, y]")
    return piece.with_mark(
        _word(value, "mark"), *_point(options["at"], "at"), degrees=options.get("degrees")
    )


def _trim(piece: Piece, value: Any, options: OptionValues) -> Piece:
    if value is not True:
        raise InvalidParameter(
            "no-effect", "trim={value!r} says nothing", "write trim = true, or omit it", value=value
        )
    return piece.trim()


def _tile(piece: Piece, value: Any, options: OptionValues) -> Piece:
    columns, rows = _numbers(value, 2, "tile")
    return piece.tile(columns, rows)


def _crop(piece: Piece, value: Any, options: OptionValues) -> Piece:
    x, y, width, height = _numbers(value, 4, "crop")
    return piece.crop(x, y, width, height)


def _forget(piece: Piece, value: Any, options: OptionValues) -> Piece:
    names = value if isinstance(value, list) else [value]
    for name in names:
        if _word(name, "forget") not in piece.marks:
            raise InvalidParameter(
                "unknown-name",
                "no mark is called {name!r}",
                "the part has {known!l:none}",
                name=name,
                known=list(piece.marks),
            )
    return piece.without_marks(*names)


_STEPS: dict[str, Callable[[Piece, Any, OptionValues], Piece]] = {
    "mirror": lambda piece, value, options: piece.mirror(value),
    "rotate": lambda piece, value, options: piece.rotate(value),
    "turn": lambda piece, value, options: piece.turn(value),
    "crop": _crop,
    "inside": lambda piece, value, options: piece.inside(value),
    "trim": _trim,
    "pad": _pad,
    "border": lambda piece, value, options: piece.border(whole("border", value, 0, MAX_SIDE)),
    "tile": _tile,
    "scale": lambda piece, value, options: piece.scale(value),
    "keep": _keep,
    "fill": lambda piece, value, options: piece.filled(value),
    "dig": _dig,
    "start": lambda piece, value, options: piece.with_start(
        *_point(value, "start"), degrees=options.get("degrees")
    ),
    "target": lambda piece, value, options: piece.with_target(
        *_point(value, "target"), radius=options.get("radius", 0.5)
    ),
    "mark": _mark,
    "forget": _forget,
}
