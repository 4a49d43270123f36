"""Stored failures run again: does each still fail, how, or does the robot arrive now."""
