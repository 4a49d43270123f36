"""Twelve controllers of real kinds, and how soon a campaign finds the fault planted in each."""

# The words of a round that takes seconds; the gate runs it.
TINY = ("--only", "smoother", "--budget", "2", "--peer-budget", "0.1", "--workers", "1")
