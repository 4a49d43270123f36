"""Decide worlds that change with time: a timed witness, or a confinement."""
