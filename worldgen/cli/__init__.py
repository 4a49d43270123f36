"""The command line: one group, filled from entry points."""
