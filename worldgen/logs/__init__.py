"""Recorded trajectories and plans, in the files that people have."""
