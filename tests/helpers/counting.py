"""Count calls of a controller where nothing that compares its state can see them."""

_COUNTS = {"calls": 0}

IS_ODD = False
"""Whether a controller shall behave oddly."""


def count() -> None:
    """Count a call."""
    _COUNTS["calls"] += 1


def calls() -> int:
    """Return how many calls there were."""
    return _COUNTS["calls"]


everything = calls


def is_odd() -> bool:
    """Return True if a controller shall behave oddly."""
    return IS_ODD
