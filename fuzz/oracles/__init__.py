"""Oracles that a user asks for: each judges a run beyond its verdict, and may run the controller again.

An oracle is a function ``oracle(trial)``, or ``oracle(trial, number)``, that returns its objection, a table of
evidence, or ``None``. It is found by its entry point in ``worldgen.oracles``, as ``package.module:name``, or as
``./file.py:name``.

Contents:
    Trial: what an oracle judges: a world, a run in it, and the way to run it again.
    Asked: an oracle as ``--oracle NAME`` or ``--oracle NAME=NUMBER`` asks for it.
    objection_in_words: what an oracle said.
    ORACLES: finds oracles by name.
"""

from fuzz.oracles.asking import ORACLES, Asked, objection_in_words
from fuzz.oracles.trial import Trial

__all__ = ["ORACLES", "Asked", "Trial", "objection_in_words"]
