"""Layouts: a world as a few boxes of solid cells, which a search moves and stretches."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.lattice import cell_middle, in_cells
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.world import World

Box = tuple[int, int, int, int]

_MOST_BOXES = 12
# Sides, cells, of a box that an edit adds.
_LONGEST = 12
# Limit on the cells by which an edit moves or stretches.
_FAR = 3


@dataclass(frozen=True)
class Layout:
    """Boxes [x0, x1) x [y0, y1) of solid cells in an otherwise empty world.

    Args:
        empty: The world without the boxes; its border stays unchanged.
        boxes: The boxes.
        fixed_target: True if the target does not move.
        leash: Cells that a box's side, or the target, may move from its place in ``home``.
        home: The layout that the leash is tied to; boxes are then neither added nor removed.
            ``None`` for no leash.
    """

    empty: World
    boxes: tuple[Box, ...]
    fixed_target: bool = False
    leash: int = 0
    home: Layout | None = None

    @classmethod
    def of(cls, world: World, *, fixed_target: bool = False, leash: int | None = None) -> Layout:
        """Return a world's inner solid cells as boxes, the largest first."""
        border = np.zeros_like(world.walls)
        border[[0, -1], :] = border[:, [0, -1]] = True
        empty = replace(world.bare, walls=world.walls & border)
        home = cls(empty, tuple(_boxes(world.walls & ~border)), fixed_target)
        return home if leash is None else replace(home, leash=leash, home=home)

    def world(self) -> World:
        """Return the world that the layout describes."""
        walls = self.empty.walls.copy()
        for x0, y0, x1, y1 in self.boxes:
            walls[y0:y1, x0:x1] = True
        return replace(self.empty, walls=walls)

    def edited(self, rng: RandomStream) -> Layout | None:
        """Return the layout after one random edit; ``None`` if that edit is impossible."""
        # Move the target, or add a box.
        kind = rng.below(16)
        if kind == 0:
            return self._with_target(rng)
        if kind == 1 and self.home is None and len(self.boxes) < _MOST_BOXES:
            return self._kept((*self.boxes, self._new_box(rng)))
        if not self.boxes:
            return None
        # Remove, move or stretch a box.
        chosen = rng.below(len(self.boxes))
        if kind == 2 and self.home is None:
            return self._kept((*self.boxes[:chosen], *self.boxes[chosen + 1 :]))
        x0, y0, x1, y1 = self.boxes[chosen]
        way = rng.choice((-1, 1)) * (1 + rng.below(_FAR) * rng.below(2))
        if kind < 8:
            dx, dy = (way, 0) if rng.below(2) else (0, way)
            return self._with_box(chosen, (x0 + dx, y0 + dy, x1 + dx, y1 + dy))
        sides = [x0, y0, x1, y1]
        sides[rng.below(4)] += way
        return self._with_box(chosen, (sides[0], sides[1], sides[2], sides[3]))

    def _with_box(self, index: int, box: Box) -> Layout | None:
        return self._kept((*self.boxes[:index], box, *self.boxes[index + 1 :]))

    def simpler(self) -> list[Layout]:
        """Yield layouts with one box fewer, or one row of one box fewer, the largest step first."""
        found = []
        if self.home is None:
            found = [
                self._kept((*self.boxes[:k], *self.boxes[k + 1 :])) for k in range(len(self.boxes))
            ]
        for k, (x0, y0, x1, y1) in enumerate(self.boxes):
            for box in (
                (x0 + 1, y0, x1, y1),
                (x0, y0 + 1, x1, y1),
                (x0, y0, x1 - 1, y1),
                (x0, y0, x1, y1 - 1),
            ):
                found.append(self._with_box(k, box))
        return [layout for layout in found if layout is not None]

    def _kept(self, boxes: tuple[Box, ...]) -> Layout | None:
        """Return the layout with other boxes if they fit and keep start and target clear."""
        # Boxes must fit inside the border, and stay on the leash.
        width = self.empty.width
        height = self.empty.height
        if any(
            not (1 <= x0 < x1 <= width - 1 and 1 <= y0 < y1 <= height - 1)
            for x0, y0, x1, y1 in boxes
        ):
            return None
        if self.home is not None:
            pairs = zip(boxes, self.home.boxes, strict=True)
            if any(
                abs(side - before) > self.leash
                for box, old in pairs
                for side, before in zip(box, old, strict=True)
            ):
                return None
        # Start and target must stay clear.
        layout = replace(self, boxes=boxes)
        side = self.empty.cell_size
        reach = self.empty.robot_radius
        places = (
            (self.empty.start.x, self.empty.start.y, reach),
            (self.empty.target.x, self.empty.target.y, 0.0),
        )
        for x, y, clear in places:
            at_x = float(in_cells(x, side))
            at_y = float(in_cells(y, side))
            room = float(in_cells(clear, side))
            for x0, y0, x1, y1 in boxes:
                if math.hypot(max(x0 - at_x, 0, at_x - x1), max(y0 - at_y, 0, at_y - y1)) <= room:
                    return None
        return layout

    def _with_target(self, rng: RandomStream) -> Layout | None:
        if self.fixed_target:
            return None
        dx = rng.between(-2, 2)
        dy = rng.between(-2, 2)
        side = self.empty.cell_size
        target = self.empty.target
        ix = math.floor(in_cells(target.x, side)) + dx
        iy = math.floor(in_cells(target.y, side)) + dy
        if not (1 <= ix < self.empty.width - 1 and 1 <= iy < self.empty.height - 1):
            return None
        # It moves to the centre of a cell, and stays on its leash.
        moved = replace(target, x=cell_middle(ix, side), y=cell_middle(iy, side))
        if self.home is not None:
            home = self.home.empty.target
            if max(abs(moved.x - home.x), abs(moved.y - home.y)) > (self.leash + 0.5) * side:
                return None
        try:
            return replace(self, empty=replace(self.empty, target=moved))._kept(self.boxes)
        except InvalidWorld:
            return None

    def _new_box(self, rng: RandomStream) -> Box:
        x = 1 + rng.below(self.empty.width - 2)
        y = 1 + rng.below(self.empty.height - 2)
        length = 1 + rng.below(_LONGEST)
        thickness = 1 + rng.below(2)
        return (
            (x, y, x + length, y + thickness) if rng.below(2) else (x, y, x + thickness, y + length)
        )


def _boxes(walls: Bools) -> list[Box]:
    """Return solid cells as boxes that do not overlap.

    Each starts at the lowest left cell and extends as wide, then as high, as possible.
    """
    left = walls.copy()
    boxes = []
    # Grow a box from the lowest left cell that remains.
    while left.any():
        y0, x0 = (int(k) for k in np.argwhere(left)[0])
        x1 = x0
        while x1 < left.shape[1] and left[y0, x1]:
            x1 += 1
        y1 = y0
        while y1 < left.shape[0] and left[y1, x0:x1].all():
            y1 += 1
        left[y0:y1, x0:x1] = False
        boxes.append((x0, y0, x1, y1))
    return sorted(boxes, key=lambda box: -(box[2] - box[0]) * (box[3] - box[1]))
