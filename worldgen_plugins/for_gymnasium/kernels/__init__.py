"""Compiled: episodes of many robots in lockstep, with observations and rewards; numbers and arrays only."""
