"""The models of a Gazebo world, its own and included ones, and where each part of them is.

Source: the SDFormat specification 1.12, ``<include>`` and "Pose Frame Semantics".
"""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from worldgen.errors import FormatError
from worldgen.interop.format.foreign_map import naming
from worldgen.interop.readers.gazebo_files import Home, ModelFiles
from worldgen.interop.readers.gazebo_poses import BodyPose, own_pose
from worldgen.interop.readers.xml_tree import XmlElement
from worldgen.support.paths import real_path

OURS = "worldgen:"
"""Prefix of our elements for facts that SDFormat lacks."""
# What has no collision does not stop a robot, and a frame matters only to poses that name it. Gazebo
# ignores words between elements, and the wrong place of a word such as <static>.
GAZEBO_HARMLESS = frozenset({
    "sdf/version", "name", "collision/surface", "collision/laser_retro", "collision/max_contacts",
    "collision/density", "collision/material", "link/static", "sdf/text", "sdf/light", "world/text",
    "model/text", "link/text",
    "sdf/xacro:arg", "xacro:unless/value", "xacro:if/value", "include/static",
    "link/audio_sink", "link/audio_source", "link/battery", "link/enable_wind", "link/gravity",
    "link/inertial", "link/kinematic", "link/light", "link/must_be_base_link", "link/particle_emitter",
    "link/projector", "link/self_collide", "link/sensor", "link/velocity_decay", "link/visual",
    "model/allow_auto_disable", "model/canonical_link", "model/enable_wind", "model/frame", "model/self_collide",
    "model/static", "model/velocity_decay", "model/gripper", "state/iterations", "state/light", "state/real_time",
    "state/sim_time", "state/wall_time", "state/world_name", "state/model/link", "state/model/static",
    "world/atmosphere", "world/audio", "world/frame", "world/gravity", "world/gui", "world/light",
    "world/magnetic_field", "world/physics", "world/scene", "world/spherical_coordinates", "world/wind",
    f"world/{OURS}robot_radius",
})  # fmt: skip
"""Names of what a Gazebo file has besides obstacles."""
# Plugins that are parts of Gazebo, or connect it to ROS; none of them adds a body.
_SYSTEM = re.compile(
    r"(lib)?(gz|ignition)[-_:]+(sim|gazebo)[-_:\d]*|(gz|ignition)::(sim|gazebo)::|libgazebo_ros_|gazebo_ros_|__default__"
)
# Models that Gazebo or its server's owner has and that stop nobody.
_GROUND = re.compile(
    r"(?i)((model:/{0,2}|file:/{0,2}models/)?|https?://[^/]+/[0-9.]+/openrobotics/models/)"
    r"(sun|ground( |_|%20)plane)(/([0-9]+|tip))?/?"
)
# Limits on models in models; real worlds have a few hundred, three deep.
_MOST_MODELS = 20_000
_MOST_DEPTH = 64
# Limit on their files together, bytes, each as often as it is included.
_MOST_BYTES = 256 << 20


@dataclass
class Model:
    """A model, a world, or what an ``<include>`` brings in.

    Args:
        name: Its name where it stands.
        element: Its element, in whichever file.
        placed_by: The element that has its pose: the ``<include>``, if that has one.
        path: Its file, for messages.
        home: The folder of its file.
        anchor: The frame of the model that the pose places; empty for the model's own.
        is_static: True if nothing in it moves.
        depth: Number of models around it.
        models: The models in it.
    """

    name: str
    element: XmlElement
    placed_by: XmlElement
    path: Path
    home: Home
    anchor: str = ""
    is_static: bool = False
    depth: int = 0
    models: list[Model] = field(default_factory=list)
    _frames: dict[str, BodyPose] = field(default_factory=dict)

    @functools.cached_property
    def _by_name(self) -> dict[str, Model]:
        return {model.name: model for model in self.models}

    @functools.cached_property
    def _parts(self) -> dict[str, XmlElement]:
        """The links, frames and joints, which poses may name."""
        kinds = ("joint", "frame", "link")
        parts = [part for kind in kinds for part in self.element.all(kind)]
        return {part.attributes.get("name", ""): part for part in parts}

    def pose(self, part: XmlElement, link: XmlElement | None = None) -> BodyPose:
        """Return where a part of this model is, in the model's frame.

        Args:
            part: A link, joint, frame, or a shape of a link.
            link: The link of a shape, whose frame counts if the shape names none.

        Raises:
            FormatError: If its pose is wrong, or in a frame that does not exist.
        """
        with naming(self.path):
            own, frame, line = own_pose(part)
            if frame:
                return self._frame(frame, line, ()).then(own)
            return own if link is None else self.pose(link).then(own)

    def pose_of(self, model: Model) -> BodyPose:
        """Return where a model in this one is, in this one's frame."""
        return self._model(model, ())

    def _model(self, model: Model, asked: tuple[str, ...]) -> BodyPose:
        with naming(model.path if model.placed_by is model.element else self.path):
            own, frame, line = own_pose(model.placed_by)
            pose = self._frame(frame, line, asked).then(own) if frame else own
        if not model.anchor:
            return pose
        return pose.then(model._frame(model.anchor, model.element.line, ()).inverse())

    def _frame(self, name: str, line: int, asked: tuple[str, ...]) -> BodyPose:
        """Return the pose of a frame, by its name, as seen from this model."""
        if name not in self._frames:
            self._frames[name] = self._find_frame(name, line, asked)
        return self._frames[name]

    def _find_frame(self, name: str, line: int, asked: tuple[str, ...]) -> BodyPose:
        if name in ("__model__", "world", ""):
            return BodyPose()
        if name in asked or len(asked) > _MOST_DEPTH:
            raise FormatError(
                "cycle",
                "the frame {name!q} is placed relative to itself",
                "write its pose relative to the model",
                name=name,
                line=line,
            )
        outer, _, inner = name.partition("::")
        model = self._by_name.get(outer)
        if model is not None:
            pose = self._model(model, (*asked, name))
            return pose.then(model._frame(inner, line, ())) if inner else pose
        part = self._parts.get(name)
        if part is not None:
            own, frame, at = own_pose(part)
            return self._frame(frame or _usual_frame(part), at, (*asked, name)).then(own)
        raise FormatError(
            "no-such-frame",
            "a pose is relative to {name!q}, which is no frame, link or model here",
            "correct the name",
            name=name[:80],
            line=line,
        )


def _usual_frame(part: XmlElement) -> str:
    """Return the frame of a part that names none: what it is attached to, if anything."""
    if part.name == "joint":
        return part.word("child")
    return part.attributes.get("attached_to", "") if part.name == "frame" else ""


class ModelTree:
    """Collects the models of a world, also from other files.

    Args:
        files: The files that belong to the world.
        path: The world's file.

    Attributes:
        unread: What in the models is not read.
        included: The files of included models.
    """

    def __init__(self, files: ModelFiles, path: Path) -> None:
        self._files = files
        self._path = path
        self._count = 0
        self._bytes = 0
        self.unread: Counter[str] = Counter()
        self.included: dict[Path, None] = {}

    def world(self, element: XmlElement) -> Model:
        """Return a world, or the root of a file without one, with all models in it."""
        world = Model("world", element, element, self._path, self._files.home)
        world.models = [*self._models(world, (real_path(self._path),))]
        return world

    def _models(self, parent: Model, files: tuple[Path, ...]) -> Iterator[Model]:
        for element in parent.element.all("model"):
            name = element.attributes.get("name", "")
            yield self._complete(
                Model(name, element, element, parent.path, parent.home), parent, files
            )
        for include in parent.element.all("include"):
            with naming(parent.path):
                found = self._included(include, parent, files)
            if found is not None:
                yield self._complete(found, parent, (*files, real_path(found.path)))

    def _complete(self, model: Model, parent: Model, files: tuple[Path, ...]) -> Model:
        """Add to a model what is the same for all: its frame, its rest, the models in it."""
        self._count += 1
        model.depth = parent.depth + 1
        if model.path != parent.path:
            self._bytes += self._files.sizes[model.path]
        too_large = self._count > _MOST_MODELS or self._bytes > _MOST_BYTES
        if too_large or model.depth > _MOST_DEPTH:
            raise FormatError(
                "too-large",
                "more than {most} models, {size} MiB of them, or {deep} within each other",
                "use a smaller part of the world",
                most=_MOST_MODELS,
                size=_MOST_BYTES >> 20,
                deep=_MOST_DEPTH,
            )
        model.anchor = model.anchor or model.element.attributes.get("placement_frame", "")
        stays = (model.placed_by.word("static"), model.element.word("static"))
        model.is_static = parent.is_static or any(word in ("1", "true") for word in stays)
        model.models = [*self._models(model, files)]
        return model

    def _included(
        self, include: XmlElement, parent: Model, files: tuple[Path, ...]
    ) -> Model | None:
        """Return the model that an ``<include>`` names, or None and report it."""
        uri = include.first("uri")
        found = None if uri is None else self._files.model(uri, parent.home)
        if found is None:
            include.pass_over()
            if _GROUND.fullmatch(include.word("uri")):
                self._files.missing.pop(include.word("uri"), None)
            else:
                self.unread["models not found"] += 1
            return None
        path, home = found
        if real_path(path) in files:
            raise FormatError(
                "cycle",
                "{name} includes itself",
                "take that <include> out",
                name=path.name
                if path.parent == self._path.parent
                else f"{home.folder.name}/{path.name}",
                line=include.line,
            )
        self.included[path] = None
        self.count_plugins(include)
        include.attributes.get("merge")
        element = self._files.read(path).first("model")
        if element is None:
            # A light, or something else that is then reported as unread.
            return None
        name = include.word("name") or element.attributes.get("name", "")
        placed_by = element
        if include.first("pose") is not None:
            placed_by = include
            # The pose of the <include> takes the place of the model's own.
            for pose in element.all("pose"):
                pose.pass_over()
        return Model(name, element, placed_by, path, home, include.word("placement_frame"))

    def count_plugins(self, parent: XmlElement) -> None:
        """Count the plugins that are not parts of Gazebo, because they can do anything."""
        for plugin in parent.all("plugin"):
            names = (plugin.attributes.get("filename", ""), plugin.attributes.get("name", ""))
            self.unread["plugins of others"] += not any(map(_SYSTEM.match, names))
            plugin.pass_over()
        # Both cases of a choice count.
        for kind in ("xacro:if", "xacro:unless"):
            for group in parent.all(kind):
                self.count_plugins(group)
