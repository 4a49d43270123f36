"""Exported files as maps of the plane, read without any of our code:

whether a point is solid, and where the start is.
"""

import io
import json
import re
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
import shapely
import yaml
from PIL import Image

from tests.helpers.exported_meshes import glb_parts, stl_triangles


@dataclass(frozen=True)
class Plan:
    """A file's plane.

    Args:
        shape: The solid part, as a shapely geometry, m.
        start: x and y, m, if the file has it as coordinates.
    """

    shape: object
    start: tuple[float, float] | None = None

    def solid(self, x, y):
        """Whether the point is solid."""
        return bool(shapely.intersects_xy(self.shape, x, y))


def rectangles(boxes):
    """Return the union, not dissolved, of (n, 4) rectangles: centres and sides."""
    cx, cy, length, width = np.array(boxes, float).reshape(-1, 4).T
    sides = (cx - length / 2, cy - width / 2, cx + length / 2, cy + width / 2)
    return shapely.geometrycollections(shapely.box(*sides))


def pixels(dark, left, bottom, right, top):
    """Squares of a picture, the top row first, stretched over a rectangle."""
    rows, columns = np.nonzero(dark)
    side_x, side_y = (right - left) / dark.shape[1], (top - bottom) / dark.shape[0]
    middles = (left + (columns + 0.5) * side_x, top - (rows + 0.5) * side_y)
    return rectangles(
        np.stack([*middles, *np.broadcast_arrays(side_x, side_y, columns)[:2]], axis=1)
    )


def numbers(text):
    return [float(word) for word in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]


def sdf(files):
    root = ElementTree.fromstring(next(iter(files.values())))
    boxes = [
        (*numbers(one.find("pose").text)[:2], *numbers(one.find("geometry/box/size").text)[:2])
        for one in root.iterfind(".//model[@name='walls']/link/collision")
    ]
    return Plan(
        rectangles(boxes), tuple(numbers(root.find(".//model[@name='start']/pose").text)[:2])
    )


def barn(files):
    root = ElementTree.fromstring(next(iter(files.values())))
    posts = [
        shapely.Point(numbers(model.find("pose").text)[:2]).buffer(
            float(model.find(".//collision//radius").text)
        )
        for model in root.iterfind(".//model")
        if model.find(".//collision//radius") is not None
    ]
    return Plan(
        shapely.GeometryCollection(posts),
        tuple(numbers(root.find(".//model[@name='start']/pose").text)[:2]),
    )


def mjcf(files):
    root = ElementTree.fromstring(next(iter(files.values())))
    boxes = [
        (*numbers(geom.get("pos"))[:2], *(2 * half for half in numbers(geom.get("size"))[:2]))
        for geom in root.iterfind("worldbody/geom[@type='box']")
    ]
    return Plan(
        rectangles(boxes), tuple(numbers(root.find(".//site[@name='start']").get("pos"))[:2])
    )


def footprints(corners):
    """Of (n, corners, 3) shells."""
    low, high = corners.min(axis=1)[:, :2], corners.max(axis=1)[:, :2]
    return rectangles(np.concatenate([(low + high) / 2, high - low], axis=1))


def stl(files):
    corners = stl_triangles(next(iter(files.values())))["corners"]
    return Plan(footprints(corners.reshape(-1, 36, 3).astype(float)))


def obj(files):
    corners = [
        numbers(line)
        for line in next(iter(files.values())).decode().splitlines()
        if line.startswith("v ")
    ]
    return Plan(footprints(np.array(corners).reshape(-1, 8, 3)))


def glb(files):
    document, _ = glb_parts(next(iter(files.values())))
    nodes = {node["name"]: node for node in document["nodes"]}
    walls = [node for name, node in nodes.items() if name.startswith(("wall", "border"))]
    ends = [(node["translation"], node["scale"]) for node in walls]
    boxes = [(x + long / 2, -(z + deep / 2), long, deep) for (x, _, z), (long, _, deep) in ends]
    x, _, z = nodes["start"]["translation"]
    return Plan(rectangles(boxes), (x, -z))


def usd(files):
    text = next(iter(files.values())).decode()
    found = re.findall(r"xformOp:scale = \((.+)\)\n +double3 xformOp:translate = \((.+)\)", text)
    boxes = [(*numbers(at)[:2], *numbers(size)[:2]) for size, at in found]
    start = re.search(r'Xform "start".*?xformOp:translate = \((.+?)\)', text, re.DOTALL)[1]
    return Plan(rectangles(boxes), tuple(numbers(start)[:2]))


def geojson(files):
    features = json.loads(next(iter(files.values())))["features"]
    parts = {
        feature["properties"]["kind"]: shapely.geometry.shape(feature["geometry"])
        for feature in features
    }
    walls = [parts[kind] for kind in ("walls", "border") if kind in parts]
    return Plan(shapely.GeometryCollection(walls), (parts["start"].x, parts["start"].y))


def svg(files):
    root = ElementTree.fromstring(next(iter(files.values())))
    group = root.find("{*}g")
    assert group.get("transform") == "scale(1,-1)"  # y up within
    rings = []
    for path in group.iterfind("{*}path"):
        for ring in path.get("d").split("z") if path.get("class") in ("wall", "border") else ():
            at, points = [0.0, 0.0], []
            for letter, words in re.findall(r"([MHV])([^MHV]+)", ring):
                to = numbers(words)
                at = {"M": to, "H": [to[0], at[1]], "V": [at[0], to[0]]}[letter]
                points.append(at)
            rings += [shapely.Polygon(points)] if points else []
    robot = group.find("{*}circle[@class='robot']")
    shape = shapely.GeometryCollection()
    for ring in rings:  # even-odd
        shape = shape.symmetric_difference(ring)
    return Plan(shape, (float(robot.get("cx")), float(robot.get("cy"))))


def irsim(files):
    document = yaml.safe_load(next(iter(files.values())))
    boxes = [
        (*state[:2], one["shape"]["length"], one["shape"]["width"])
        for one in document.get("obstacle", ())
        for state in one["state"]
    ]
    shapes = [rectangles(boxes)]
    if "obstacle_map" in document["world"]:
        world = document["world"]
        (x, y), dark = world["offset"], picture(files[world["obstacle_map"]]) < 128
        shapes.append(pixels(dark, x, y, x + world["width"], y + world["height"]))
    return Plan(shapely.GeometryCollection(shapes), tuple(document["robot"][0]["state"][:2]))


def picture(data):
    return np.asarray(Image.open(io.BytesIO(data)).convert("L"))


def ros(files):
    document = yaml.safe_load(next(iter(files.values())))
    grey, side, (x, y, yaw) = (
        picture(files[document["image"]]),
        document["resolution"],
        document["origin"],
    )
    assert yaw == 0
    dark = (255 - grey.astype(float)) / 255 >= document["occupied_thresh"]
    return Plan(
        pixels(dark, x, y, x + grey.shape[1] * side, y + grey.shape[0] * side),
        tuple(document["worldgen"]["start"][:2]),
    )


def tiled(files):
    document = json.loads(next(iter(files.values())))
    said = {one["name"]: one["value"] for one in document["properties"]}
    tiles, places = (layer for layer in document["layers"])
    dark = np.array(tiles["data"]).reshape(document["height"], document["width"]) > 0
    x, y, side = said["origin_x"], said["origin_y"], said["cell_size"]
    top = y + document["height"] * side
    start = next(one for one in places["objects"] if one["name"] == "start")
    at = (
        x + start["x"] / document["tilewidth"] * side,
        top - start["y"] / document["tileheight"] * side,
    )
    return Plan(pixels(dark, x, y, x + document["width"] * side, top), at)


PLANS = {
    "barn": barn,
    "geojson": geojson, "glb": glb, "irsim": irsim, "irsim+walls=image": irsim, "mjcf": mjcf, "obj": obj,
    "ros": ros, "sdf": sdf, "stl": stl, "svg": svg, "tiled": tiled,
    "usd": usd,
}  # fmt: skip
"""Readers of files that have coordinates, by what is exported."""

CELLS_ONLY = {
    "micromouse",
    "minigrid",
    "movingai",
    "npy",
    "pogema",
    "pointmaze",
    "png",
    "text",
    "thesis",
}
"""Formats whose files are cells without coordinates; other tests compare these."""
