"""Prepare runs for drawing over their worlds."""
