"""Runs of every kind of controller: pack the world for the C core, run, read the result."""
