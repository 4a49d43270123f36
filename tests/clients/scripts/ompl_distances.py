"""Prints the lengths of OMPL's Dubins and Reeds-Shepp paths between pairs of poses."""

import json
import sys
from pathlib import Path

from ompl import base


def length(space, pair):
    states = [space.allocState(), space.allocState()]
    for state, (x, y, heading) in zip(states, pair, strict=True):
        state.setXY(x, y)
        state.setYaw(heading)
    return space.distance(*states)


asked = json.loads(Path(sys.argv[1]).read_text())
spaces = {"dubins": base.DubinsStateSpace, "reeds_shepp": base.ReedsSheppStateSpace}
print(
    json.dumps(
        {
            name: [length(kind(one["radius"]), one["poses"]) for one in asked]
            for name, kind in spaces.items()
        }
    )
)
