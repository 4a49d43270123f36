"""Faults in the controllers that follow walls by touch: Bug1 and Bug2.

The functions are in ``benchmarks/faults/faults_by_touch.c``.
"""

from __future__ import annotations

from sim.controllers.library.bug1 import bug1
from sim.controllers.library.bug2 import bug2
from sim.verdict import Verdict

from .planting import planted

bug1_keeps_the_last_place = planted(
    "bug1-keeps-the-last-place",
    bug1,
    Verdict.LOOP,
    "Remembers the last place along the wall instead of the nearest: the comparison is missing.",
)
bug1_hit_point_moves_along = planted(
    "bug1-hit-point-moves-along",
    bug1,
    Verdict.STALLED,
    "Sets the hit point again at each step along the wall, so it never returns to it.",
)
bug1_stale_round_is_over = planted(
    "bug1-stale-round-is-over",
    bug1,
    Verdict.LOOP,
    "The flag of a finished round is not cleared at the second obstacle, which then counts as "
    "explored.",
)
bug1_lost_wall_wrong_side = planted(
    "bug1-lost-wall-wrong-side",
    bug1,
    Verdict.LOOP,
    "Switches sides whenever it loses the wall at a corner: the sign of the turn is wrong there.",
)
bug1_turn_not_wrapped = planted(
    "bug1-turn-not-wrapped",
    bug1,
    Verdict.LOOP,
    "The turn is the difference of two headings, not wrapped at pi, so the robot may turn the long "
    "way.",
)
bug2_leaves_by_equality = planted(
    "bug2-leaves-by-equality",
    bug2,
    Verdict.LOOP,
    "Leaves the wall only exactly on the line: floats are compared for equality.",
)
bug2_stale_line = planted(
    "bug2-stale-line",
    bug2,
    Verdict.LOOP,
    "The hit point and the line of the first obstacle are kept for all later ones.",
)
bug2_hit_point_not_kept = planted(
    "bug2-hit-point-not-kept",
    bug2,
    Verdict.LOOP,
    "The hit point is forgotten at a corner, so the line then begins where the robot is.",
)
bug2_leaves_behind_the_hit_point = planted(
    "bug2-leaves-behind-the-hit-point",
    bug2,
    Verdict.LOOP,
    "Leaves wherever it crosses the line: the check that the place is nearer than the hit point is "
    "missing.",
)
bug2_bearing_in_degrees = planted(
    "bug2-bearing-in-degrees",
    bug2,
    Verdict.LOOP,
    "The bearing of a contact on the right is in degrees.",
)
bug2_turn_not_wrapped = planted(
    "bug2-turn-not-wrapped",
    bug2,
    Verdict.LOOP,
    "The turn is the difference of two headings, not wrapped at pi, so the robot may turn the long "
    "way.",
)
