"""The ground of a world that changes: a world of another family, its shape drawn."""

from __future__ import annotations

import re
from itertools import product

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import Arena
from worldgen.family import FAMILIES, Family, Parameter
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

__all__ = ["lay_ground"]

MAZE_BRAID = 0.3  # in a maze without loops, a change could only delay

# Words that are drawn, where not all are: those that came later would move every seed to another world.
DRAWN: dict[str, dict[str, tuple[str, ...]]] = {
    "maze": {"algorithm": ("wilson", "backtracker"), "mask": ("square",)},
    "corridor": {"shape": ("bends", "dead-ends", "junctions")},
    "trap": {"shape": ("U", "L", "spiral")},
}

# ``./a+b/mine.py:own+width=3`` ends in one setting; a ``+`` in a folder's name begins none.
_SETTING = r"\+[A-Za-z][A-Za-z0-9_-]*(?:=[^+/\\]*)?"
_OVER = re.compile(rf"(?P<name>.+?)(?P<settings>(?:{_SETTING})*)", re.DOTALL)


def lay_ground(rng: RandomStream, over: str, arena: Arena) -> World:
    """A world of the family that ``over`` names, its words drawn from those that fit.

    Args:
        rng: The only source of chance.
        over: Name of a family whose worlds stand still, then ``+parameter=value`` as often as wanted.
        arena: What both families share; a family that lacks one of these parameters keeps its own way.

    Raises:
        InvalidParameter: If there is no such family, it changes by itself, a setting is wrong, or no word fits.
    """
    below, given = _parse(over)
    shared: dict[str, Value] = {
        "size": arena.size,
        "cell_size": arena.cell_size,
        "robot_radius": arena.robot_radius,
        "robot_speed": arena.robot_speed,
    }
    for name in given:
        if name in shared:
            raise InvalidParameter(
                "not-of-the-ground",
                "over={over}: {name} is the whole world's",
                "give it as a parameter of its own",
                over=over,
                name=name,
            )
    if below.name == "maze":
        given.setdefault("braid", MAZE_BRAID)
    params = {name: value for name, value in shared.items() if name in below.defaults()} | given
    drawn = DRAWN.get(below.name, {})
    words_of = {
        known.name: drawn.get(known.name, known.choices)
        for known in below.parameters
        if known.choices and known.name not in given
    }
    names, shapes = list(words_of), list(product(*words_of.values()))
    rng.shuffle(shapes)
    refusals: list[InvalidParameter] = []
    for words in shapes:
        complete = below.complete({**params, **dict(zip(names, words, strict=True))})
        try:
            ground = below.build(rng.child("layout"), **complete)
        except InvalidParameter as refusal:
            refusals.append(refusal)
            continue
        return _still(ground, over)
    raise InvalidParameter(
        "no-room",
        "size={size} with robot_radius={robot_radius:g} m has no room for over={over}",
        "give a larger size or a smaller robot_radius (for one of its shapes: {refusal})",
        size=arena.size,
        robot_radius=arena.robot_radius,
        over=over,
        refusal=refusals[0],
    )


def _parse(over: str) -> tuple[Family, dict[str, Value]]:
    """The family and its parameters as given."""
    parts = _OVER.fullmatch(over.strip())
    if parts is None:
        raise InvalidParameter(
            "missing", "over={over!r} names no family", "give one, such as maze, or maze+algorithm=eller", over=over
        )
    below = FAMILIES.get(parts["name"])
    if below.changes:
        raise InvalidParameter(
            "world-changes",
            "over={over}: {family} changes by itself",
            "give one of {known!l}",
            over=over,
            family=below.name,
            known=[name for name in FAMILIES if not FAMILIES.get(name).changes],
        )
    known = {parameter.name: parameter for parameter in below.parameters}
    given: dict[str, Value] = {}
    for setting in re.findall(_SETTING, parts["settings"]):
        word, equals, text = setting[1:].partition("=")
        name = word.replace("-", "_")
        if name not in known:
            raise InvalidParameter(
                "unknown-name",
                "over={over}: {family} has no parameter {parameter!r}",
                "it has {known!l}",
                over=over,
                family=below.name,
                parameter=name,
                known=list(known),
            )
        given[name] = _value(known[name], text.strip() if equals else None, over)
    return below, given


def _value(parameter: Parameter, text: str | None, over: str) -> Value:
    """The value of one setting as written; a switch needs none."""
    kind = type(parameter.default)
    words = {"true": True, "false": False} if kind is bool else {}
    if text is None and kind is bool:
        return True
    try:
        if not text:
            raise ValueError
        value: Value = words[text.lower()] if words else kind(text)
    except (ValueError, KeyError):
        what = "true or false" if kind is bool else {int: "a whole number", float: "a number"}.get(kind, "a word")
        shown = parameter.name if text is None else f"{parameter.name}={text}"
        raise InvalidParameter(
            "wrong-type",
            "over={over}: {given} is not {expected}",
            "write +{name}=VALUE",
            over=over,
            given=shown,
            expected=what,
            name=parameter.name,
        ) from None
    return parameter.accept(value, over)


def _still(ground: World, over: str) -> World:
    """The ground, if it stands still."""
    if ground.is_dynamic:
        raise InvalidParameter(
            "world-changes",
            "over={over}: its worlds change by themselves",
            "give a family whose worlds stand still, and say changes=True where this one is declared",
            over=over,
        )
    return ground
