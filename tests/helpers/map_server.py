"""What ROS map_server publishes for a pair of files, according to its documentation.

Shares nothing with the product's reader.
"""

import numpy as np
import yaml
from PIL import Image


def published(greys, *, negate, occupied_thresh, free_thresh, mode):
    """OccupancyGrid values, top row first, of greys without transparency."""
    if mode == "raw":
        return np.where(greys <= 100, greys, -1).astype(int)
    filled = greys / 255.0 if negate else (255.0 - greys) / 255.0
    between = np.full(greys.shape, -1)
    if mode == "scale":
        between = np.rint(100 * (filled - free_thresh) / (occupied_thresh - free_thresh)).astype(
            int
        )
    return np.select([filled >= occupied_thresh, filled <= free_thresh], [100, 0], between)


def published_map(path):
    """The message's info and data: resolution, origin, and values with row 0 the lowest y."""
    keys = yaml.safe_load(path.read_text())
    with Image.open(path.parent / keys["image"]) as image:
        greys = np.asarray(image).astype(float)
    rules = {key: keys[key] for key in ("negate", "occupied_thresh", "free_thresh", "mode")}
    return keys["resolution"], keys["origin"], published(greys, **rules)[::-1]


def occupied_at(path, x, y):
    """Return the published map's value at a point, m; None outside."""
    resolution, (left, low, yaw), data = published_map(path)
    assert yaw == 0.0
    column, row = int((x - left) // resolution), int((y - low) // resolution)
    inside = 0 <= row < data.shape[0] and 0 <= column < data.shape[1]
    return int(data[row, column]) if inside else None
