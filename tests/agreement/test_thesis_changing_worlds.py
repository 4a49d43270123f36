"""In worlds that change, the thesis's robot behaves as its listing specifies, even if walls fall on
it.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim import simulate
from sim.thesis.core_calls import ThesisEpisode, ThesisSetup, new_rows, signal_map
from tests.agreement.test_thesis_twin import SIDE, listed_advance
from tests.reference.sim import thesis_layout as at
from tests.reference.sim.fdlibm import atan, cos, sin
from tests.sim.test_episode import arena
from worldgen import CellState, Event, Timeline

TURN = 2.0 * math.pi
STEPS = 400
INNER = st.tuples(st.integers(1, SIDE - 2), st.integers(1, SIDE - 2))


class ListedRobot:
    """The listing's robot, simulator and behaviours, and the arbiter that its prose describes."""

    def __init__(self, walls, target, place, heading, rule):
        self.walls, self.target = set(walls), target
        self.x, self.y = place
        self.heading, self.rule = heading, rule
        self.target_heading, self.speed, self.old_speed = 0.0, 0.2, 0.0
        self.collision, self.busy, self.current, self.ticks = False, False, None, 0

    def tick(self):
        """Does what ``actionPerformed`` does; returns whether the target is reached."""
        goal_x = self.x - cos(self.heading) * self.speed * 15.0
        goal_y = self.y - sin(self.heading) * self.speed * 15.0
        self.x, self.y, self.collision = listed_advance(self.walls, self.x, self.y, goal_x, goal_y)
        reached = self.value(int(self.x / 10), int(self.y / 10)) == 0
        self.arbitrate()
        return reached

    def value(self, x, y):
        """Returns ``cellVal[x][y]``."""
        edge = not (0 < x < SIDE - 1 and 0 < y < SIDE - 1)
        if edge or (x, y) in self.walls:
            return -2
        return (x - self.target[0]) ** 2 + (y - self.target[1]) ** 2

    def signal(self):
        """Does what ``signalDirection`` does."""
        own_x, own_y = int(self.x / 10), int(self.y / 10)
        low, best = self.value(own_x, own_y), (own_x, own_y)
        for y in range(max(1, own_y - 1), min(SIDE - 2, own_y + 1) + 1):
            for x in range(max(1, own_x - 1), min(SIDE - 2, own_x + 1) + 1):
                if 0 <= self.value(x, y) < low:
                    low, best = self.value(x, y), (x, y)
        dx, dy = (best[0] + 0.5) * 10 - self.x, (best[1] + 0.5) * 10 - self.y
        if dx == 0:
            return 1.5 * math.pi if dy > 0 else math.pi / 2
        heading = atan(dy / dx)
        if dx >= 0 and dy <= 0:
            return math.pi + heading if heading <= 0 else heading
        if dx <= 0 and dy <= 0:
            return heading
        if dx <= 0 and dy >= 0:
            return TURN + heading if heading <= 0 else heading
        return math.pi + heading if heading >= 0 else heading

    def turn(self):
        """Does what ``turnS`` does."""
        goal, own = self.target_heading, self.heading
        if abs(goal - own) <= 0.2:
            self.heading = goal
        elif goal < own:
            back = goal + math.pi > own
            self.heading = math.fmod(own - 0.08 if back else own + 0.08, TURN)
        else:
            on = own + math.pi > goal
            self.heading = math.fmod(own + 0.08 if on else TURN + own - 0.08, TURN)

    def arbitrate(self):
        if not self.busy:
            if not self.collision and self.target_heading == self.signal():
                self.current, self.ticks, self.busy = "drive", 2, True
            elif not self.collision:
                self.current, self.busy = "seek", True
            else:
                self.old_speed, self.speed = self.speed, 0.0
                side = math.pi / 2 if self.rule == 1 else -math.pi / 2
                self.target_heading = math.fmod(self.heading + side, TURN)
                self.current, self.ticks, self.busy = "collide", 5, True
        if self.busy:
            getattr(self, self.current)()

    def drive(self):
        if self.ticks >= 0 and not self.collision:
            self.speed, self.ticks = 0.2, self.ticks - 1
        else:
            self.busy = False

    def seek(self):
        self.speed, self.target_heading = 0.0, self.signal()
        if self.heading != self.target_heading:
            self.turn()
        else:
            self.busy = False

    def collide(self):
        if self.heading != self.target_heading:
            self.turn()
        elif self.ticks >= 0:
            self.speed, self.ticks = self.old_speed, self.ticks - 1
        else:
            self.busy = False


def listed(walls, target, events, start, rule):
    """Return poses after each tick, and whether the target was reached."""
    robot = ListedRobot(walls, target, start[:2], start[2], rule)
    poses = []
    for step in range(1, STEPS + 1):
        for _, x, y, solid in [event for event in events if event[0] == step]:
            (robot.walls.add if solid else robot.walls.discard)((x, y))
        reached = robot.tick()
        poses.append((robot.x, robot.y, robot.heading))
        if reached:
            return poses, True
    return poses, False


def ours(walls, target, events, start, rule):
    light = signal_map(SIDE, SIDE, *target)
    cells = light.copy()
    for wall in walls:
        cells[wall] = at.WALL
    setup = ThesisSetup(
        rule=rule, time_step=15.0, steps=STEPS, stop_at_tunnel=0, target_x=target[0],
        target_y=target[1], find_loop=at.NO_LOOP,
    )  # fmt: skip
    table = np.array(events, np.int64).reshape(-1, 4)
    episode = ThesisEpisode(cells, light, table, start, setup)
    rows = new_rows(STEPS + 1)
    episode.go(STEPS, np.zeros(0), rows)
    done = episode.run.steps
    poses = [(row["x"], row["y"], row["heading"]) for row in rows[1 : done + 1]]
    return poses, episode.run.ending == at.REACHED


@st.composite
def changing(draw):
    target, start = draw(INNER), draw(INNER)
    walls = draw(st.sets(INNER, max_size=15)) - {target, start}
    times = st.integers(1, STEPS)
    near = st.tuples(st.integers(-2, 2), st.integers(-2, 2)).map(
        lambda d: (min(max(start[0] + d[0], 1), SIDE - 2), min(max(start[1] + d[1], 1), SIDE - 2))
    )
    cells = st.one_of(INNER, near).filter(lambda cell: cell != target)
    changes = draw(st.lists(st.tuples(times, cells, st.integers(0, 1)), max_size=8))
    events = sorted((step, *cell, solid) for step, cell, solid in changes)
    place = (start[0] * 10 + 5.0, start[1] * 10 + 5.0, draw(st.floats(0.0, 6.28)))
    return walls, target, events, place, draw(st.integers(1, 2))


@given(changing())
def test_a_run_in_a_changing_world_is_the_listings(scenario):
    assert ours(*scenario) == listed(*scenario)


@pytest.mark.parametrize("rule", [1, 2])
def test_a_wall_that_lands_on_the_robot_ends_nothing_that_keeps_going(rule):
    scenario = (set(), (9, 9), [(12, 3, 3, 1), (80, 3, 3, 0)], (35.0, 35.0, 4.5), rule)
    poses, _ = ours(*scenario)
    assert len(poses) > 80 and poses == listed(*scenario)[0]


def test_by_default_a_wall_that_lands_on_the_robot_ends_the_run():
    landing = Timeline.of([Event(0.3, 5, 5, CellState.SOLID)])
    world = replace(arena(20, (0.55, 0.55, 0.0), (1.55, 1.55)), timeline=landing)
    ended = simulate(world, "thesis-1", motion="stepped")
    assert (ended.verdict, ended.evidence.state) == ("burned", "solid")
    goes_on = simulate(world, "thesis-1", motion="stepped", keep_going=True)
    assert goes_on.verdict != "burned" and goes_on.steps > ended.steps
