"""Scripts that go out beside worlds that change.

Each is a program of its own, and worldgen imports none of them.
"""
