"""Lanes: where a campaign's scenarios come from. Each looks for runs that fail and brings them to the one door.

Contents:
    lane_of: the lane of a name.
    Task: what a lane gets.
"""

from __future__ import annotations

from collections.abc import Callable

from fuzz.lanes import boundary, drawn
from fuzz.lanes.database import DATABASE
from fuzz.lanes.plan import lanes_for
from fuzz.lanes.task import Task

__all__ = ["Lane", "Task", "lane_of"]

Lane = Callable[[Task], None]
"""Does a unit's work: counts its runs and hands what fails to the task's door."""


def _search_again(task: Task) -> None:
    lanes = [name for name in lanes_for(task.config, task.memory) if name not in _OWN]
    drawn.search_again(task, lanes)


_OWN: dict[str, Lane] = {boundary.BOUNDARY: boundary.search, DATABASE: _search_again}


def lane_of(name: str) -> Lane:
    """The lane of a name; that of a family, of ``features``, ``sealed`` and ``map`` lets Hypothesis draw."""
    return _OWN.get(name, drawn.search)
