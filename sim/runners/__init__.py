"""Run controllers of every kind: pack the world for the C core, run it, and read the results."""
