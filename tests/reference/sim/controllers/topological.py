"""A topological map in plain Python: places as objects, read from the memory and written back to
it.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import (
    WHOLE_TURN,
    angle_of,
    bearing_of,
    distance,
    distance_to_way,
    steer,
    wrap,
)
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

# Memory: limit of places; what it does; the map's resolution; number of places, and the next to be
# forgotten; the place that it left, and the one that it travels to; the step's direction, start and
# length; the exit, and those that were open before; then four numbers for each place.
MOST, MODE, LEVEL, COUNT, NEXT, HERE, TO, HEADING, X, Y, STEP, EXIT, OPEN, PLACES = range(14)
START, EXPLORE, TRAVEL = 0.0, 1.0, 2.0

_DIRECTIONS, _TARGET, _EXITS, _LINKS = 16, 16, range(17), range(5)
_SCALE = (1.0, 0.6, 0.35)
_STRIDE, _REACH, _NEAR, _SEES = 3.5, 4.0, 0.6, 1.5
_CLOSE, _APART, _THERE, _STANDS, _ALONG, _ACROSS = 0.95, 0.25, 0.02, 0.1, 0.9, 0.5


class _Place:
    """A place of the map: a view of its four numbers."""

    def __init__(self, numbers: Floats) -> None:
        self.numbers = numbers

    @property
    def point(self) -> tuple[float, float]:
        return float(self.numbers[0]), float(self.numbers[1])

    @property
    def exits(self) -> int:
        return int(self.numbers[2])

    @exits.setter
    def exits(self, bits: int) -> None:
        self.numbers[2] = float(bits)

    @property
    def links(self) -> list[int]:
        """The number of the neighbour in each slot; -1 for none."""
        return [((int(self.numbers[3]) >> (10 * slot)) & 1023) - 1 for slot in _LINKS]

    @links.setter
    def links(self, links: list[int]) -> None:
        self.numbers[3] = float(sum((to + 1) << (10 * slot) for slot, to in enumerate(links)))

    def replace(self, old: int, new: int) -> bool:
        """Puts a link in the first slot that holds another; returns whether there is one."""
        links = self.links
        if old not in links:
            return False
        links[links.index(old)] = new
        self.links = links
        return True


class _Robot:
    """What the robot sees in a step, and its memory."""

    def __init__(self, seen: Floats, memory: Floats) -> None:
        self.seen = seen
        self.memory = memory
        self.x, self.y = float(seen[layout.OBS_X]), float(seen[layout.OBS_Y])
        self.radius = float(seen[layout.OBS_RADIUS])
        self.towards = float(seen[layout.OBS_TARGET_HEADING])
        self.far = float(seen[layout.OBS_TARGET_DISTANCE])
        self.target = (self.x + self.far * cos(self.towards), self.y + self.far * sin(self.towards))
        beams = seen.size - layout.OBS_SIZE
        self.points = []
        for beam in range(beams):
            angle = float(seen[layout.OBS_HEADING]) + bearing_of(beam, beams)
            length = float(seen[layout.OBS_SIZE + beam])
            self.points.append((length * cos(angle), length * sin(angle)))

    def place(self, number: float) -> _Place:
        first = PLACES + 4 * int(number)
        return _Place(self.memory[first : first + 4])

    @property
    def count(self) -> int:
        return int(self.memory[COUNT])

    @property
    def here(self) -> int:
        return int(self.memory[HERE])

    @property
    def stride(self) -> float:
        return _STRIDE * _SCALE[int(self.memory[LEVEL])] * self.radius

    # The graph.

    def part(self, one: int, other: int) -> None:
        self.place(one).replace(other, -1)
        self.place(other).replace(one, -1)

    def join(self, one: int, other: int) -> bool:
        if other in self.place(one).links:
            return True
        if -1 not in self.place(one).links or -1 not in self.place(other).links:
            return False
        self.place(one).replace(-1, other)
        self.place(other).replace(-1, one)
        return True

    def is_explored(self, x: float, y: float, near: float) -> bool:
        for k in range(self.count):
            place = self.place(k)
            if distance(x, y, *place.point) < near:
                return True
            for to in place.links:
                if to > k and distance_to_way(x, y, *place.point, *self.place(to).point) < near:
                    return True
        return False

    def ways(self) -> tuple[list[float], list[int]]:
        """Return the lengths of the shortest paths from here, and the first place on each."""
        lengths, first = [math.inf] * self.count, [-1] * self.count
        lengths[self.here] = 0.0
        left = set(range(self.count))
        while left:
            at = min(left, key=lambda k: (lengths[k], k))
            if lengths[at] == math.inf:
                break
            left.remove(at)
            for to in self.place(at).links:
                if to < 0:
                    continue
                length = lengths[at] + distance(*self.place(at).point, *self.place(to).point)
                if length < lengths[to]:
                    lengths[to] = length
                    first[to] = to if at == self.here else first[at]
        return lengths, first

    # What is open.

    def is_free(self, cosine: float, sine: float, far: float) -> bool:
        width = _CLOSE * self.radius
        for x, y in self.points:
            along = x * cosine + y * sine
            across = y * cosine - x * sine
            short = width * width - across * across
            if along > 0.0 and short > 0.0 and along - math.sqrt(short) < far:
                return False
        return True

    def direction(self, exit_: int) -> float:
        return self.towards if exit_ == _TARGET else WHOLE_TURN * exit_ / _DIRECTIONS

    def look(self, exit_: int) -> float:
        return min(self.stride, self.far) if exit_ == _TARGET else self.stride

    def open_exits(self) -> int:
        bits = 0
        for exit_ in _EXITS:
            direction = self.direction(exit_)
            if exit_ == _TARGET and self.look(exit_) < _APART * self.radius:
                continue
            if self.is_free(cos(direction), sin(direction), self.look(exit_)):
                bits |= 1 << exit_
        return bits

    def is_new(self, exit_: int) -> bool:
        far = self.look(exit_)
        if far < self.stride:
            return True
        x = self.x + far * cos(self.direction(exit_))
        y = self.y + far * sin(self.direction(exit_))
        near = _NEAR * self.stride
        here = self.place(self.here).point
        if self.count and distance_to_way(x, y, *here, self.x, self.y) < near:
            return False
        return not self.is_explored(x, y, near)

    def has_opened(self, open_: int) -> bool:
        opened = open_ & ~int(self.memory[OPEN])
        for exit_ in _EXITS:
            off = abs(cos(self.direction(exit_) - float(self.memory[HEADING])))
            beside = exit_ == _TARGET or off <= _ACROSS
            if beside and (opened >> exit_) & 1 and self.is_new(exit_):
                return True
        return False

    # Places.

    def look_point(self, place: _Place, exit_: int) -> tuple[float, float]:
        x, y = place.point
        direction, far = self.direction(exit_), self.stride
        if exit_ == _TARGET:
            dx, dy = self.target[0] - x, self.target[1] - y
            direction, far = angle_of(dx, dy), min(far, math.sqrt(dx * dx + dy * dy))
        return x + far * cos(direction), y + far * sin(direction)

    def close_exits(self, one: int, other: int) -> None:
        way = (*self.place(one).point, *self.place(other).point)
        for k in range(self.count):
            place = self.place(k)
            for exit_ in _EXITS:
                if not (place.exits >> exit_) & 1:
                    continue
                point = self.look_point(place, exit_)
                if distance_to_way(*point, *way) < _NEAR * self.stride:
                    place.exits &= ~(1 << exit_)

    def make_place(self) -> int:
        most = int(self.memory[MOST])
        if self.count < most:
            self.memory[COUNT] += 1.0
            return self.count - 1
        number = int(self.memory[NEXT])
        if number == self.here:
            number = (number + 1) % most
        self.memory[NEXT] = float((number + 1) % most)
        for k in range(most):
            self.part(k, number)
        return number

    def settle(self, open_: int) -> None:
        came_from = self.here
        is_first = self.count == 0
        apart = distance(self.x, self.y, *self.place(came_from).point)
        if not is_first and apart < _APART * self.radius:
            return
        exits = sum(1 << one for one in _EXITS if (open_ >> one) & 1 and self.is_new(one))
        number = self.make_place()
        self.place(number).numbers[:] = (self.x, self.y, float(exits), 0.0)
        self.memory[HERE] = float(number)
        if is_first:
            return
        if not self.join(came_from, number):
            self.part(came_from, self.place(came_from).links[-1])
            self.join(came_from, number)
        self.close_exits(came_from, number)
        for k in range(self.count):
            if k in (number, came_from):
                continue
            x, y = self.place(k).point
            dx, dy = x - self.x, y - self.y
            far = math.sqrt(dx * dx + dy * dy)
            if 0.0 < far < _SEES * self.stride and self.is_free(dx / far, dy / far, far):
                self.join(number, k)

    # Decisions.

    def best_exit(self, lengths: list[float]) -> tuple[int, int]:
        best, least = (-1, 0), math.inf
        for k in range(self.count):
            for exit_ in _EXITS:
                if lengths[k] < math.inf and (self.place(k).exits >> exit_) & 1:
                    point = self.look_point(self.place(k), exit_)
                    length = lengths[k] + distance(*point, *self.target)
                    if length < least:
                        best, least = (k, exit_), length
        return best

    def decide(self, open_: int) -> None:
        lengths, first = self.ways()
        number, exit_ = self.best_exit(lengths)
        if number < 0:
            self.memory[PLACES:] = self.memory[COUNT] = self.memory[NEXT] = 0.0
            level = self.memory[LEVEL] + 1.0
            self.memory[LEVEL] = level if level < len(_SCALE) else 0.0
            open_ = self.open_exits()
            self.settle(open_)
            lengths, first = self.ways()
            number, exit_ = self.best_exit(lengths)
            if number < 0:
                number, exit_ = self.here, _TARGET
        if number != self.here:
            self.memory[MODE], self.memory[TO] = TRAVEL, float(first[number])
            return
        self.place(number).exits &= ~(1 << exit_)
        self.memory[MODE], self.memory[EXIT] = EXPLORE, float(exit_)
        self.memory[HEADING], self.memory[OPEN] = self.direction(exit_), float(open_)

    def is_barred(self) -> bool:
        heading = float(self.memory[HEADING])
        along = (self.x - self.memory[X]) * cos(heading) + (self.y - self.memory[Y]) * sin(heading)
        return self.seen[layout.OBS_BUMP] != 0.0 and along < _ALONG * self.memory[STEP]

    def is_at(self, place: _Place) -> bool:
        left = distance(self.x, self.y, *place.point)
        moved = distance(self.x, self.y, float(self.memory[X]), float(self.memory[Y]))
        stands = moved < _THERE * self.radius and left < _STANDS * self.radius
        return left < _THERE * self.radius or stands

    def continue_leg(self) -> None:
        stride = self.stride
        open_ = self.open_exits()
        if self.memory[MODE] == TRAVEL:
            if self.is_at(self.place(self.memory[TO])):
                self.memory[HERE] = self.memory[TO]
                self.decide(open_)
            elif self.is_barred():
                self.part(self.here, int(self.memory[TO]))
                self.settle(open_)
                self.decide(open_)
            return
        driven = distance(self.x, self.y, *self.place(self.here).point)
        is_there = int(self.memory[EXIT]) == _TARGET and self.far < _THERE * self.radius
        ends = self.is_barred() or is_there or driven >= _REACH * stride
        ends = ends or (driven >= _APART * self.radius and self.has_opened(open_))
        self.memory[OPEN] = float(open_)
        if ends:
            self.settle(open_)
            self.decide(open_)

    def drive(self, command: Floats) -> None:
        step = float(self.seen[layout.OBS_TIME_STEP])
        length = float(self.seen[layout.OBS_TOP_SPEED]) * step
        if self.memory[MODE] == TRAVEL:
            x, y = self.place(self.memory[TO]).point
            self.memory[HEADING] = angle_of(x - self.x, y - self.y)
            length = min(length, distance(self.x, self.y, x, y))
        elif int(self.memory[EXIT]) == _TARGET:
            length = min(length, self.far)
        turn = wrap(float(self.memory[HEADING]) - float(self.seen[layout.OBS_HEADING]))
        steer(self.seen, command, turn, length / step)
        self.memory[X], self.memory[Y], self.memory[STEP] = self.x, self.y, length


def act(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step: continues a leg, or decides at a place, and drives."""
    robot = _Robot(seen, memory)
    if memory[MODE] == START:
        open_ = robot.open_exits()
        robot.settle(open_)
        robot.decide(open_)
    else:
        robot.continue_leg()
    robot.drive(command)
