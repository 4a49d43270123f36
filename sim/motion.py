"""Motion models: the record that describes one, and the table of all of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sim._core import lib
from worldgen.errors import InvalidParameter
from worldgen.parameters.known_names import unknown_name


@dataclass(frozen=True)
class Motion:
    """A motion model: how commanded motion becomes displacement.

    Args:
        name: Its name on the command line.
        version: Increases when equal scenarios no longer give equal traces; failures record it.
        overlap_tolerance: How far the disc may cut into a wall, in cells, before that is reported
            as ``overlap``.
        summary: One line for people.
        exact_events: Whether events happen at their time within a step; otherwise they happen at
            the beginning of that step.
        code: The core's number for it, on the pose lattice.
        on_lattice: Whether poses are on the lattice, and any controller runs. Otherwise they are in
            float64 pixels, and the thesis's simulator runs its own robots.
    """

    name: str
    version: int
    overlap_tolerance: float
    summary: str
    exact_events: bool = False
    code: int = 0
    on_lattice: bool = True


class Motions:
    """The motion models, by name.

    Each has its own simulator in C, so users cannot add one.

    Args:
        *models: All of them.
    """

    def __init__(self, *models: Motion) -> None:
        self._models = {model.name: model for model in models}

    def names(self) -> list[str]:
        """Return the names of the models, sorted."""
        return sorted(self._models)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def get(self, name: str) -> Motion:
        """Return the motion model with that name.

        Raises:
            InvalidParameter: If there is no such model.
        """
        if name in self._models:
            return self._models[name]
        raise InvalidParameter.of(
            unknown_name("no motion model is called {name!r}", name, self.names())
        )


MOTIONS = Motions(
    # Exact time of impact and sliding on the pose lattice: no controller can tunnel.
    Motion(
        "swept",
        version=3,
        code=lib.WG_SWEPT,
        overlap_tolerance=0.0,
        exact_events=True,
        summary="exact: the disc stops at walls and slides along them; it cannot tunnel",
    ),
    # Like most small simulators, it checks only where a step ends. Between two clear ends, a short
    # step can shave a corner by its sagitta: 0.016 cell at 0.3 cell a step and radius 0.7. A
    # tolerance of a tenth of a cell leaves that unreported.
    Motion(
        "endpoint",
        version=2,
        code=lib.WG_ENDPOINT,
        overlap_tolerance=0.1,
        summary="checks only the end of each step: fast robots tunnel",
    ),
    # The thesis's motion in steps of one pixel, a tenth of a cell, including its faults. A robot
    # that it considers touching may be up to half a pixel inside the wall (its corner case).
    Motion(
        "stepped",
        version=1,
        on_lattice=False,
        overlap_tolerance=0.1,
        summary="the thesis's one-pixel stepping, including its faults; runs the thesis's robots",
    ),
)
