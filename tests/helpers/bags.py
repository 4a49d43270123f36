"""Bags that tests write: a room with a wall, and a robot that drives in it."""

import importlib.util
import itertools
import math

import numpy as np

SECOND = 10**9
DATE = 1_600_000_000
WHY_NOT = "" if importlib.util.find_spec("rosbags") else "no rosbags: pip install 'worldgen[bags]'"
KINDS = ("mcap", "db3", "bag")
TRANSFORMS = "tf2_msgs/msg/TFMessage"
GRID = "nav_msgs/msg/OccupancyGrid"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
POLYGON = "geometry_msgs/msg/PolygonStamped"
UPDATE = "map_msgs/msg/OccupancyGridUpdate"
_DEFINED = {
    TRANSFORMS: "geometry_msgs/TransformStamped[] transforms\n",
    UPDATE: "std_msgs/Header header\nint32 x\nint32 y\nuint32 width\nuint32 height\nint8[] data\n",
}


def stamped(time, frame, **values):
    """Return the fields of a message with a header; the time is in s."""
    whole = int(time)
    stamp = {"sec": DATE + whole, "nanosec": round((time - whole) * SECOND)}
    return {"header": {"stamp": stamp, "frame_id": frame}, **values}


def pose(x, y, yaw=0.0):
    """Return the fields of a pose."""
    turn = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"position": {"x": x, "y": y}, "orientation": turn}


def transform(time, frame, child, x, y, yaw=0.0):
    """Return the fields of a message on /tf."""
    at = pose(x, y, yaw)
    move = {"translation": at["position"], "rotation": at["orientation"]}
    return {"transforms": [stamped(time, frame, child_frame_id=child, transform=move)]}


def grid(cells, resolution=0.1, origin=(-2.0, -3.0, 0.0), frame="map", time=0.0):
    """Return the fields of a map; row 0 of the cells is the lowest."""
    height, width = np.shape(cells)
    info = {"width": width, "height": height, "resolution": resolution, "origin": pose(*origin)}
    return stamped(time, frame, info=info, data=np.asarray(cells, np.int8).ravel())


def room():
    """Return cells of a room of 6 x 4 m with a wall at x = 3 m up to y = 2.5 m, for :func:`grid`."""
    cells = np.zeros((40, 60), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    cells[:25, 30] = 100
    return cells


def drive(through=False):
    """Return messages of a robot that drives from (1, 1.05) m of the room around the wall, or into it.

    The map's frame has its origin at (-2, -3) m; odometry begins at the robot.
    """
    corners = [(-1.0, -1.95), (3.0, -1.95)] if through else [(-1.0, -1.95), (-1.0, 0.2), (3.0, 0.2)]
    places = [
        (a[0] + (b[0] - a[0]) * k / 20, a[1] + (b[1] - a[1]) * k / 20)
        for a, b in itertools.pairwise(corners)
        for k in range(20)
    ] + corners[-1:]
    found = [
        ("/map", GRID, 0.0, grid(room())),
        ("/tf_static", TRANSFORMS, 0.0, transform(0, "map", "odom", -1.0, -1.95, math.pi / 2)),
        ("/goal_pose", POSE, 0.1, stamped(0.1, "map", pose=pose(3.0, 0.2))),
    ]
    # The odometry's frame is turned by a quarter: its x axis is the map's y axis.
    for k, (x, y) in enumerate(places):
        time = 0.2 * k
        at = (y + 1.95, -(x + 1.0))
        values = {"child_frame_id": "base_link", "pose": {"pose": pose(*at)}}
        found.append(("/odom", ODOMETRY, time, stamped(time, "odom", **values)))
        found.append(("/tf", TRANSFORMS, time, transform(time, "odom", "base_link", *at)))
    # Nav2 publishes the footprint at the robot's place.
    x, y = places[-1]
    outline = [
        {"x": x + dx, "y": y + dy}
        for dx, dy in ((-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1), (0.2, 0.1))
    ]
    # The robot's heading in the map is the turn of odometry.
    outline = [{"x": x - (p["y"] - y), "y": y + (p["x"] - x)} for p in outline]
    values = {"polygon": {"points": outline}}
    found.append(("/footprint", POLYGON, time, stamped(time, "map", **values)))
    return found


def write_bag(path, messages, kind="mcap", compression=""):
    """Write messages (topic, type, time in s, fields) as a bag; return the file, or the folder.

    The compression is ``bz2`` or ``lz4`` of ROS 1, or ``file``, ``message`` or ``storage`` of ROS 2.
    """
    from rosbags import rosbag1, rosbag2
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    for name, text in _DEFINED.items():
        if name not in store.types:
            store.register(get_types_from_msg(text, name))
    if kind == "bag":
        writer, encode = rosbag1.Writer(path.with_suffix(".bag")), store.serialize_ros1
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
        encode = store.serialize_cdr
    if compression and kind == "bag":
        writer.set_compression(writer.CompressionFormat[compression.upper()])
    elif compression:
        mode = rosbag2.CompressionMode[compression.upper()]
        writer.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, name, time, fields in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            data = encode(_built(store, name, fields), name)
            writer.write(connections[topic], DATE * SECOND + round(time * SECOND), data)
    if kind == "bag":
        return path.with_suffix(".bag")
    return next(path.glob("*.mcap")) if kind == "mcap" and not compression else path


def _built(store, name, fields):
    """Return a message with these fields; the others are 0 or empty."""
    values = {}
    for field, node in store.fielddefs[name][1]:
        values[field] = _value(store, node, fields.get(field))
    return store.types[name](**values)


def _value(store, node, given):
    kind, argument = int(node[0]), node[1]
    if kind == 1:
        empty = {"string": "", "bool": False}.get(argument[0], 0)
        return empty if given is None else given
    if kind == 2:
        return _built(store, argument, given or {})
    inner, count = argument
    if int(inner[0]) == 2:
        return [_built(store, inner[1], one) for one in given or []]
    types = {"int8": np.int8, "float64": np.float64}
    return np.zeros(count) if given is None else np.asarray(given, types[inner[1][0]])
