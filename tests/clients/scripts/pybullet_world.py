"""Loads a world into PyBullet.

Cast rays, drop a sphere and drive it, and check that static bodies stay in place.
"""

import json
import sys
from pathlib import Path

import pybullet as p

path, request = sys.argv[1], json.loads(Path(sys.argv[2]).read_text())
p.connect(p.DIRECT)
p.setGravity(0, 0, -9.8)
bodies = p.loadSDF(path)
before = [p.getBasePositionAndOrientation(body) for body in bodies]
names = [p.getBodyInfo(body)[1].decode() for body in bodies]
masses = [p.getDynamicsInfo(body, -1)[0] for body in bodies]

reach, z = request["reach"], request["z"]
found = []
for x, y, along, across in request["rays"]:
    _, _, share, hit, _ = p.rayTest([x, y, z], [x + reach * along, y + reach * across, z])[0]
    found.append([share * reach, hit[0], hit[1]])
x, y, height, radius = request["drop"]
ball = p.createMultiBody(
    0.1, p.createCollisionShape(p.GEOM_SPHERE, radius=radius), basePosition=[x, y, height]
)
for _ in range(960):
    p.stepSimulation()
fallen = p.getBasePositionAndOrientation(ball)[0]
for _ in range(480):
    p.resetBaseVelocity(ball, request["push"])
    p.stepSimulation()
driven = p.getBasePositionAndOrientation(ball)[0]
after = [p.getBasePositionAndOrientation(body) for body in bodies]
p.disconnect()
print()  # the loader's warnings do not end with a newline
said = {
    "names": names,
    "masses": masses,
    "still": before == after,
    "rays": found,
    "drop": fallen,
    "driven": driven,
}
print(json.dumps(said))
