"""Hypothesis strategies for worlds, per family and combined, and strategies for scenarios.

A scenario is a world and the run in it. The strategies draw structure, never raw cells: a family's
parameters and seed, or the bytes of a feature layout (:mod:`fuzz.layouts.features`). Everything
shrinks towards small worlds with few, straight walls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from hypothesis import reject
from hypothesis import strategies as st

from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.layouts.variation import Variation, applied
from sim.scenario import Scenario
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.family import FAMILIES, ROBOTS, ROBOTS_PARAMETER, Parameter
from worldgen.generation import generate
from worldgen.parameters import find_parameter
from worldgen.plugins.trust import admit_argument
from worldgen.reach import REACHABLE, decide
from worldgen.world import Value, Witness, World


def layouts() -> st.SearchStrategy[bytes]:
    """Draw the byte strings that :func:`fuzz.layouts.features.decode_world` turns into worlds.

    Each is a single Hypothesis choice, which keeps drawing fast.
    """
    return st.binary(min_size=LAYOUT_BYTES, max_size=LAYOUT_BYTES)


@st.composite
def feature_worlds(draw: st.DrawFn, *, robot_radius: float = 0.07) -> World:
    """Draw arenas with a few walls, cups, corners, gates, diagonals and combs.

    The target is reachable, and the world carries a witness of that.
    """
    world = decode_world(draw(layouts()), robot_radius=robot_radius)
    decision = decide(world)
    if decision.result != REACHABLE:
        reject()
    return replace(world, certificate=decision.certificate)


@st.composite
def family_worlds(draw: st.DrawFn, /, family: str, **fixed: Value) -> World:
    """Draw worlds of one family with varied parameters; parameters given by name stay fixed.

    Raises:
        InvalidParameter: If the family or a parameter is unknown.
    """
    # Parameters that are neither fixed nor in the table below keep the family's defaults.
    made_by = FAMILIES.get(family)
    known = (*made_by.all_parameters, *made_by.robot_parameters)
    for name in sorted(fixed):
        find_parameter(name, known, family)
    robots = ROBOTS_PARAMETER.accept(fixed.get(ROBOTS, 1), family)
    drawn: dict[str, Value] = {}
    for parameter in made_by.parameters:
        choices = _choices(family, parameter, robots)
        if parameter.name not in fixed and choices is not None:
            drawn[parameter.name] = draw(choices)
    seed = draw(st.integers(0, 2**32 - 1))
    while True:
        try:
            return generate(made_by, seed, **{**drawn, **fixed})
        except GenerationFailed:
            reject()
        except InvalidParameter:
            # The drawn parameters contradict each other: reset the last one to its default.
            if not drawn:
                reject()
            drawn.popitem()


def worlds(family: str | None = None, **fixed: Value) -> st.SearchStrategy[World]:
    """Draw reachable worlds with a witness.

    Args:
        family: Name of a family; ``None`` draws feature layouts and all registered families.
        **fixed: Parameters of that family that should not be drawn.
    """
    if family is not None:
        admit_argument(family)
        return family_worlds(family, **fixed)
    if fixed:
        raise InvalidParameter(
            "no-family-named",
            "{names!l}: name the family that has these parameters",
            names=list(fixed),
        )
    alone = [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
    return st.one_of(feature_worlds(), *map(family_worlds, alone))


def scenarios(
    controller: str,
    *,
    motion: str = "swept",
    family: str | None = None,
    vary: Mapping[str, Sequence[Value]] | None = None,
) -> st.SearchStrategy[tuple[World, Scenario]]:
    """Draw complete scenarios: a reachable world with its witness, and the run in it with its seed.

    Args:
        controller: Name, optionally with variations: ``bug1``, ``thesis-1+noise``.
        motion: Motion model.
        family: Family of the worlds; feature layouts and all registered families if omitted.
        vary: Values of ``robot_radius`` (m), ``robot_speed`` (m/s), ``time_step`` (s) and of the
            motion model's options, the simplest first: ``{"sensor_noise": [0.0, 0.1]}``.

    Raises:
        InvalidParameter: If a name is unknown or a value out of range.

    Example:
        >>> scenarios("turn-right", vary={"robot_radius": [0.07, 0.05]})
    """
    base = Scenario.parse(controller, motion=motion)
    varied = tuple(
        Variation.parse(f"{name}={','.join(map(_written, values))}", base)
        for name, values in (vary or {}).items()
    )
    return (
        scenarios_in(worlds(family), base, (base.run.time_step,), varied)
        .map(_provably_reachable)
        .filter(_is_reachable)
    )


def scenarios_in(
    where: st.SearchStrategy[World],
    base: Scenario,
    time_steps: Sequence[float],
    vary: Sequence[Variation],
) -> st.SearchStrategy[tuple[World, Scenario]]:
    """Draw scenarios in given worlds.

    A world whose robot's size or speed is drawn loses its certificate, which no longer applies.

    Args:
        where: The worlds.
        base: The scenario, except for its seed, its time step and whatever is varied.
        time_steps: Time steps to draw from, s.
        vary: Further options to draw.
    """

    def scenario(
        world: World, seed: int, time_step: float, *values: Value
    ) -> tuple[World, Scenario]:
        drawn = {one.name: value for one, value in zip(vary, values, strict=True)}
        try:
            return applied(drawn, world, base.with_run(seed=seed, time_step=time_step))
        except InvalidWorld:  # the drawn robot does not fit at the start
            reject()

    values = (st.sampled_from(one.values) for one in vary)
    return st.builds(
        scenario, where, st.integers(0, 2**32 - 1), st.sampled_from(tuple(time_steps)), *values
    )


def _provably_reachable(drawn: tuple[World, Scenario]) -> tuple[World, Scenario]:
    world, scenario = drawn
    return (
        world if world.certificate else replace(world, certificate=decide(world).certificate)
    ), scenario


def _is_reachable(drawn: tuple[World, Scenario]) -> bool:
    return isinstance(drawn[0].certificate, Witness)


def _written(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _choices(family: str, parameter: Parameter, robots: int) -> st.SearchStrategy[Any] | None:
    """Return values to draw a parameter from, simplest first; ``None`` keeps its default."""
    if parameter.choices:
        return st.sampled_from(parameter.choices)
    if parameter.name == "size":
        # A world for many robots grows with them. With at most 30 cells a side, proving that 30
        # robots can pass each other in a maze took 37 s per world instead of 0.3 s.
        least = max(14, math.ceil(7 * math.sqrt(robots)))
        return st.integers(least, least + 16)
    varied = _VARIED.get(family, {}).get(parameter.name)
    return None if varied is None else st.sampled_from(varied)


# Static families on which worlds that change over time are built.
_STILL = ("maze", "corridor", "trap", "rooms", "cave", "forest", "rubble")

# Parameters drawn in addition to the size, the seed and enumerated ones; simplest values first.
_VARIED: dict[str, dict[str, tuple[Value, ...]]] = {
    "corridor": {"width": (2, 3, 4, 5), "wall": (1, 2), "necks": (0, 1, 3)},
    "fire": {"over": _STILL, "spread": (0.15, 0.3, 0.6), "monotone": (False, True)},
    "forest": {"gap": (2.0, 1.2, 1.0)},
    "maze": {"braid": (0.0, 0.5, 1.0), "passage": (2, 3, 4), "wall": (1, 2), "rooms": (0, 2)},
    "rooms": {"closed": (0.0, 0.5)},
    "rubble": {"debris": (0.1, 0.35, 0.6)},
    "shift": {"over": _STILL},
    "trap": {
        "turn": (0, 1, 2, 3),
        "thickness": (1, 2),
        "angle": (0, 15, 30, 45, 70),
        "inside": (False, True),
    },
}
