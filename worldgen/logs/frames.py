"""Poses over time in frames that move against each other, such as ROS's map, odom and base_link."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from worldgen.support.arrays import Floats

# Frames that a chain to its root may have; more are a circle.
_DEEPEST = 100


@dataclass(frozen=True, eq=False)
class Track:
    """Poses in the plane over time: of a robot, or of one frame in another.

    Args:
        frame: The frame that they are in.
        times: (n,) s, rising.
        x: (n,) m.
        y: (n,) m.
        yaw: (n,) rad.
    """

    frame: str
    times: Floats
    x: Floats
    y: Floats
    yaw: Floats

    @classmethod
    def of(cls, frame: str, rows: Iterable[tuple[float, float, float, float]]) -> Track:
        """Return the track of rows of time, x, y and yaw, sorted, the last one of each time."""
        latest = {row[0]: row for row in rows}
        table = np.array(sorted(latest.values()), np.float64).reshape(-1, 4)
        return cls(frame, *np.ascontiguousarray(table.T))

    def at(self, times: Floats) -> Track:
        """Return the latest pose at each time, the first one before it."""
        row = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, None)
        return Track(self.frame, times, self.x[row], self.y[row], self.yaw[row])

    def then(self, inner: Track) -> Track:
        """Return poses of a frame with these poses, at the same times, in this track's frame."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return Track(
            self.frame,
            self.times,
            self.x + c * inner.x - s * inner.y,
            self.y + s * inner.x + c * inner.y,
            self.yaw + inner.yaw,
        )

    def inverse(self, frame: str) -> Track:
        """Return the poses of this track's frame in the frame that has these poses."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return Track(
            frame, self.times, -c * self.x - s * self.y, s * self.x - c * self.y, -self.yaw
        )


@dataclass(frozen=True)
class Frames:
    """How frames lie to each other: each one in its parent, over time.

    Args:
        parents: The poses of each frame in another one.
    """

    parents: dict[str, Track] = field(default_factory=dict)

    def chain(self, frame: str) -> list[str]:
        """Return a frame and those above it; the last one is the root."""
        found = [frame]
        while found[-1] in self.parents and len(found) < _DEEPEST:
            found.append(self.parents[found[-1]].frame)
        return found

    def are_connected(self, frame: str, other: str) -> bool:
        """Return True if it is known how two frames lie to each other."""
        return frame == other or self.chain(frame)[-1] == self.chain(other)[-1]

    def pose_of(self, frame: str, other: str, times: Floats) -> Track:
        """Return the poses, at some times, of a frame in another one that it is connected to."""
        own, outer = self._in_root(frame, times), self._in_root(other, times)
        return outer.inverse(other).then(own)

    def moved(self, track: Track, frame: str) -> Track:
        """Return a track in another frame that its own one is connected to."""
        if track.frame == frame:
            return track
        return self.pose_of(track.frame, frame, track.times).then(track)

    def times_of(self, frame: str, other: str) -> Floats:
        """Return the times at which a frame moves in another one above it: its fastest link's."""
        chain = self.chain(frame)
        links = [self.parents[name].times for name in chain[: chain.index(other)]]
        return max(links, key=len) if links else np.zeros(0)

    def _in_root(self, frame: str, times: Floats) -> Track:
        zero = np.zeros(len(times))
        *links, root = self.chain(frame)
        found = Track(root, times, zero, zero, zero)
        for name in reversed(links):
            found = found.then(self.parents[name].at(times))
        return found
