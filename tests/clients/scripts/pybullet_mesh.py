"""Load a mesh as a body that collides with its exact shape, not its hull; print the lengths of
rays.
"""

import json
import sys
from pathlib import Path

import pybullet

path, rays, z = sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), float(sys.argv[3])
REACH = 10.0  # m: farther than any wall

pybullet.connect(pybullet.DIRECT)
shape = pybullet.createCollisionShape(
    pybullet.GEOM_MESH, fileName=path, flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH
)  # fmt: skip
pybullet.createMultiBody(0, shape)
begins = [[x, y, z] for x, y, _, _ in rays]
ends = [[x + REACH * along, y + REACH * across, z] for x, y, along, across in rays]
hits = pybullet.rayTestBatch(begins, ends)
print(json.dumps({"rays": [REACH * hit[2] for hit in hits]}))
