"""Read a recipe strictly: report the first error in one message that names its place."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from worldgen.compose.values import Choice, Scalar, Spec, spec_of
from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import MARGIN
from worldgen.files.grid.header import Header
from worldgen.parameters.known_names import unknown_name
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED

# Limit per recipe, whose text is stored in the header of every world that it makes.
MAX_BYTES = 64 << 10
# MAX_STEPS is the limit for all parts together.
MAX_PARAMETERS = 50
MAX_PARTS = 64
MAX_STEPS = 256
_NAME = re.compile(r"[a-z][a-z0-9-]{0,39}\Z")
_PARAMETER = re.compile(r"[a-z][a-z0-9_]{0,39}\Z")

ROBOT: dict[str, tuple[float, str]] = {
    "cell_size": (DEFAULT_CELL_SIZE, "Side of a cell, m."),
    "robot_radius": (DEFAULT_ROBOT_RADIUS, "Radius of the robot, m."),
    "robot_speed": (DEFAULT_ROBOT_SPEED, "Top speed of the robot, m/s."),
}
# Names that provenance already uses next to the parameters.
_RESERVED = ("recipe", "files", "made_with")
_NOTES = {
    MARGIN: "How much later the robot may start on its witness, s.",
    **{name: note for name, (_, note) in ROBOT.items()},
}
_TOP = ("recipe", "version", "about", "world", "parameters", "part")
_DECLARED = ("default", "least", "most", "choices", "help")

# Sources of a part, each with the other keys that it allows in the part's table.
SOURCES: dict[str, tuple[str, ...]] = {
    "family": ("params", "seed"),
    "rows": (),
    "file": (),
    "box": ("fill",),
    "part": (),
    "beside": ("gap", "align", "join"),
    "above": ("gap", "align", "join"),
}
# Verbs of a step, each with the other keys that it allows in the step's table.
VERBS: dict[str, tuple[str, ...]] = {
    "place": ("at", "anchor", "how", "outside", "start", "target", "margin", "times"),
    "mirror": (),
    "rotate": (),
    "turn": (),
    "crop": (),
    "inside": (),
    "trim": (),
    "pad": ("with",),
    "border": (),
    "tile": (),
    "scale": (),
    "mask": (),
    "keep": (),
    "fill": (),
    "dig": ("to", "width"),
    "start": ("degrees",),
    "target": ("radius",),
    "mark": ("at", "degrees"),
    "forget": (),
}
# Verbs whose value is the name of a part.
NAMING_PARTS = ("place", "mask")


@dataclass(frozen=True)
class Declared:
    """Describe one parameter that the recipe declares."""

    default: Scalar
    least: float | None = None
    most: float | None = None
    choices: tuple[str, ...] = ()
    help: str = "A parameter of the recipe."


@dataclass(frozen=True)
class Step:
    """Describe one step of a part: its verb, the verb's value and its options."""

    verb: str
    value: Spec
    options: Mapping[str, Spec]
    place: str


@dataclass(frozen=True)
class Part:
    """Describe a part: its source, and the steps that are applied to it."""

    name: str
    source: str
    value: Spec
    options: Mapping[str, Spec]
    params: Mapping[str, Spec]
    steps: tuple[Step, ...]
    place: str
    line: int

    def uses(self) -> Iterator[str]:
        """Return the names of the parts that this part is made of."""
        named = [step.value for step in self.steps if step.verb in NAMING_PARTS]
        if self.source in ("part", "beside", "above"):
            named.append(self.value)
        for value in named:
            yield from words_of(value)


def words_of(value: Spec) -> tuple[str, ...]:
    """Return every word that a value can evaluate to.

    These are the word itself, the items of a list, or the options of a choice.

    Raises:
        InvalidParameter: If the value can be something other than a word.
    """
    items = (
        value.options
        if isinstance(value, Choice)
        else value
        if isinstance(value, tuple)
        else (value,)
    )
    if not items or not all(isinstance(item, str) for item in items):
        raise InvalidParameter(
            "wrong-type",
            "names are words in quotes, or {{ any = [...] }} with such words",
            "write one",
        )
    return tuple(str(item) for item in items)


@dataclass(frozen=True)
class RecipeText:
    """A recipe as its author wrote it, parsed but not yet built."""

    name: str
    version: int
    about: str
    world: str
    parameters: Mapping[str, Declared]
    parts: Mapping[str, Part] = field(default_factory=dict)


class _RecipeReader:
    """Read a recipe's TOML, and find the line of a key for error messages."""

    def __init__(self, text: str, source: str | None) -> None:
        self.header = Header(text, 1, source, noun="the recipe")
        self.source = source

    def line(self, part: int | None, *path: str) -> int:
        """Return the line of a key, which is in the n-th ``[[part]]`` unless ``part`` is None."""
        if part is None:
            return self.header.line_of(*path)
        return self.header.line_in_item("part", part, *path)

    @contextmanager
    def at(self, place: str, part: int | None, *path: str) -> Iterator[None]:
        """Turn a wrong value inside into a ``FormatError`` with its place and line."""
        try:
            yield
        except InvalidParameter as error:
            message = error.message.behind("{place}: ", place=place) if place else error.message
            raise FormatError.of(
                message, line=self.line(part, *path), source=self.source
            ) from error


def _known_keys(table: Mapping[str, Any], known: Sequence[str]) -> None:
    for key in table:
        if key not in known:
            raise InvalidParameter.of(unknown_name("no key is called {name!q}", key, known))


def read_recipe(text: str, source: str | None = None) -> RecipeText:
    """Read a recipe, and check everything that can be checked without building a part.

    Args:
        text: The recipe, as TOML.
        source: File name for error messages.

    Raises:
        FormatError: If the recipe breaks a rule; it has the line and place of the first error.
    """
    # Check the size before parsing, so that a huge file costs no time.
    if len(text.encode("utf-8", "surrogatepass")) > MAX_BYTES:
        raise FormatError(
            "too-large",
            "a recipe has at most {most} bytes",
            "put maps into files",
            most=MAX_BYTES,
            source=source,
        )
    reader = _RecipeReader(text, source)
    data = reader.header.data
    with reader.at("", None):
        _known_keys(data, _TOP)
        parts_table = data.get("part", [])
        if not isinstance(parts_table, list) or not all(
            isinstance(table, Mapping) for table in parts_table
        ):
            raise InvalidParameter(
                "wrong-type", "a recipe's parts are tables", "begin each with [[part]]"
            )
        if not parts_table:
            raise InvalidParameter("empty", "there is no part", "begin one with [[part]]")
        if len(parts_table) > MAX_PARTS:
            raise InvalidParameter(
                "too-large",
                "{parts} parts; the limit is {most}",
                "split the recipe",
                parts=len(parts_table),
                most=MAX_PARTS,
            )

    # Check the recipe's own keys. Parts come later because their formulas may use any parameter.
    name = data.get("recipe")
    about = data.get("about", "A world made by a recipe.")
    with reader.at("recipe", None, "recipe"):
        if not isinstance(name, str) or _NAME.match(name) is None:
            raise InvalidParameter(
                "not-a-name",
                "{name!q} is not a name",
                'write recipe = "my-recipe", in small letters, digits and -',
                name=name,
            )
    with reader.at("version", None, "version"):
        version = _whole(data.get("version", 1), 1)
    with reader.at("about", None, "about"):
        if not isinstance(about, str):
            raise InvalidParameter(
                "wrong-type", "{about!q} is not text", "write a sentence in quotes", about=about
            )

    # Read parameters and parts, then the name of the part that becomes the world.
    parameters = _read_parameters(reader, data.get("parameters", {}))
    parts = _read_parts(reader, data["part"], tuple(parameters))
    world = data.get("world", next(reversed(parts)))
    with reader.at("world", None, "world"):
        if not isinstance(world, str) or world not in parts:
            raise InvalidParameter(
                "unknown-name",
                "no part is called {name!q}; there are {known!l}",
                "name one of these, or omit it for the last part",
                name=world,
                known=list(parts),
            )
    return RecipeText(name, version, " ".join(about.split()), world, parameters, parts)


def _whole(value: object, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value < 2**31:
        raise InvalidParameter(
            "not-a-number",
            "{value!q} is not a whole number of at least {least}",
            "write one",
            value=value,
            least=least,
        )
    return value


def _read_parameters(reader: _RecipeReader, table: Any) -> dict[str, Declared]:
    found = {name: Declared(default, help=note) for name, (default, note) in ROBOT.items()}
    with reader.at("parameters", None, "parameters"):
        if not isinstance(table, Mapping):
            raise InvalidParameter(
                "wrong-type", "{value!q} is not a table", "write [parameters]", value=table
            )
        if len(table) > MAX_PARAMETERS:
            raise InvalidParameter(
                "too-large",
                "{parameters} parameters; the limit is {most}",
                "leave some out",
                parameters=len(table),
                most=MAX_PARAMETERS,
            )
    # Check each parameter's name, then its declaration.
    own: dict[str, Declared] = {}
    for name, raw in table.items():
        with reader.at(f"parameters.{name}", None, "parameters", name):
            if _PARAMETER.match(name) is None or keyword.iskeyword(name) or name == "rng":
                raise InvalidParameter(
                    "not-a-name",
                    "is not a name",
                    "use small letters, digits and _, but not rng or a Python keyword such as for",
                )
            if name in _RESERVED:
                raise InvalidParameter(
                    "reserved-name",
                    "is reserved for provenance, like {known!l}",
                    "take another",
                    known=list(_RESERVED),
                )
            own[name] = _declared(raw)
            # Families read the robot and the margin as floats, and have help texts for them.
            if name in ROBOT or name == MARGIN:
                default = own[name].default
                if isinstance(default, bool | str):
                    raise InvalidParameter(
                        "not-a-number",
                        "default={default!q} is not a number",
                        "write one",
                        default=default,
                    )
                note = (
                    own[name].help if isinstance(raw, Mapping) and "help" in raw else _NOTES[name]
                )
                own[name] = replace(own[name], default=float(default), help=note)
    return {**own, **{name: known for name, known in found.items() if name not in own}}


def _declared(raw: Any) -> Declared:
    # ``size = 20`` is short for ``size = { default = 20 }``.
    if not isinstance(raw, Mapping):
        raw = {"default": raw}
    _known_keys(raw, _DECLARED)
    default = raw.get("default")
    least = raw.get("least")
    most = raw.get("most")
    choices = raw.get("choices", [])
    note = raw.get("help", "A parameter of the recipe.")
    if not isinstance(default, bool | int | float | str):
        raise InvalidParameter(
            "wrong-type",
            "default={default!q} is not a number, a text, true or false",
            "write one",
            default=default,
        )
    if not isinstance(note, str):
        raise InvalidParameter(
            "wrong-type", "help={help!q} is not text", "write a sentence in quotes", help=note
        )
    if not isinstance(choices, list) or not all(isinstance(word, str) for word in choices):
        raise InvalidParameter(
            "wrong-type", "choices must be a list of strings", 'write choices = ["U", "V"]'
        )
    if choices and default not in choices:
        raise InvalidParameter(
            "unknown-name",
            "default={default!q} is not one of its choices",
            "write one of them",
            default=default,
        )

    # Bounds need numbers, and the default must satisfy them. A bool is an int in Python, so it is
    # excluded by its exact type.
    for name, value in (("least", least), ("most", most)):
        if value is not None:
            numeric = type(value) in (int, float) and type(default) in (int, float)
            if not numeric:
                raise InvalidParameter(
                    "wrong-type",
                    "{name}={value!q} goes with numbers",
                    "omit it, or make it and the default numbers",
                    name=name,
                    value=value,
                )
    if isinstance(default, int | float) and not isinstance(default, bool):
        low = float("-inf") if least is None else least
        high = float("inf") if most is None else most
        if not low <= default <= high:
            raise InvalidParameter(
                "out-of-range",
                "default={default} is not between least and most",
                "write one that is",
                default=default,
            )
    return Declared(
        default, least, most, tuple(choices), " ".join(note.split()) or "A parameter of the recipe."
    )


def _read_parts(reader: _RecipeReader, raw: list[Any], names: Sequence[str]) -> dict[str, Part]:
    parts: dict[str, Part] = {}
    steps = 0
    for number, table in enumerate(raw):
        with reader.at(f"part {number + 1}", number, "name"):
            name = table.get("name")
            if not isinstance(name, str) or _NAME.match(name) is None:
                raise InvalidParameter(
                    "not-a-name",
                    "name={name!q} is not a name",
                    'write name = "my-part", in small letters, digits and -',
                    name=name,
                )
            if name in parts:
                raise InvalidParameter(
                    "twice",
                    "name={name!q} is already an earlier part's",
                    "choose another",
                    name=name,
                )
        part = _read_part(reader, number, name, table, names)
        steps += len(part.steps)
        with reader.at(part.place, number):
            if steps > MAX_STEPS:
                raise InvalidParameter(
                    "too-large",
                    "more than {most} steps in total",
                    "split the recipe",
                    most=MAX_STEPS,
                )
            for used in part.uses():
                if used not in parts:
                    raise InvalidParameter(
                        "unknown-name",
                        "no earlier part is called {name!q}",
                        "there are: {known!l:none}",
                        name=used,
                        known=list(parts),
                    )
        parts[part.name] = part
    return parts


def _read_part(
    reader: _RecipeReader, number: int, name: str, table: Mapping[str, Any], names: Sequence[str]
) -> Part:
    # Check the table's shape: exactly one source, and no key that the source does not allow.
    place = f"part {name!r}"
    with reader.at(place, number):
        sources = [key for key in SOURCES if key in table]
        if len(sources) != 1:
            raise InvalidParameter(
                "wrong-count",
                "is made of {made_of}",
                "use only one of {known!l}",
                made_of=" and ".join(sources) or "nothing",
                known=list(SOURCES),
            )
        source = sources[0]
        _known_keys(table, ("name", source, *SOURCES[source], "steps"))
        params = table.get("params", {})
        if not isinstance(params, Mapping):
            raise InvalidParameter(
                "wrong-type",
                "params={params!q} is not a table",
                "write params = {{ size = 20 }}",
                params=params,
            )
        if not isinstance(table.get("steps", []), list):
            raise InvalidParameter(
                "wrong-type", "steps must be a list", "write steps = [ {{ rotate = 1 }} ]"
            )

    # Parse the source's value. Here, names of families and parts only have to be words. The caller
    # knows the earlier parts, and checks that those names exist.
    with reader.at(f"{place}, {source}", number, source):
        value = spec_of(table[source], names)
        if source in ("beside", "above"):
            is_list = (
                isinstance(value, tuple) and value and all(isinstance(item, str) for item in value)
            )
            if not is_list:
                raise InvalidParameter(
                    "wrong-type", "is a list of parts", 'write {source} = ["a", "b"]', source=source
                )
        elif source in ("family", "part"):
            if isinstance(value, tuple):
                raise InvalidParameter(
                    "wrong-type",
                    "is one word",
                    "to draw one write {source} = {{ any = [...] }}",
                    source=source,
                )
            words_of(value)
        elif source != "box" and not isinstance(value, str):
            raise InvalidParameter(
                "wrong-type", "{value!q} is not text", "write one in quotes", value=table[source]
            )

    # Parse options, family parameters and steps, each under its own place.
    options = {}
    chosen = {}
    for key in SOURCES[source]:
        if key in table and key != "params":
            with reader.at(f"{place}, {key}", number, key):
                options[key] = spec_of(table[key], names)
    for key, raw in params.items():
        with reader.at(f"{place}, params.{key}", number, "params", key):
            chosen[key] = spec_of(raw, names)
    steps = []
    for index, raw in enumerate(table.get("steps", [])):
        with reader.at(f"{place}, step {index + 1}", number, "steps"):
            steps.append(_read_step(raw, f"{place}, step {index + 1}", names))
    return Part(
        name, source, value, options, chosen, tuple(steps), place, reader.line(number, source)
    )


def _read_step(raw: object, place: str, names: Sequence[str]) -> Step:
    if not isinstance(raw, Mapping):
        raise InvalidParameter(
            "wrong-type", "{value!q} is not a table", "write {{ rotate = 1 }}", value=raw
        )
    verbs = [key for key in raw if key in VERBS]
    # ``start`` and ``target`` are verbs, but next to ``place`` they are its options.
    if len(verbs) > 1:
        verbs = [
            verb
            for verb in verbs
            if not any(verb in VERBS[other] for other in verbs if other != verb)
        ]
    if len(verbs) != 1:
        said = " and ".join(verbs) or ", ".join(str(key)[:40] for key in raw) or "nothing"
        raise InvalidParameter(
            "unknown-name",
            "says {said}",
            "a step does one of {known!l}",
            said=said,
            known=list(VERBS),
        )
    verb = verbs[0]
    _known_keys(raw, (verb, *VERBS[verb]))
    value = spec_of(raw[verb], names)
    if verb in NAMING_PARTS:
        if isinstance(value, tuple):
            raise InvalidParameter(
                "wrong-type", "{verb} is one part", "to draw one write {{ any = [...] }}", verb=verb
            )
        words_of(value)
    options = {key: spec_of(raw[key], names) for key in VERBS[verb] if key in raw}
    return Step(verb, value, options, f"{place} ({verb})")
