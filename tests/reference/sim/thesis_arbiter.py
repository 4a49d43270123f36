"""Which behaviour is in charge of the thesis's robot, and what it does.

A state machine without any geometry. :func:`select_behaviour` lets a behaviour take control; the
caller then sets the new target heading if collide has just taken over, and checks whether the robot
already points there. :func:`run_behaviour` lets the one in charge act, and returns what the wheels
do.

The arbiter is missing from the thesis's listing, and is reconstructed from its prose. In reading
A0, the behaviour that takes control keeps it until it gives it up, and acts in the same tick in
which it took over. A1 does not act in that tick; A2 acts first and then selects; A3 acts, selects
and acts. A4 asks the one in charge in every tick whether it would take control, and so restarts it;
A6 does that only for collide. In A5 no behaviour is in charge for longer than a tick.
``INTERRUPTIBLE`` is what the thesis proposes as further work: every tick decides again, and a
collision restarts the escape, whatever is in charge; until then an escape, or a drive, continues
where it was.
"""

from __future__ import annotations

# Behaviours.
IDLE, COLLIDE, SEEK, DRIVE = -1, 0, 1, 2

# Readings of the arbiter.
A0, A1, A2, A3, A4, A5, A6, INTERRUPTIBLE = 0, 1, 2, 3, 4, 5, 6, 7

# What the wheels do: stop and turn towards the target heading; drive at the robot's speed; drive at
# the speed from before the collision; stop; keep the speed, whatever it is.
TURN, GO, RESUME, HALT, COAST = 0, 1, 2, 3, 4


def select_behaviour(
    reading: int,
    behaviour: int,
    ticks: int,
    collision: bool,
    at_signal: bool,
    collide_ticks: int,
    drive_ticks: int,
) -> tuple[int, int, bool]:
    """Lets a behaviour take control, in the order drive, seek, collide, if the reading allows it.

    Args:
        reading: Reading of the arbiter, ``A0`` to ``INTERRUPTIBLE``.
        behaviour: The behaviour in charge.
        ticks: Its counter.
        collision: Whether the last move hit a wall.
        at_signal: Whether the target heading already is the signal's direction.
        collide_ticks: Counter that collide starts with.
        drive_ticks: Counter that drive starts with.

    Returns:
        The behaviour in charge now, its counter, and whether it has just taken control. If that is
        collide, the caller remembers the speed, stops, and sets the target heading by its rule.
    """
    if reading == INTERRUPTIBLE:
        if collision:
            return COLLIDE, collide_ticks, True
        if behaviour == COLLIDE or (behaviour == DRIVE and ticks >= 0):
            return behaviour, ticks, False
    elif behaviour != IDLE and reading != A5:
        if collision and behaviour == COLLIDE and reading in (A4, A6):
            return COLLIDE, collide_ticks, True
        if not collision and at_signal and behaviour == DRIVE and reading == A4:
            return DRIVE, drive_ticks, True
        return behaviour, ticks, False
    if collision:
        return COLLIDE, collide_ticks, True
    if at_signal:
        return DRIVE, drive_ticks, True
    return SEEK, 0, True


def run_behaviour(
    behaviour: int, ticks: int, collision: bool, turned: bool
) -> tuple[int, int, int]:
    """Lets the behaviour in charge act.

    Args:
        behaviour: ``COLLIDE``, ``SEEK`` (the caller has made the signal's direction its target) or
            ``DRIVE``.
        ticks: Its counter.
        collision: Whether the last move hit a wall.
        turned: Whether the robot points along its target heading.

    Returns:
        What the wheels do, the behaviour in charge afterwards, and its counter.
    """
    if behaviour == DRIVE:
        if ticks >= 0 and not collision:
            return GO, DRIVE, ticks - 1
        return COAST, IDLE, 0
    if not turned:
        return TURN, behaviour, ticks
    if behaviour == SEEK:
        return HALT, IDLE, 0
    if ticks >= 0:
        return RESUME, COLLIDE, ticks - 1
    return COAST, IDLE, 0
