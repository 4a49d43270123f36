"""Read what a ROS bag knows of maps, of the robot's body and of its poses.

Messages are read by the definitions of ROS's own packages, not by those in the file, so that a bag
is only data. ``rosbags`` is an extra, ``worldgen[bags]``; it is imported when a bag is opened.
"""

from __future__ import annotations

import bz2
import itertools
import math
import re
import struct
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError, WorldgenError
from worldgen.logs.frames import Frames, Track
from worldgen.plugins.installation import pip_install
from worldgen.support.arrays import Floats

MAGIC = rb"\x89MCAP0\r\n|#ROSBAG V2\.0|SQLite format 3\0|\s*rosbag2_bagfile_information:"
"""How files of bags begin: MCAP, ROS 1, a database of ROS 2, and the list of a bag's files."""
_HEADS = {b"\x89MCAP0\r\n": ".mcap", b"#ROSBAG V2.0": ".bag", b"SQLite format 3\0": ".db3"}
_METADATA = "metadata.yaml"

_MCAP = b"\x89MCAP0\r\n"
_ZSTD = b"\x28\xb5\x2f\xfd"
# Kinds of MCAP's records: the first, and the one that holds other records, compressed.
_HEADER = 1
_CHUNK = 6
# The most that compressed parts become: chunks and messages, and files, bytes.
_MOST_OF_A_CHUNK = 1 << 29
_MOST_OF_A_FILE = 1 << 30
# The most that all compressed chunks and messages of a bag become together: bytes, and times the
# bag's own size. A map that is sent again and again shrinks to a three-hundredth.
_FREE = 1 << 31
_MOST_TIMES = 300
# The list of a bag's files: its most characters and its deepest lists.
_MOST_OF_METADATA = 1 << 22
_DEEPEST = 50
_BRACKETS = re.compile(r"[\[{\]}]")
_MOST_CELLS = 1 << 28

_GRID = "nav_msgs/msg/OccupancyGrid"
_UPDATE = "map_msgs/msg/OccupancyGridUpdate"
_POLYGON = "geometry_msgs/msg/PolygonStamped"
_TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
# Messages with poses of the robot, the likeliest first.
_POSES = (
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "geometry_msgs/msg/PoseStamped",
)
_PLAN = "nav_msgs/msg/Path"
_ACTION_GOAL = "move_base_msgs/msg/MoveBaseActionGoal"
# Definitions that rosbags lacks for some versions of ROS.
_DEFINED = {
    **dict.fromkeys(_TRANSFORMS, "geometry_msgs/TransformStamped[] transforms\n"),
    _UPDATE: "std_msgs/Header header\nint32 x\nint32 y\nuint32 width\nuint32 height\nint8[] data\n",
    _ACTION_GOAL: "std_msgs/Header header\nbuiltin_interfaces/Time stamp\nstring id\n"
    "geometry_msgs/PoseStamped target\n",
}
_BASES = ("base_footprint", "base_link", "base")
# ROS's usual name for the frame of the map.
_MAP = "map"


class Grid(NamedTuple):
    """A map or a costmap.

    Args:
        frame: The frame that it is in.
        resolution: Side of a cell, m.
        origin: x and y, m, and yaw, rad, of the lower-left corner.
        cells: (height, width) int8, row 0 the lowest: -1 unknown, 0 free to 100 occupied.
    """

    frame: str
    resolution: float
    origin: tuple[float, float, float]
    cells: npt.NDArray[np.int8]


class Outline(NamedTuple):
    """A polygon, such as the robot's footprint: its corners, (n, 2) m, in a frame at a time, s."""

    frame: str
    time: float
    corners: Floats


@dataclass(frozen=True)
class Bag:
    """What matters in a bag, by topic.

    Args:
        grids: The last map or costmap of each topic, with its updates.
        poses: Poses of the robot.
        goals: The last pose of each topic that says where to go: goals, then plans.
        outlines: The last polygon of each topic.
        frames: How frames lie to each other.
        bases: Frames of the robot, the likeliest first.
    """

    grids: Mapping[str, Grid] = field(default_factory=dict)
    poses: Mapping[str, Track] = field(default_factory=dict)
    goals: Mapping[str, Track] = field(default_factory=dict)
    outlines: Mapping[str, Outline] = field(default_factory=dict)
    frames: Frames = field(default_factory=Frames)
    bases: tuple[str, ...] = _BASES

    def grid_topic(self) -> str | None:
        """Return the topic of the map, or of a costmap if there is no map."""

        def rank(topic: str) -> tuple[bool, bool, bool, str]:
            return "costmap" in topic, "local" in topic, not topic.endswith("map"), topic

        return min(self.grids, key=rank, default=None)

    @property
    def map_frame(self) -> str:
        """The frame of the map; ROS's usual one if there is no map."""
        topic = self.grid_topic()
        return _MAP if topic is None else self.grids[topic].frame

    def poses_in(self, frame: str, topic: str = "") -> tuple[str, Track]:
        """Return the robot's poses in a frame, and where they are from.

        Args:
            frame: The frame, such as the map's.
            topic: The topic to read; chosen if empty.

        Raises:
            FormatError: If there are none, or nothing says how they lie in the frame.
        """
        if topic:
            if topic not in self.poses:
                raise FormatError(
                    "no-such-topic",
                    "no poses on {topic!q}",
                    "topics with poses are {known!l:none}",
                    topic=topic,
                    known=list(self.poses),
                )
            candidates = {topic: self.poses[topic]}
        else:
            base = self._base_in(frame)
            if base is not None:
                times = self.frames.times_of(base, frame)
                return f"/tf ({frame} to {base})", self.frames.pose_of(base, frame, times)
            candidates = {**self.poses}
        for name, track in candidates.items():
            if self.frames.are_connected(track.frame, frame):
                return name, self.frames.moved(track, frame)
        if not candidates:
            raise FormatError(
                "no-poses",
                "the bag has no poses: no /tf from {frame} to {bases!l}, no Odometry and no PoseStamped",
                "record /tf, /tf_static and /odom too",
                frame=frame,
                bases=self.bases,
            )
        name, track = next(iter(candidates.items()))
        raise FormatError(
            "other-frame",
            "the poses of {topic} are in the frame {own}, and no /tf says how that lies in {frame}",
            "record /tf and /tf_static too",
            topic=name,
            own=track.frame,
            frame=frame,
        )

    def _base_in(self, frame: str) -> str | None:
        """Return the robot's frame if it moves in another one."""
        return next(
            (
                base
                for base in self.bases
                if frame in self.frames.chain(base)[1:]
                and len(self.frames.times_of(base, frame)) > 1
            ),
            None,
        )

    def goal_in(self, frame: str) -> tuple[str, tuple[float, float, float]] | None:
        """Return x, y and yaw of the last goal in a frame, with its topic, or None."""
        for topic, track in self.goals.items():
            if self.frames.are_connected(track.frame, frame):
                goal = self.frames.moved(track, frame)
                return topic, (float(goal.x[-1]), float(goal.y[-1]), float(goal.yaw[-1]))
        return None

    def footprint(self) -> tuple[str, Floats] | None:
        """Return the corners of the robot's body from its axle, (n, 2) m, with their topic, or None.

        Nav2 publishes them at the robot's place in a costmap's frame.
        """
        for topic, outline in self.outlines.items():
            if outline.frame in self.bases:
                return topic, outline.corners
            for base in self.bases:
                chain = self.frames.chain(base)
                if outline.frame in chain[1:]:
                    at = self.frames.pose_of(outline.frame, base, np.array([outline.time]))
                    c, s = math.cos(at.yaw[0]), math.sin(at.yaw[0])
                    x, y = outline.corners.T
                    return topic, np.stack([at.x + c * x - s * y, at.y + s * x + c * y], axis=1)
        return None


def is_bag(path: Path) -> bool:
    """Return True if a path is a bag: a file that begins like one, or a folder of ROS 2."""
    try:
        if path.is_dir():
            return (path / _METADATA).is_file()
        with path.open("rb") as stream:
            head = stream.read(64)
    except (OSError, ValueError):
        return False
    return _suffix(head) != "" or b"rosbag2_bagfile_information" in head


def _suffix(head: bytes) -> str:
    return next((suffix for magic, suffix in _HEADS.items() if head.startswith(magic)), "")


def read_bag(path: Path) -> Bag:
    """Read a bag of ROS 1 or ROS 2: an ``.mcap``, a ``.bag``, a ``.db3``, or a folder with these.

    Raises:
        FormatError: If it is damaged, or the extra is not installed.
    """
    try:
        with _opened(path) as messages:
            return _Collector().collect(messages)
    except FormatError as error:
        error.source = error.source or str(path)
        raise
    except WorldgenError:
        raise
    except (OSError, MemoryError) as error:
        raise FormatError.unreadable(path, OSError(str(error) or "too large")) from error
    # A damaged bag can make its parsers raise anything.
    except Exception as error:
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise FormatError(
            "damaged-bag",
            "the bag is damaged: {reason}",
            "repair it with ros2 bag reindex, rosbag reindex or mcap recover",
            reason=reason,
            source=str(path),
        ) from error


class _Message(NamedTuple):
    """A message that has not been parsed yet."""

    topic: str
    type: str
    nanoseconds: int
    parse: Callable[[], Any]


@contextmanager
def _opened(path: Path) -> Iterator[Iterator[_Message]]:
    """Open a bag and yield its messages in order of time."""
    try:
        from rosbags import rosbag1, rosbag2  # noqa: PLC0415 - an extra
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415
    except ImportError:
        raise FormatError(
            "not-installed",
            "this is a ROS bag, and rosbags is not installed",
            "{command}",
            command=pip_install("bags"),
            source=str(path),
        ) from None

    path = path.parent if path.name == _METADATA else path
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        unpacking = _Unpacking(_size(path))
        _check_files(path, folder, unpacking)
        if path.is_file():
            with path.open("rb") as stream:
                suffix = _suffix(stream.read(64))
            # rosbags goes by the name.
            if path.suffix != suffix:
                named = Path(folder) / f"bag{suffix}"
                named.symlink_to(path.resolve())
                path = named
        is_first = path.suffix == ".bag" and path.is_file()
        reader = stack.enter_context((rosbag1 if is_first else rosbag2).Reader(path))
        store = get_typestore(Stores.ROS1_NOETIC if is_first else Stores.ROS2_HUMBLE)
        for name, definition in _DEFINED.items():
            if name not in store.types:
                store.register(get_types_from_msg(definition, name))
        parse = store.deserialize_ros1 if is_first else store.deserialize_cdr
        unpack = _limit_unpacking(reader, unpacking)
        wanted = [one for one in reader.connections if one.msgtype in _Collector.TYPES]

        def messages() -> Iterator[_Message]:
            # No connections would mean all of them.
            for one, time, data in reader.messages(wanted) if wanted else ():
                whole = partial(parse, unpack(data), one.msgtype)
                yield _Message(one.topic, one.msgtype, time, whole)

        yield messages()


def _size(path: Path) -> int:
    """Return the size of a bag, bytes, without folders in its folder."""
    files = path.iterdir() if path.is_dir() else (path,)
    return sum(file.stat().st_size for file in files if file.is_file())


def _limit_unpacking(reader: Any, unpacking: _Unpacking) -> Callable[[bytes], bytes]:
    """Let a reader unpack chunks of ROS 1 to a limit only, and return how to unpack its messages."""
    for at, chunk in getattr(reader, "chunks", {}).items():
        name = chunk.decompressor.__module__.partition(".")[0]
        if name in ("bz2", "lz4"):
            reader.chunks[at] = chunk._replace(decompressor=partial(unpacking.unpack, name))
    if getattr(reader, "compression_mode", None) != "message":
        return bytes
    # Unpacked here, not by the reader, which knows no limit.
    reader.storage.metadata = reader.storage.metadata._replace(compression_mode=None)
    return partial(unpacking.unpack, "zstd")


def _check_files(path: Path, folder: str, unpacking: _Unpacking) -> None:
    """Refuse a bag that is dangerous to open: rosbags reads all files at once and to any size.

    Args:
        path: The bag.
        folder: A folder for temporary files.
        unpacking: Unpacks the chunks.

    Raises:
        FormatError: If a file is a pipe or a device, or becomes too large.
    """
    if path.is_file():
        return _check_file(path, folder, unpacking)
    with (path / _METADATA).open(encoding="utf-8", errors="replace") as lines:
        text = lines.read(_MOST_OF_METADATA)
    depths = itertools.accumulate(1 if mark in "[{" else -1 for mark in _BRACKETS.findall(text))
    if len(text) == _MOST_OF_METADATA or max(depths, default=0) > _DEEPEST:
        raise FormatError(
            "damaged-bag",
            "{name} is no list of a bag's files: it is too long or too deep",
            "repair it with ros2 bag reindex",
            name=_METADATA,
        )
    for inner in sorted(path.iterdir()):
        if not inner.is_dir():
            _check_file(inner, folder, unpacking)


def _check_file(path: Path, folder: str, unpacking: _Unpacking) -> None:
    """Refuse a file of a bag that is not an ordinary one, or becomes too large."""
    if not path.is_file():
        raise FormatError(
            "damaged-bag",
            "{name} is not an ordinary file",
            "remove it, or repair the bag with ros2 bag reindex",
            name=path.name,
        )
    with path.open("rb") as stream:
        head = stream.read(8)
        if head == _MCAP:
            _check_chunks(stream, path.stat().st_size, unpacking)
        if not head.startswith(_ZSTD):
            return
        stream.seek(0)
        with tempfile.TemporaryFile(dir=folder) as plain:
            # Another bag may be in it, so unpack it as rosbags does, but no further than allowed.
            unpacked = _zstd().open(stream, "rb")
            while block := unpacked.read(1 << 20):
                if plain.tell() + len(block) > _MOST_OF_A_FILE:
                    raise _too_large(_MOST_OF_A_FILE)
                plain.write(block)
            size = plain.tell()
            plain.seek(0)
            if plain.read(8) == _MCAP:
                _check_chunks(plain, size, unpacking)


def _too_large(most: int) -> FormatError:
    return FormatError(
        "wrong-length",
        "the bag has a compressed part that becomes more than {most} bytes, or other than it says",
        "decompress the bag with ros2 bag convert or rosbag decompress, or record it again",
        most=most,
    )


def _check_chunks(stream: IO[bytes], size: int, unpacking: _Unpacking) -> None:
    """Refuse an MCAP file with a chunk that becomes too large, before anything decompresses it.

    Raises:
        FormatError: If there is one.
    """
    at = 8
    while at + 9 <= size:
        stream.seek(at)
        kind, length = struct.unpack("<BQ", stream.read(9))
        if at + 9 + length > size:
            raise FormatError(
                "truncated",
                "the bag ends in the middle of a record: its recording was cut off",
                "repair it with mcap recover",
            )
        if kind == _HEADER:
            _check_profile(stream.read(min(length, 64)))
        if kind == _CHUNK:
            unpacked, _, named = struct.unpack("<QII", stream.read(32)[16:])
            compression = stream.read(min(named, 8)).decode("ascii", "replace")
            (packed,) = struct.unpack("<Q", stream.read(8))
            is_true = unpacked <= _MOST_OF_A_CHUNK and packed <= size and named <= 8
            if is_true and compression:
                is_true = len(unpacking.unpack(compression, stream.read(packed))) == unpacked
            if not is_true:
                raise _too_large(_MOST_OF_A_CHUNK)
        at += 9 + length


def _check_profile(header: bytes) -> None:
    """Refuse an MCAP file whose messages are not those of ROS 2, as the profile in its header says."""
    (length,) = struct.unpack("<I", header[:4])
    profile = header[4 : 4 + length].decode("utf-8", "replace")
    if profile != "ros2":
        raise FormatError(
            "unsupported",
            "is an MCAP file with the profile {profile!q}; only messages of ROS 2 are read, no JSON and "
            "no Protobuf",
            "convert it to a bag of ROS 2, or write its poses to a table t,x,y,heading and audit that",
            profile=profile[:40],
        )


def _zstd() -> Any:
    try:
        from compression import zstd  # noqa: PLC0415 - Python 3.14
    except ImportError:
        from backports import zstd  # noqa: PLC0415
    return zstd


class _Unpacking:
    """Unpacks the chunks and messages of one bag, each to a limit and all together to another.

    Args:
        size: Size of the bag, bytes.
    """

    def __init__(self, size: int) -> None:
        self._left = self._most = _FREE + _MOST_TIMES * size

    def unpack(self, compression: str, data: bytes) -> bytes:
        """Return what a chunk or a message becomes.

        Raises:
            FormatError: If that is too large, alone or with all that came before, there is more
                after it, or the compression is unknown.
        """
        decompressor: Any
        if compression == "zstd":
            decompressor = _zstd().ZstdDecompressor()
        elif compression == "lz4":
            from lz4 import frame  # noqa: PLC0415

            decompressor = frame.LZ4FrameDecompressor()
        elif compression == "bz2":
            decompressor = bz2.BZ2Decompressor()
        else:
            raise _too_large(_MOST_OF_A_CHUNK)
        found: bytes = decompressor.decompress(data, max_length=_MOST_OF_A_CHUNK + 1)
        if not decompressor.eof or decompressor.unused_data or len(found) > _MOST_OF_A_CHUNK:
            raise _too_large(_MOST_OF_A_CHUNK)
        self._left -= len(found)
        if self._left < 0:
            raise FormatError(
                "too-large",
                "the bag's compressed parts become more than {most} bytes together",
                "keep the topics that matter, such as /map, /tf and /tf_static, with ros2 bag convert or "
                "rosbag filter",
                most=self._most,
            )
        return found


class _Collector:
    """Takes what matters out of messages: all poses, and the last message of the rest."""

    TYPES = frozenset((_GRID, _UPDATE, _POLYGON, *_TRANSFORMS, *_POSES, _PLAN, _ACTION_GOAL))

    def __init__(self) -> None:
        self._grids: dict[str, list[_Message]] = {}
        self._last: dict[str, _Message] = {}
        self._rows: dict[tuple[str, str, str], list[tuple[float, float, float, float]]] = {}
        self._links: dict[tuple[str, str], list[tuple[float, float, float, float]]] = {}
        self._bases: list[str] = []
        self._begin: int | None = None

    def collect(self, messages: Iterator[_Message]) -> Bag:
        """Return what the messages say."""
        for message in messages:
            self._take(message)
        # Goals are poses, too, and only their names tell.
        tracks = {key: Track.of(key[2], rows) for key, rows in self._rows.items()}
        poses: dict[str, Track] = {}
        goals: dict[str, Track] = {}
        for key in sorted(tracks, key=lambda key: (_POSES.index(key[1]), -len(tracks[key].x))):
            (goals if _is_goal(key[0]) else poses).setdefault(key[0], tracks[key])
        outlines: dict[str, Outline] = {}
        for topic, message in sorted(self._last.items()):
            parsed = message.parse()
            if message.type == _ACTION_GOAL:
                goals[topic] = self._track(message, parsed.target)
            elif message.type == _PLAN and len(parsed.poses):
                goals.setdefault(topic, self._track(message, parsed.poses[-1], parsed))
            elif message.type == _POLYGON:
                corners = np.array(
                    [(point.x, point.y) for point in parsed.polygon.points], np.float64
                )
                time = self._time(message, parsed.header)
                outlines[topic] = Outline(_frame(parsed), time, corners.reshape(-1, 2))
        return Bag(
            {topic: grid for topic, every in self._grids.items() if (grid := _grid(every))},
            poses,
            goals,
            outlines,
            Frames(self._parents()),
            (*_BASES, *dict.fromkeys(name for name in self._bases if name not in _BASES)),
        )

    def _take(self, message: _Message) -> None:
        """Take what is needed of one message."""
        if message.type == _GRID:
            self._grids[message.topic] = [message]
        elif message.type == _UPDATE:
            # Updates belong to the last map of the topic.
            self._grids.setdefault(message.topic.removesuffix("_updates"), []).append(message)
        elif message.type in _TRANSFORMS:
            for one in message.parse().transforms:
                move, turn = one.transform.translation, one.transform.rotation
                row = (self._time(message, one.header), move.x, move.y, _yaw(turn))
                key = (_name(one.child_frame_id), _frame(one))
                self._links.setdefault(key, []).append(row)
        elif message.type in _POSES:
            parsed = message.parse()
            if message.type == _POSES[0]:
                self._bases.append(_name(parsed.child_frame_id))
            self._rows.setdefault((message.topic, message.type, _frame(parsed)), []).append(
                self._row(message, parsed)
            )
        else:
            self._last[message.topic] = message

    def _parents(self) -> dict[str, Track]:
        """Return each frame's parent; the one that was sent most often, of several."""
        found: dict[str, tuple[int, Track]] = {}
        for (child, parent), rows in self._links.items():
            if child != parent and len(rows) > found.get(child, (0, None))[0]:
                found[child] = len(rows), Track.of(parent, rows)
        return {child: track for child, (_, track) in found.items()}

    def _time(self, message: _Message, header: Any) -> float:
        """Return when a message was measured, or received if nobody set its stamp, s from the first."""
        stamp = header.stamp
        time = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
        time = time or message.nanoseconds
        if self._begin is None:
            self._begin = time
        return (time - self._begin) * 1e-9

    def _row(
        self, message: _Message, stamped: Any, whole: Any = None
    ) -> tuple[float, float, float, float]:
        """Return time, x, y and yaw of a message with a pose, or of a pose in a whole message."""
        pose = stamped.pose
        pose = getattr(pose, "pose", pose)
        time = self._time(message, (stamped if whole is None else whole).header)
        return time, pose.position.x, pose.position.y, _yaw(pose.orientation)

    def _track(self, message: _Message, stamped: Any, whole: Any = None) -> Track:
        frame = _frame(stamped) or _frame(whole)
        return Track.of(frame, [self._row(message, stamped, whole)])


def _is_goal(topic: str) -> bool:
    return "goal" in topic.lower()


def _name(frame: str) -> str:
    # ROS 1 allowed a slash at the beginning.
    return frame.lstrip("/")


def _frame(stamped: Any) -> str:
    return "" if stamped is None else _name(stamped.header.frame_id)


def _yaw(turn: Any) -> float:
    return math.atan2(
        2.0 * (turn.w * turn.z + turn.x * turn.y), turn.w**2 + turn.x**2 - turn.y**2 - turn.z**2
    )


def _grid(messages: list[_Message]) -> Grid | None:
    """Return the last map of a topic with the updates that came after it.

    Raises:
        FormatError: If the sizes in a message don't go together.
    """
    if messages[0].type != _GRID:
        return None
    first = messages[0].parse()
    info = first.info
    place = info.origin.position
    cells = _cells(first, messages[0].topic, int(info.width), int(info.height)).copy()
    for message in messages[1:]:
        update = message.parse()
        width, height = int(update.width), int(update.height)
        part = cells[update.y : update.y + height, update.x : update.x + width]
        own = _cells(update, message.topic, width, height)
        if min(update.x, update.y) < 0 or part.shape != own.shape:
            raise _wrong_size(message.topic, width, height, own.size)
        part[:] = own
    numbers = float(info.resolution), place.x, place.y, _yaw(info.origin.orientation)
    if not all(map(math.isfinite, numbers)):
        raise FormatError(
            "not-finite", "{topic} has a place that is not a number", topic=messages[0].topic
        )
    # Resolutions are float32.
    resolution = float(f"{numbers[0]:.7g}")
    return Grid(_frame(first), resolution, numbers[1:], cells)


def _cells(message: Any, topic: str, width: int, height: int) -> npt.NDArray[np.int8]:
    cells = np.asarray(message.data, np.int8)
    if width * height != cells.size or not 0 < cells.size <= _MOST_CELLS:
        raise _wrong_size(topic, width, height, cells.size)
    return cells.reshape(height, width)


def _wrong_size(topic: str, width: int, height: int, count: int) -> FormatError:
    return FormatError(
        "wrong-size",
        "{topic!q} has {count} cells for {width} x {height}",
        "record the map again",
        topic=topic,
        count=count,
        width=width,
        height=height,
    )
