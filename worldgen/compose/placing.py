"""Place one piece on another: find its position, then combine the two."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from worldgen.compose.cells import Events, How, PlacedCells, put_together, state_of_two, timeline_of
from worldgen.compose.marks import HALF, START, TARGET, Mark, mark_at, marks_of, moved
from worldgen.compose.sizes import whole
from worldgen.compose.where import DRAWN, NAMED, draw_corner, named_corner
from worldgen.compose.world import usual, witness_path_of
from worldgen.domain import MAX_SIDE
from worldgen.errors import InvalidParameter
from worldgen.family import check_choice
from worldgen.lattice import in_cells
from worldgen.random_streams import RandomStream
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_RADIUS

if TYPE_CHECKING:
    from worldgen.compose.piece import Piece


def corner_of(
    host: Piece,
    piece: Piece,
    at: tuple[float, float] | str,
    anchor: str | None,
    margin: int,
    seed: int | RandomStream | None,
) -> tuple[int, int]:
    """Return the host cell where the lower left cell of a piece goes.

    Args:
        host: The piece to place on.
        piece: The piece to place.
        at: As in ``Piece.place``.
        anchor: As in ``Piece.place``.
        margin: Minimum number of cells between the piece and the host's sides, for named and drawn
        places.
        seed: Seed of a drawn place.

    Raises:
        InvalidParameter: If a word is unknown, arguments conflict, or the piece fits nowhere.
        InvalidWorld: If the place is drawn along a path and the host has no path.
    """
    whole("margin", margin, 0, MAX_SIDE)
    sizes = (host.width, host.height), (piece.width, piece.height)
    if not isinstance(at, str):
        x, y = at
        if anchor is None:
            return whole("at x", x, -MAX_SIDE, MAX_SIDE), whole("at y", y, -MAX_SIDE, MAX_SIDE)
        return _anchored(piece, mark_at(x, y), anchor)
    # A named place wins over a mark of the same name, so a word has one meaning on every host.
    if at in host.marks and at not in (*NAMED, *DRAWN):
        return _anchored(piece, host.marks[at], anchor or "centre")
    if anchor is not None:
        raise InvalidParameter(
            "conflict",
            "anchor={anchor!r} goes with a place in cells or a mark, not with at={at!r}",
            "leave it out",
            anchor=anchor,
            at=at,
        )
    if at in NAMED:
        return named_corner(at, *sizes, margin)
    if at not in DRAWN:
        raise InvalidParameter(
            "unknown-name",
            "at={at!r} is not a place in the host",
            "use [x, y] in cells, or one of {known!l}",
            at=at,
            known=[*NAMED, *DRAWN, *host.marks],
        )

    # Draw the place. The path from start to target is searched only if ``at`` asks for it.
    if seed is None:
        raise InvalidParameter("needs-seed", "at={at!r} is drawn", "give it a seed", at=at)
    rng = seed if isinstance(seed, RandomStream) else RandomStream(seed).child("place", at)
    world = host.layout() if at == "way" else None
    way = witness_path_of(world) if world is not None else None
    size = usual(host.cell_size, DEFAULT_CELL_SIZE)
    points = None if way is None else np.stack([way.x, way.y], axis=1) / size
    radius = usual(host.robot_radius, DEFAULT_ROBOT_RADIUS)
    marks = marks_of(world) if world is not None else host.marks
    free = [(marks[name], in_cells(radius, size)) for name in (START, TARGET) if name in marks]
    return draw_corner(rng, *sizes, margin, free, points)


def _anchored(piece: Piece, place: Mark, anchor: str) -> tuple[int, int]:
    """Return the first cell that puts a piece's anchor on a place, to the nearest whole cell."""
    if anchor in piece.marks:
        x = piece.marks[anchor].x
        y = piece.marks[anchor].y
    elif anchor in NAMED:
        x, y = (
            Fraction(half * n, 2)
            for half, n in zip(NAMED[anchor], (piece.width, piece.height), strict=True)
        )
    else:
        raise InvalidParameter(
            "unknown-name",
            "anchor={anchor!r} is not a point of the piece",
            "use one of {known!l}",
            anchor=anchor,
            known=[*NAMED, *piece.marks],
        )
    return math.floor(place.x - x + HALF), math.floor(place.y - y + HALF)


def put_down(
    host: Piece,
    piece: Piece,
    corner: tuple[int, int],
    how: How,
    outside: str,
    whose: Mapping[str, str],
) -> Piece:
    """Return the host with a piece placed on it.

    Args:
        host: The piece to place on.
        piece: The piece to place.
        corner: Host cell of the piece's lower left cell; may be outside the host.
        how: As in ``Piece.place``.
        outside: As in ``Piece.place``.
        whose: Maps ``start`` and ``target`` to the owner whose mark is kept, ``host`` or ``piece``.

    Raises:
        InvalidParameter: If the piece sticks out although ``outside`` is ``refuse``, if it lacks a
            mark, or if the cell sizes differ.
    """
    x, y = corner
    is_inside = 0 <= x <= host.width - piece.width and 0 <= y <= host.height - piece.height
    if not is_inside and outside == "refuse":
        raise InvalidParameter(
            "outside-grid",
            "a piece of {width} x {height} cells at ({x}, {y}) sticks out of {host_width} x "
            "{host_height} cells",
            "put it elsewhere, or use outside='clip'",
            width=piece.width,
            height=piece.height,
            x=x,
            y=y,
            host_width=host.width,
            host_height=host.height,
        )

    # ``overlaid`` prefers the host's marks, so the piece's start counts only without the host's.
    dropped = [name for name, who in whose.items() if _is_piece(name, who, piece)]
    kept = replace(
        host, marks={name: mark for name, mark in host.marks.items() if name not in dropped}
    )
    return overlaid(kept, piece, x, y, how)


def overlaid(host: Piece, piece: Piece, x: int, y: int, how: How) -> Piece:
    """Return the host with a piece placed at (x, y), cut off where it sticks out."""
    # Merge the values of both pieces besides cells; if both have a value, keep the host's.
    agreed = replace(
        host,
        marks={
            **moved(piece.marks, lambda mx, my: (mx + x, my + y), host.width, host.height),
            **host.marks,
        },
        cell_size=_same_size(host.cell_size, piece.cell_size),
        robot_radius=piece.robot_radius if host.robot_radius is None else host.robot_radius,
        robot_speed=piece.robot_speed if host.robot_speed is None else host.robot_speed,
        robot=piece.robot if host.robot is None else host.robot,
    )

    # Cut the piece to the part that is inside the host.
    low_x = max(x, 0)
    low_y = max(y, 0)
    high_x = min(x + piece.width, host.width)
    high_y = min(y + piece.height, host.height)
    if low_x >= high_x or low_y >= high_y:
        return agreed
    part = piece.crop(low_x - x, low_y - y, high_x - low_x, high_y - low_y)
    here = (slice(low_y, high_y), slice(low_x, high_x))

    # Copy that part into arrays of the host's size. There is nothing to carve where the host is
    # undefined.
    says, solid, mask = (np.zeros_like(host.solid) for _ in range(3))
    says[here] = part.mask
    solid[here] = part.solid
    if how == "carve":
        says &= host.mask
    mask = host.mask | says

    # Combine the events, which needs both pieces' cells at time 0, and then the cells themselves.
    # The events' flat indices already use the host's width, so a constant shift moves them.
    events = Events.of(part.timeline, host.width)
    events = events._replace(cells=events.cells + low_y * host.width + low_x)
    below = PlacedCells(Events.of(host.timeline, host.width), host.solid, host.mask)
    both = put_together(below, PlacedCells(events, solid, says), how)
    solid = np.where(says, state_of_two(host.solid, host.mask, solid, how), host.solid)
    return replace(agreed, solid=solid, mask=mask, timeline=timeline_of(both, host.width))


def _is_piece(name: str, whose: str, piece: Piece) -> bool:
    """Return True if the piece's mark is kept, and False if the host's is."""
    check_choice(name, whose, ("host", "piece"))
    if whose == "piece" and name not in piece.marks:
        raise InvalidParameter(
            "missing-mark",
            "{name}='piece', but the piece has no {name}",
            "give it one, or omit {name}",
            name=name,
        )
    return whose == "piece"


def _same_size(host: float | None, piece: float | None) -> float | None:
    if host is not None and piece is not None and host != piece:
        raise InvalidParameter(
            "cell-sizes-differ",
            "the host has cells of {host:g} m, but the piece has cells of {piece:g} m",
            "make one with the other's cell_size",
            host=host,
            piece=piece,
        )
    return piece if host is None else host
