"""The thesis's map editor, according to its listing: the contents of maps drawn step by step.

Source: the thesis's listing, ``simWorldCreator``: ``markCell``, ``repositionGoal``, ``clearCells``,
``multipleCellNoise``, ``noiseMapGen``, ``removeNoise``, and the listener of the box "Noise Filter".
"""

import numpy as np

WALL = -2
REACH = 2


class Editor:
    """A map under the mouse; ``cells[x][y]``, y down.

    Args:
        size: Cells a side.
        target: Column and row; the program starts with the middle.
    """

    def __init__(self, size, target=None):
        self.size = size
        self.noise = False
        middle = size // 2, size // 2
        self.light = self._fresh(*(target or middle))
        self.cells = [list(column) for column in self.light]

    @property
    def values(self):
        """(size, size) int32, top row first, as a file has it."""
        return np.array(self.cells, np.int32).T

    def draw_wall(self, x, y):
        if self._is_inner(x, y) and self.cells[x][y] > 0:
            if self.noise:
                self._disturb(x, y)
            self.cells[x][y] = WALL

    def erase_cell(self, x, y):
        if self._is_inner(x, y):
            self.cells[x][y] = self.light[x][y]  # the wall's effect on other cells stays

    def erase_rectangle(self, x0, y0, x1, y1):
        """Corners between cells: x0 <= x < x1, y0 <= y < y1, in either order."""
        (x0, x1), (y0, y1) = sorted((x0, x1)), sorted((y0, y1))
        for y in range(y0, y1):
            for x in range(x0, x1):
                self.cells[x][y] = self.light[x][y]
        if self.noise:
            self._remove_noise()
            self._add_noise()

    def move_target(self, x, y):
        if not self._is_inner(x, y):
            return
        fresh = self._fresh(x, y)
        self.light = self._fresh(x, y)
        for row in range(1, self.size - 1):
            for column in range(1, self.size - 1):
                if self.cells[column][row] == WALL:
                    fresh[column][row] = (
                        WALL  # even where the target should be: then there is no target
                    )
        self.cells = fresh
        if self.noise:
            self._add_noise()

    def switch_noise(self, on):
        if on:
            self.noise = True
            self._add_noise()
        else:
            self._remove_noise()
            self.noise = False

    def _is_inner(self, x, y):
        return 0 < x < self.size - 1 and 0 < y < self.size - 1

    def _fresh(self, target_x, target_y):
        return [
            [
                (x - target_x) * (x - target_x) + (y - target_y) * (y - target_y)
                if self._is_inner(x, y)
                else WALL
                for y in range(self.size)
            ]
            for x in range(self.size)
        ]

    def _disturb(self, wall_x, wall_y):
        left = 1 - wall_x if wall_x - REACH < 1 else -REACH
        right = REACH if wall_x + REACH < self.size - 2 else self.size - 2 - wall_x
        up = 1 - wall_y if wall_y - REACH < 1 else -REACH
        down = REACH if wall_y + REACH < self.size - 2 else self.size - 2 - wall_y
        for y in range(wall_y + up, wall_y + down + 1):
            for x in range(wall_x + left, wall_x + right + 1):
                if self.cells[x][y] > 0:
                    if self.cells[x][y] > self.light[wall_x][wall_y]:
                        self.cells[x][y] = int(1.5 * self.light[x][y])
                    elif int(0.9 * self.light[x][y]) != 0:
                        self.cells[x][y] = int(0.9 * self.light[x][y])

    def _add_noise(self):
        for row in range(1, self.size - 1):
            for column in range(1, self.size - 1):
                if self.cells[column][row] == WALL:
                    self._disturb(column, row)

    def _remove_noise(self):
        for row in range(1, self.size - 1):
            for column in range(1, self.size - 1):
                if self.cells[column][row] != WALL:
                    self.cells[column][row] = self.light[column][row]
