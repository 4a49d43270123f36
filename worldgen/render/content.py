"""The contents of a picture, gathered once for the map and its caption."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue, robot_colours
from worldgen.render.overlay import Trail
from worldgen.render.shortfall import Shortfall, shortfall_of
from worldgen.support.arrays import Bools, Floats
from worldgen.timeline import CellState
from worldgen.world import Robot, World


@dataclass(frozen=True, slots=True, eq=False)
class Changes:
    """The cells that a timeline changes: (height, width) bool each.

    Args:
        burns: Burning at some time.
        closes: Free at first, solid at some time.
        opens: Solid at first, not solid at some time.
    """

    burns: Bools
    closes: Bools
    opens: Bools

    @classmethod
    def of(cls, world: World) -> Changes:
        """Return the changes of a world; nothing is set in a static one."""
        line = world.timeline
        shape = world.walls.shape
        burns = line.cells_that_become(CellState.BURNING, shape=shape)
        closes = line.cells_that_become(CellState.SOLID, shape=shape) & ~world.walls
        opens = line.cells_that_become(CellState.FREE, CellState.BURNING, shape=shape) & world.walls
        return cls(burns, closes, opens)


@dataclass(frozen=True, slots=True)
class View:
    """Which of the marks a picture shows.

    Args:
        signal: True to tint the floor by the target's signal.
        witness: True to draw the proof's path, or its cut.
        is_card: True for a small picture, which leaves some marks out.
    """

    signal: bool
    witness: bool
    is_card: bool = False


@dataclass(frozen=True, eq=False)
class Content:
    """One picture's content.

    Args:
        world: What to draw.
        trails: A run in it: a path for each robot; empty to draw none.
        view: Which marks to draw.
        title: First line of the caption.
        frame: The map's place in the picture.
        changes: The cells that the world's timeline changes.
        named: The cells that the text next to the picture names.
        words: Corners of the words on the map so far, upper left and lower right, px.
    """

    world: World
    trails: Sequence[Trail]
    view: View
    title: str
    frame: Frame
    changes: Changes
    named: Sequence[tuple[int, int]] = ()
    words: list[tuple[Floats, Floats]] = field(default_factory=list)

    @property
    def trail(self) -> Trail | None:
        """The run of a single robot, which is drawn with more of its details."""
        return self.trails[0] if self.trails and not self.has_several else None

    @cached_property
    def shortfall(self) -> Shortfall | None:
        """How near a single robot gets that repeats itself."""
        return shortfall_of(self.world, self.trail) if self.trail else None

    @property
    def has_several(self) -> bool:
        """Whether there are several robots, or several runs of one, each in a colour of its own."""
        return self.world.is_fleet or len(self.trails) > 1

    def robot(self, number: int) -> Robot:
        """Return the robot of a trail; several trails of one robot show several runs."""
        robots = self.world.robots
        return robots[min(number, len(robots) - 1)]

    def colour(self, name: str, number: int) -> str:
        """Return the colour of a mark of one robot, given its index: its own among several."""
        if self.world.is_fleet or (self.has_several and name not in ("start", "target")):
            return robot_colours()[number % len(robot_colours())]
        return hue(MARKS[name].colour)
