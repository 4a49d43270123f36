"""Opens and validates a stage.

Print the places of its colliding cubes, and start, target and custom data.
"""

import json
import sys

from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation

stage = Usd.Stage.Open(sys.argv[1])
validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
guides = [
    str(prim.GetPath())
    for prim in stage.Traverse()
    if UsdGeom.Imageable(prim).ComputePurpose() == "guide"
]


def bounds(prim):
    box = cache.ComputeWorldBound(prim).ComputeAlignedRange()
    return [list(box.GetMin()), list(box.GetMax())]


def frame(name):
    prim = stage.GetPrimAtPath(f"/World/{name}")
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())


custom = stage.GetDefaultPrim().GetCustomDataByKey("worldgen")
answer = {
    "validators": len(validators),
    "objections": [
        error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(stage)
    ],
    "up": UsdGeom.GetStageUpAxis(stage),
    "unit": UsdGeom.GetStageMetersPerUnit(stage),
    "default": str(stage.GetDefaultPrim().GetPath()),
    "colliders": [
        bounds(prim) for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)
    ],
    "guides": guides,
    "start": list(frame("start").ExtractTranslation()),
    "target": list(frame("target").ExtractTranslation()),
    "facing": list(frame("start").TransformDir((1, 0, 0))),
    "custom": {
        name: value if isinstance(value, float) else list(value) for name, value in custom.items()
    },
}
print(json.dumps(answer))
