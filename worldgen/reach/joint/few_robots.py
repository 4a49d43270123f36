"""How many robots are few: the limits by which a fleet is placed in one way or another."""

from __future__ import annotations

# Up to this many robots are all placed before their paths are planned, so that each may have to
# make way for any other. More are placed one by one at first, each with a path around those before
# it.
FEW_ROBOTS = 10
# Limit on robots whose paths are searched together if a search one by one finds none. The search
# rarely succeeds with more.
MOST_TOGETHER = 50
