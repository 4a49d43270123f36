"""Oracles: each looks at a trial, a run in a proved world, and returns a violation or nothing.

Every run meets the oracle of its verdict. A user asks for others by name (``--oracle``): a function
    ``oracle(trial)``,
or ``oracle(trial, number)``, that returns what it finds, a table of facts, or ``None``. It is found
by its entry point in ``worldgen.oracles``, as ``package.module:name``, or as ``./file.py:name``.

Contents:
    Trial: what an oracle judges: a world, a run in it, and the means to run it again.
    Violation: what an oracle finds.
    Oracle: the interface, ``check(trial) -> Violation | None``.
    VERDICT, BREACH: the oracles that every run meets.
    verdict_oracle: which of the two judges runs in a world.
    NamedOracle: an oracle as ``--oracle NAME`` or ``--oracle NAME=NUMBER`` asks for it.
    ORACLES: finds such functions by name.
"""

from fuzz.oracles.by_verdict import BREACH, VERDICT, verdict_oracle
from fuzz.oracles.named import ORACLES, NamedOracle
from fuzz.oracles.oracle import Oracle
from fuzz.oracles.trial import Trial
from fuzz.violation import Violation

__all__ = [
    "BREACH",
    "ORACLES",
    "VERDICT",
    "NamedOracle",
    "Oracle",
    "Trial",
    "Violation",
    "verdict_oracle",
]
