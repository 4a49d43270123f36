"""Rules for what a user gives: numbers within bounds, known names, expressions, a world's robots.

A broken rule is a message from `worldgen.errors`.
"""
