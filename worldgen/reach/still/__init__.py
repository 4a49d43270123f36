"""Decide worlds that do not change: a witness, or a cut."""
