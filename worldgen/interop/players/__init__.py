"""Scripts that are exported along with worlds that change.

Each is a separate program, and worldgen imports none of them.
"""
