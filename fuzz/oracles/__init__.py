"""Oracles: each judges a trial, which is a run in a proved world, and may return a violation.

The oracle of the verdict judges every run. Users add others by name (``--oracle``): a function
``oracle(trial)`` or ``oracle(trial, number)`` that returns ``None``, or a table of the facts that
it found. It is looked up as an entry point in ``worldgen.oracles``, as ``package.module:name`` or
as ``./file.py:name``.

Contents:
    Trial: The subject of an oracle: a world, a run in it, and the means to run it again.
    Violation: The result if an oracle finds something wrong.
    Oracle: The interface, ``check(trial) -> Violation | None``.
    VERDICT, BREACH: The two oracles that judge every run.
    verdict_oracle: Chooses between these two for a world.
    NamedOracle: An oracle requested by ``--oracle NAME`` or ``--oracle NAME=NUMBER``.
    ORACLES: The registry that finds such functions by name.
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
