"""Loads a mesh or scene.

Print whether its boxes are watertight, their volume, where rays end, and the contents of nodes.
"""

import json
import sys
from pathlib import Path

import numpy as np
import trimesh

path, rays, z = sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), float(sys.argv[3])
y_up = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]) if path.endswith("glb") else np.eye(3)


def parts(loaded):
    """The boxes, in the world's frame."""
    if path.endswith("stl"):
        return [trimesh.Trimesh(*shell(corners)) for corners in loaded.triangles.reshape(-1, 36, 3)]
    meshes = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    back = np.eye(4)
    back[:3, :3] = y_up.T
    return [
        mesh.apply_transform(back) for mesh in meshes if "disc" not in mesh.metadata.get("node", "")
    ]


def shell(corners):
    return corners, np.arange(36).reshape(12, 3)


def places(scene):
    """Start, target, the start's x axis and the extras, in the world's frame."""
    frames = {name: scene.graph.get(name)[0] for name in ("start", "target")}
    said = {name: (y_up.T @ frame[:3, 3]).tolist() for name, frame in frames.items()}
    edges = scene.graph.transforms.edge_data
    extras = next(edge["metadata"] for (_, child), edge in edges.items() if child == "worldgen")
    return {**said, "facing": (y_up.T @ frames["start"][:3, 0]).tolist(), "extras": extras}


loaded = trimesh.load(path, process=not path.endswith("stl"), split_objects=True)
boxes = parts(loaded)
together = trimesh.util.concatenate(boxes)
answer = {
    "boxes": len(boxes),
    "watertight": all(
        box.is_watertight and box.is_winding_consistent and box.volume > 0 for box in boxes
    ),
    "volume": float(sum(box.volume for box in boxes)),
    "bounds": together.bounds.tolist(),
}
if rays:
    begins = np.array([[x, y, z] for x, y, _, _ in rays])
    along = np.array([[dx, dy, 0.0] for _, _, dx, dy in rays])
    hits, which, _ = together.ray.intersects_location(begins, along, multiple_hits=False)
    lengths = np.full(len(rays), np.inf)
    lengths[which] = np.linalg.norm(hits - begins[which], axis=1)
    answer["rays"] = lengths.tolist()
if path.endswith("glb"):
    answer["places"] = places(loaded)
print(json.dumps(answer))
