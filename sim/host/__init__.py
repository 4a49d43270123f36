"""A Python controller served as a program: ``python -m sim.host ./mine.py:Robot``."""
