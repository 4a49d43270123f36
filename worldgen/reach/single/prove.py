"""Decide whether the disc can get from the start to the target, with a proof either way."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from worldgen._core import lib
from worldgen.lattice import UNIT, exact, in_cells, lattice_units, metres_to_lattice
from worldgen.reach.decision import (
    BLOCKED,
    REACHABLE,
    UNDECIDED,
    Decision,
    check_margin,
    check_radius,
)
from worldgen.reach.still.coarse import FROM_CELLS, coarse_path
from worldgen.reach.still.core_calls import ROUNDING, ask_still, points_of, witness_of
from worldgen.reach.still.cut import MOST_TARGETS, find_chain
from worldgen.reach.still.disc import Disc, beyond, lattice_centre, target_disc, widest_gap_sq
from worldgen.reach.still.lattice_graph import Graph, build_graph, find_path, nodes_within
from worldgen.reach.still.path import make_witness, root_up, shorten
from worldgen.reach.still.pinch import bridges
from worldgen.reach.still.target_poses import deciding_poses
from worldgen.reach.still.walls import Cell, ExactPoint, Walls
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check
from worldgen.timeline import Timeline
from worldgen.world import Cut, Witness, World

# Nodes per cell side if half cells neither find a path nor leave a cut.
_FINER = (4, 8, 16)
# Limit on the nodes of a graph to search; this many take about 1 GB.
_MOST_NODES = 40_000_000
# The same limit in a world that changes.
_MOST_TIMED_NODES = 4_000_000
_NOT_ASKED = "a path was found; its witness was not requested"
_CUT_NOT_ASKED = (
    "the start is covered, or chains of cells separate it from the target; the cut was not "
    "requested"
)
_TOO_LARGE = "the target's disc is too large to examine all of its poses; use a smaller one"
_TOO_FINE = "a passage is as wide as the disc, to a billionth of a cell; round the radius"
_NONE = np.zeros(0, np.int64)
# Lengths with more digits than C can multiply are rounded to this part of a cell.
_GRAIN = Fraction(1, 2**30)


def decide(
    world: World,
    *,
    radius: float | None = None,
    margin: float = 0.0,
    certificate: bool = True,
    cut: bool = True,
) -> Decision:
    """Return True if a disc can get from the start to the target.

    Args:
        world: The world; its own certificate is ignored.
        radius: Radius of the disc, m; the robot's if omitted.
        margin: Time, s. In a world that changes, the witness must remain valid if the robot first
            waits at the start for up to this long, and then does everything that much later.
        certificate: True to return the proof in a static world. Without it, small worlds take a
            fraction of the time: the existence of a path or a cut is still proved, but neither is
            constructed.
        cut: True to return the proof if it is a cut.

    Raises:
        InvalidParameter: If the radius is not a finite number above 0, or the margin is negative or
            not finite.
    """
    radius = world.robot_radius if radius is None else radius
    check_radius(radius, world.cell_size)
    check_margin(margin)
    if world.is_dynamic:
        return _decide_changing(world, radius, margin)
    return _ReachQuery(world, radius).answer(certificate=certificate, cut=certificate and cut)


def _decide_changing(world: World, radius: float, margin: float) -> Decision:
    # Most worlds are static and need none of this.
    from worldgen.reach.timed.earliest import find_timed_path, make_timed_witness, shorten_timed
    from worldgen.reach.timed.spans import ChangingWalls, Spans

    # The start must be clear at time 0.
    spans = Spans(world, margin)
    still = replace(world, timeline=Timeline(), certificate=None)
    at_once = _ReachQuery(replace(still, walls=spans.at_start), radius)
    bad_start = at_once.judge_start()
    if bad_start is not None:
        return bad_start
    # Search for a timed path on finer and finer graphs.
    walls = ChangingWalls(world, spans, at_once.walls.radius)
    for k in (2, *_FINER):
        if k > 2 and k * k * world.walls.size > _MOST_TIMED_NODES:
            break
        path = find_timed_path(world, walls, k, at_once.exact_start, at_once.disc)
        if path is not None:
            witness = make_timed_witness(world, walls, shorten_timed(walls, path))
            reason = (
                f"a timed path of {witness.length:.4g} m arrives after {witness.duration:.4g} s"
            )
            return Decision(REACHABLE, witness, reason)
        # The cells that are always blocked may leave a cut.
        if k == 2:
            for_ever = _ReachQuery(replace(still, walls=spans.always), radius).answer(
                certificate=False
            )
            if for_ever.result == BLOCKED:
                return for_ever
    # A path that avoids all cells that are ever blocked needs no timing.
    untouched = _ReachQuery(replace(still, walls=spans.ever), radius).answer()
    # A path between nodes, which the timed graphs do not have, may exist.
    if untouched.result == REACHABLE:
        return untouched
    late = f" that may begin {margin:g} s late" if margin else ""
    reason = f"no timed path{late} was found, and the cells that never open leave no cut"
    return Decision(UNDECIDED, None, reason)


@dataclass
class _ReachQuery:
    """A world and a disc.

    Attributes:
        walls: Solid cells and radius.
        start: The start on the pose lattice, lu, if the robot may be there.
        exact_start: The start given by the world's decimals, lu.
        disc: The target.
        goal: A clear pose in the target's disc, if one is known.
        wants_cut: True to construct a cut.
    """

    world: World
    radius: float

    def __post_init__(self) -> None:
        world = self.world
        self.walls = Walls(world.walls, in_cells(self.radius, world.cell_size))
        self.start: ExactPoint = (
            metres_to_lattice(world.start.x, world.cell_size),
            metres_to_lattice(world.start.y, world.cell_size),
        )
        self.exact_start: ExactPoint = (
            lattice_units(world.start.x, world.cell_size),
            lattice_units(world.start.y, world.cell_size),
        )
        self.disc: Disc = target_disc(world)
        self.goal: ExactPoint | None = None
        self.wants_cut = True

    @functools.cached_property
    def goal_walls(self) -> Walls:
        """The walls for a disc reduced by the possible rounding of the goal."""
        return Walls(self.world.walls, self.walls.radius * (1 - ROUNDING))

    @functools.cached_property
    def _halves(self) -> Graph:
        """The graph over half cells."""
        return build_graph(self.world.walls, self.walls.radius, 2)

    def _is_clear(self, point: ExactPoint) -> bool:
        """Return True if the disc may be at a point."""
        x, y = point
        if x % (UNIT // 2) == 0 == y % (UNIT // 2) and self.world.walls.size <= FROM_CELLS:
            # The graph has the answer, and is needed anyway.
            column = int(x) // (UNIT // 2)
            row = int(y) // (UNIT // 2)
            rows, columns = self._halves.clear.shape
            return (
                0 <= column < columns and 0 <= row < rows and bool(self._halves.clear[row, column])
            )
        return self.walls.is_clear(point, point)

    def answer(self, *, certificate: bool = True, cut: bool = True) -> Decision:
        """Return the decision, with its witness or its cut if requested."""
        # Small worlds are decided in one call of C.
        self.wants_cut = cut
        answer, has_path = self._at_once(certificate)
        if answer is not None:
            return answer
        if has_path is None:
            bad_start = self.judge_start()
            if bad_start is not None:
                return bad_start
            centre = lattice_centre(self.disc)
            if centre is not None and self._is_clear(centre):
                self.goal = centre
        # Search the graph, then for a cut, then off the graph.
        found = [] if has_path is False else self._coarse_path() or self._path(2)
        if not found:
            blocked = self._cut()
            if blocked is not None:
                return blocked
            found = self._path_off_graph() or self._path_through_pinches()
        if not found:
            reason = "there is a passage just wide enough, but no path along it was found"
            return Decision(UNDECIDED, None, reason)
        # Build the witness if it is requested.
        if not certificate:
            return Decision(REACHABLE, None, _NOT_ASKED)
        points: list[ExactPoint] = [*shorten(self.walls, found)]
        if self.exact_start != points[0]:
            points.insert(0, self.exact_start)
        return _reached(
            make_witness(self.walls, points, self.world.cell_size, self.world.robot_speed)
        )

    def _at_once(self, certificate: bool) -> tuple[Decision | None, bool | None]:
        """Decide a small world in one call of C.

        If that is inconclusive, return whether half cells have a path; None if even that is
        unknown.
        """
        # Ask C, unless the world is too large or its numbers are too long.
        world = self.world
        if world.walls.size > FROM_CELLS:
            return None, None
        rounded = self.start != self.exact_start
        asked = ask_still(world, self.radius, rounded=rounded)
        if asked is None:
            return None, None
        asked.start_x, asked.start_y = self.start
        asked.wants_path = certificate
        asked.wants_cut = self.wants_cut
        check(lib.wg_still_decide(self.walls.described, asked))
        outcome = asked.outcome
        # Turn the answer into a decision.
        if outcome == lib.WG_REACHED:
            if not certificate:
                return Decision(REACHABLE, None, _NOT_ASKED), True
            try:
                if not rounded:
                    return _reached(witness_of(asked, world.cell_size)), True
                points = [self.exact_start, *points_of(asked)]
                return _reached(
                    make_witness(self.walls, points, world.cell_size, world.robot_speed)
                ), True
            finally:
                lib.wg_still_free(asked)
        if outcome == lib.WG_PARTED:
            return Decision(BLOCKED, None, _CUT_NOT_ASKED), False
        if outcome == lib.WG_START_COVERED:
            return self._covered_start(), False
        if asked.goal_clear:
            self.goal = (asked.goal_x, asked.goal_y)
        return None, False if outcome == lib.WG_NO_PATH else None

    def _coarse_path(self) -> list[ExactPoint]:
        if self.goal is None or self.world.walls.size <= FROM_CELLS:
            return []
        return coarse_path(self.walls, self.start, self.goal)

    def judge_start(self) -> Decision | None:
        """Return the decision if the start alone settles it."""
        if not self._is_clear(self.exact_start):
            return self._covered_start()
        if self.exact_start != self.start and not self.walls.is_clear(self.exact_start, self.start):
            # The start touches a wall, which rounding would hide.
            self.start = self.exact_start
        return None

    def _covered_start(self) -> Decision:
        """Return the decision for a cell that is too near to the start."""
        if not self.wants_cut:
            return Decision(BLOCKED, None, _CUT_NOT_ASKED)
        cell, distance_sq = self.walls.nearest(self.exact_start)
        reason = f"the start is closer than the radius to cell {cell}"
        return self._blocked(cell, Fraction(distance_sq) / UNIT**2, reason)

    def _path(self, k: int, *, pinched: bool = False, cornered: bool = False) -> list[ExactPoint]:
        """Return the points from start to target over one graph; empty if it has no such path.

        Args:
            k: Nodes per cell side.
            pinched: True to use bridges too.
            cornered: True to enter and leave the graph around a corner too.
        """
        # Link start and goal to the graph.
        graph = self._halves
        if k > 2:
            graph = build_graph(self.world.walls, self.walls.radius, k)
        unit = UNIT // k
        sources = links(self.walls, graph, self.start)
        ends = links(self.goal_walls, graph, self.goal) if self.goal is not None else []
        onto, off = self._links_round_corners(graph) if cornered else ({}, {})
        sources = [*sources, *onto]
        ends = [*ends, *off]
        if not sources:
            return []
        # Search for the goal first, then for any clear node of the target.
        toward = _nearest_node(self.disc, unit)
        nodes: list[int] = []
        # There is usually no need to look for other ends.
        if ends and not pinched:
            nodes = find_path(graph, sources, ends, _NONE, toward)
        if not nodes:
            spare = nodes_within(self.disc, graph)
            if not (ends or len(spare)):
                return []
            extra = bridges(self.walls, graph) if pinched else []
            nodes = find_path(graph, sources, ends, spare, toward, extra)
        if not nodes:
            return []
        # Turn nodes into points.
        stride = graph.stride
        points: list[ExactPoint] = [(node % stride * unit, node // stride * unit) for node in nodes]
        points = [self.start, onto.get(nodes[0], self.start), *points]
        if self.goal is not None and nodes[-1] in ends:
            points += [off.get(nodes[-1], self.goal), self.goal]
        return points

    def _links_round_corners(
        self, graph: Graph
    ) -> tuple[dict[int, ExactPoint], dict[int, ExactPoint]]:
        """Return nodes with the corners on the path from the start, and on the path to the goal."""
        off = (
            _links_round_corners(self.goal_walls, graph, self.goal) if self.goal is not None else {}
        )
        return _links_round_corners(self.walls, graph, self.start), off

    def _path_off_graph(self) -> list[ExactPoint]:
        """Return the start, if the target's disc contains it.

        Otherwise return a path to the goal with at most one corner and no node.
        """
        if self.disc.holds(self.exact_start):
            return [self.exact_start]
        if self.goal is None:
            return []
        start = self.start
        goal = self.goal
        for corner in (start, (start[0], goal[1]), (goal[0], start[1])):
            if self.goal_walls.is_clear(start, corner) and self.goal_walls.is_clear(corner, goal):
                return [start, corner, goal]
        return []

    def _path_through_pinches(self) -> list[ExactPoint]:
        for cornered, k in itertools.product((False, True), (2, *_FINER)):
            if k == 2 or k * k * self.world.walls.size <= _MOST_NODES:
                found = self._path(k, pinched=True, cornered=cornered)
                if found:
                    return found
        return []

    def _cut(self, *, is_rounded: bool = False) -> Decision | None:
        """Return a proof that no pose of the target can be reached.

        If there is none, ``goal`` becomes a pose that can be reached.

        Args:
            is_rounded: True if the lengths are rounded already.
        """
        if self.goal is not None:
            chain = self._chain([self.goal])
            if chain is None:
                # Nothing separates it from the start, so a path to it exists.
                return None
            # Most rings surround the whole disc, and then its poses need not be examined one by
            # one.
            if self.goal == (self.disc.x, self.disc.y) and beyond(chain, self.start, self.disc):
                return self._ringed(chain)
        poses = deciding_poses(self.walls, self.disc)
        if poses is None and not is_rounded:
            return self._cut_with_fewer_digits()
        if poses is None:
            return Decision(UNDECIDED, None, _TOO_LARGE)
        if not len(poses):
            cell, _ = self.walls.nearest((self.disc.x, self.disc.y))
            return self._blocked(cell, None, "no pose in the target's disc is clear")
        parted = [poses[0]]
        while len(parted) <= MOST_TARGETS:
            chain = self._chain(parted)
            if chain is None:
                break
            first = poses.first_unparted(chain, self.start)
            if first == len(poses):
                return self._ringed(chain)
            left = poses[first]
            if self._chain([left]) is None:
                self.goal = left
                return None
            parted.append(left)
        if len(parted) == 1:
            self.goal = parted[0]
            return None
        return Decision(
            UNDECIDED,
            None,
            "every pose in the target's disc is walled off, but no single ring was found",
        )

    def _cut_with_fewer_digits(self) -> Decision | None:
        """Do the work of :meth:`_cut` by two questions whose lengths C can multiply.

        What a larger disc reaches in a smaller target, this disc reaches, too; and what stops a
        smaller disc from every pose of a larger target stops it. Only a passage that is as wide as
        the disc to a billionth of a cell leaves both open.
        """
        harder = self._rounded(1)
        starts = harder is not None and harder.walls.is_clear(self.start, self.start)
        if harder is not None and starts and harder._cut(is_rounded=True) is None:
            self.goal = harder.goal
            return None
        easier = self._rounded(-1)
        found = None if easier is None else easier._cut(is_rounded=True)
        if found is not None and found.result == BLOCKED:
            return found
        return Decision(UNDECIDED, None, _TOO_LARGE if found is not None else _TOO_FINE)

    def _rounded(self, sign: int) -> _ReachQuery | None:
        """Return a harder question, or with -1 an easier one, with few digits; None if it has none.

        Its disc is larger, and its target is inside this one.
        """
        grain = UNIT * _GRAIN
        # Rounding moves the centre by less than a grain.
        reach = math.floor(self.disc.radius / grain * sign) * sign - sign
        if reach < 0:
            return None
        x, y = (round(value / grain) * grain for value in (self.disc.x, self.disc.y))
        other = _ReachQuery(self.world, self.radius)
        radius = math.ceil(self.walls.radius / _GRAIN * sign) * sign * _GRAIN
        other.walls = Walls(self.world.walls, radius)
        other.disc = Disc(x, y, reach * grain)
        other.wants_cut = self.wants_cut
        return other

    def _ringed(self, chain: Ints) -> Decision:
        reason = (
            f"a ring of {len(chain)} cells, with every gap too narrow to pass, separates start and "
            f"target"
        )
        return self._blocked(chain, self._stopped_sq(chain), reason)

    def _chain(self, poses: Sequence[ExactPoint]) -> Ints | None:
        return find_chain(self.world.walls, self.walls.radius, self.start, poses)

    def _stopped_sq(self, chain: Ints) -> Fraction | None:
        """Return the squared radius, cells, above which a chain stops every disc.

        Return None if that is only known for the robot's disc.
        """
        return Fraction(widest_gap_sq(chain), 4) if beyond(chain, self.start, self.disc) else None

    def _blocked(self, chain: Ints | Cell, stopped_sq: Fraction | None, reason: str) -> Decision:
        """Return the decision, with the cut and its clearance if requested.

        Args:
            chain: The chain, or the only cell.
            stopped_sq: Squared radius, cells, above which every disc is stopped.
            reason: Sentence for the decision.
        """
        if not self.wants_cut:
            return Decision(BLOCKED, None, reason)
        clearance = math.nextafter(self.radius, 0.0)
        if stopped_sq is not None:
            clearance = min(clearance, _root_in_metres(stopped_sq, self.world.cell_size))
        cells = np.array([chain], np.int64) if isinstance(chain, tuple) else chain
        return Decision(BLOCKED, Cut(cells, clearance), reason)


@functools.lru_cache(maxsize=1024)
def _root_in_metres(square: Fraction, cell_size: float) -> float:
    return root_up(square * exact(cell_size) ** 2)


def _reached(witness: Witness) -> Decision:
    reason = (
        f"a path of {witness.length:.4g} m lets discs of up to {witness.clearance:.4g} m through"
    )
    return Decision(REACHABLE, witness, reason)


@functools.lru_cache(maxsize=1024)
def _nearest_node(disc: Disc, unit: int) -> tuple[int, int]:
    return round(disc.x / unit), round(disc.y / unit)


def links(walls: Walls, graph: Graph, point: ExactPoint) -> list[int]:
    """Return the clear nodes near a point to which the disc may go straight.

    If the point is a node, it is that node.
    """
    unit = UNIT // graph.k
    x, y = point
    if x % unit == 0 and y % unit == 0:
        columns = range(int(x // unit), int(x // unit) + 1)
        rows = range(int(y // unit), int(y // unit) + 1)
    else:
        columns, rows = (range(int(value // unit) - 1, int(value // unit) + 3) for value in point)
    nodes = []
    for j in rows:
        for i in columns:
            inside = 0 <= i < graph.clear.shape[1] and 0 <= j < graph.clear.shape[0]
            if not (inside and graph.clear[j, i]):
                continue
            if point == (i * unit, j * unit) or walls.is_clear(point, (i * unit, j * unit)):
                nodes.append(j * graph.stride + i)
    return nodes


def _links_round_corners(walls: Walls, graph: Graph, point: ExactPoint) -> dict[int, ExactPoint]:
    """Yield clear nodes that the disc reaches from a point over one corner along the axes.

    If the point touches a wall's side and a cell's corner, the path may have to follow the wall at
    first: the free space next to it widens as slowly as a circle leaves its tangent, so the first
    node may be far along the wall and close to it.
    """
    unit = UNIT // graph.k
    links: dict[int, ExactPoint] = {}
    wide = 2 + math.isqrt(math.ceil(8 * graph.k * walls.radius))
    for along in (0, 1):
        columns, rows = (
            range(int(value // unit) - reach, int(value // unit) + reach + 2)
            for value, reach in zip(point, (wide, 1) if along == 0 else (1, wide), strict=True)
        )
        for j, i in itertools.product(rows, columns):
            if (
                0 <= i < graph.clear.shape[1]
                and 0 <= j < graph.clear.shape[0]
                and graph.clear[j, i]
            ):
                node: ExactPoint = (i * unit, j * unit)
                corner: ExactPoint = (node[0], point[1]) if along == 0 else (point[0], node[1])
                if walls.is_clear(point, corner) and walls.is_clear(corner, node):
                    links.setdefault(j * graph.stride + i, corner)
    return links
