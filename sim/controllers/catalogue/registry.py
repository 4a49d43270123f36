"""Find a controller by name, and check it.

A name is a registered one, ``module:name``, ``./file.py:name``, ``lib:./file.so:name`` or
``cmd:PROGRAM``.
"""

from __future__ import annotations

import ast
import functools
import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from sim.controllers.base import DEFAULT_SENSES, CompiledController, Controller, check_declared
from sim.controllers.behaviours.catalogue import BEHAVIOURS, is_composition_name, listed_names
from sim.controllers.fields import fields_of, with_fields
from sim.controllers.instances import InstanceOrigin, instance_of, origin_of, remember
from sim.controllers.learning import LEARNED, is_learned_name, learned_file, read_learned
from sim.controllers.programs.process import ProcessController, is_process_name
from sim.controllers.shared.object_file import is_library_name, library_file
from sim.controllers.taught import with_numbers
from sim.controllers.variants import Variants
from sim.options.robot import RobotOptions
from worldgen.errors import InvalidParameter, Message
from worldgen.parameters import split_options, with_options
from worldgen.plugins.registry import Registry, identity, user_code
from worldgen.plugins.trust import admit_argument, check_code, same_origin
from worldgen.support.paths import expanded

_NAMES_CODE = re.compile(r"[\w./~-]+:[A-Za-z_]\w*")
_IN_A_FILE = re.compile(r"(?P<file>[^:]+\.py)(?P<rest>:.*)", re.DOTALL)


def own_words(name: str) -> tuple[str, dict[str, str | None]]:
    """Split ``topological+places=16`` into the controller and options of its own.

    Args:
        name: A controller's name, without options of the run.

    Returns:
        The name without them, and each option's value as text; None for one without ``=``.
    """
    if "+" not in name or _has_prefix(name):
        return name, {}
    return split_options(name, "topological+places=16")


def _has_prefix(name: str) -> bool:
    """Return True for a program, a composition, a library, or what was learned."""
    is_program = is_process_name(name) or is_composition_name(name)
    return is_program or is_library_name(name) or is_learned_name(name)


def _place_apart(name: str) -> str:
    """Return a controller's name without the folder of its file."""
    return name.rpartition("/")[2]


class ControllerRegistry(Registry[Controller]):
    """A registry that also knows programs (``cmd:``) and shared libraries (``lib:``)."""

    def get(self, name: str) -> Controller:
        """Return the controller with this name, whatever its kind."""
        # Programs, compositions and what was learned have a prefix.
        if is_process_name(name):
            check_code(name)
            if name not in self._loaded:
                self._loaded[name] = ProcessController.of(name)
            return self._loaded[name]
        if is_composition_name(name):
            # This is not cached, because a part may be a file that changes; its registry detects
            # changes.
            return _recomposable(name)
        if is_learned_name(name):
            check_code(name)
            learned = read_learned(learned_file(name))
            self._refuse_code(learned.controller, name)
            return with_numbers(self.get(learned.controller), learned.numbers, name)
        if is_library_name(name):
            check_code(name)
            if name not in self._loaded:
                from sim.controllers.shared.library import library_controller  # noqa: PLC0415 - for lib: only

                self._loaded[name] = library_controller(name)
            return self._loaded[name]
        # A registered controller or a user's class may have its own options.
        base, words = own_words(name)
        if words:
            return self._with_options(name, base, words)
        return super().get(name)

    def option_names(self, name: str) -> tuple[str, ...]:
        """Return the controller's own options, which its name may contain.

        Those of a user's class are its fields, so this loads its file.
        """
        # A name that is not registered may be a program's, whose own error is better.
        if is_library_name(name) or (":" not in name and name not in self.entry_points()):
            return (LEARNED,)
        found = self.get(name)
        variants: Variants | None = getattr(found, "variants", None)
        is_taught = ":" in name or getattr(found, "learning", None) is not None
        kind = self.class_of(name)
        return (
            *(() if variants is None else variants.names()),
            *(() if kind is None else (one.name for one in fields_of(kind))),
            *((LEARNED,) if is_taught else ()),
        )

    def has_variants(self, name: str) -> bool:
        """Return True if a controller declares its own options, so that its fields are none."""
        return not _has_prefix(name) and getattr(self.get(name), "variants", None) is not None

    def class_of(self, name: str) -> type | None:
        """Return the class that a controller's name without options names; ``None`` if none."""
        if _has_prefix(name):
            return None
        found = self.get(name)
        kind = type(found)
        if origin_of(found) is not None:
            return kind
        # A class with __slots__ leaves no origin. Loading the file again could load an edited one.
        point = self.entry_points().get(name)
        attribute = (name if point is None else point.value).rpartition(":")[2]
        module = sys.modules.get(kind.__module__)
        return kind if getattr(module, attribute, None) is kind else None

    def _with_options(self, name: str, base: str, words: dict[str, str | None]) -> Controller:
        """Return a controller with its own options and with the numbers that it learned.

        Raises:
            InvalidParameter: If an option is unknown or out of range, or the file does not hold
                what this controller learned.
        """
        has_learned = LEARNED in words
        path = words.pop(LEARNED, None)
        found = self.get(base)
        if words:
            found = self._varied(name, base, words)
        if not has_learned:
            return found
        if not path:
            raise InvalidParameter(
                "no-value",
                "{name!r} names no file",
                "write {controller}+learned=taught.json",
                name=name,
                controller=base,
            )
        check_code(f"learned:{path}")
        learned = read_learned(expanded(path))
        # The class comes from the name, so a file that names other code cannot run it.
        if _place_apart(learned.controller) != _place_apart(base):
            raise InvalidParameter(
                "other-controller",
                "{path} holds what {other!r} learned, not {controller!r}",
                "choose a file that `worldgen train` wrote for it",
                at_terminal=True,
                path=path,
                other=learned.controller,
                controller=base,
            )
        return with_numbers(found, learned.numbers, name)

    def _varied(self, name: str, base: str, words: dict[str, str | None]) -> Controller:
        """Return a controller with its own options, or with its class's fields."""
        found = self.get(base)
        # Each run gets its controller by name, and what runs have left in it must be seen.
        key = with_options(identity(base), words)
        if key in self._loaded:
            return self._loaded[key]
        variants: Variants | None = getattr(found, "variants", None)
        kind = self.class_of(base)
        if variants is None and kind is not None:
            self._loaded[key] = _accept(name, with_fields(found, kind, words, base))
            return self._loaded[key]
        unknown = [one for one in words if variants is None or one not in variants.names()]
        if variants is None or unknown:
            raise InvalidParameter(
                "unknown-name",
                "controller {controller!r} has no option {option!r} of its own",
                "leave it out; options of a run belong in RunOptions, and Scenario.parse() "
                "reads both",
                controller=base,
                option=unknown[0],
            )
        return variants.named(words, base, name)

    def _refuse_code(self, controller: str, name: str) -> None:
        """Refuse a file of learned numbers that names code: reading data must not run code.

        Raises:
            InvalidParameter: If the controller is neither registered nor made of registered parts.
        """
        is_composed = is_composition_name(controller)
        parts = listed_names(controller) if is_composed else [controller]
        if any(":" in part for part in parts):
            raise InvalidParameter(
                "learned-names-code",
                "{name} holds numbers for {controller!r}, which is code, and such a file cannot "
                "run code",
                "name the code yourself: {controller}+learned={file}",
                file=name.partition(":")[2],
                name=name,
                controller=controller,
            )

    def source(self, name: str) -> Path | None:
        """Return the file that the controller comes from; None if it is built in."""
        if is_learned_name(name):
            return learned_file(name)
        name, _ = own_words(name)
        if is_composition_name(name):
            files = (BEHAVIOURS.source(part) for part in listed_names(name) if ":" in part)
            return next((file for file in files if file is not None), None)
        return library_file(name) if is_library_name(name) else super().source(name)

    def _load_path(self, name: str) -> Any:
        hint = _program_hint(name)
        if hint:
            raise InvalidParameter.of(hint)
        return super()._load_path(name)

    def _unknown(self, name: str) -> Message:
        return _program_hint(name) or super()._unknown(name).before(", or 'cmd:./program --flag'")


def _program_hint(name: str) -> Message | None:
    """Return a hint for a command line without ``cmd:``, or for a file without its class."""
    # A Python file needs the name of its class, or cmd: if it is meant as a program.
    first, *arguments = name.split(" ")
    if first.endswith(".py") and not arguments and os.path.isfile(first):  # noqa: PTH113 - Path may refuse a text
        classes = _classes_in(Path(first))
        return Message(
            "needs-a-class",
            "controller {name!r} is a Python file, and "
            + ("it has {classes!l}" if classes else "it has no class with act"),
            "name a class, such as {file}:{example}, or run the file as a program, 'cmd:python "
            "{file}'",
            name=name,
            classes=classes,
            file=first,
            example=classes[0] if classes else "Robot",
        )

    # Anything else that exists or is on PATH is a program, so only cmd: is missing.
    is_here = os.path.isfile(first)  # noqa: PTH113 - as above
    place = name.rpartition(":")[0]
    if is_here or (arguments and shutil.which(first) is not None):
        command = name if "/" in first or not is_here else f"./{name}"
        return Message(
            "needs-cmd",
            "controller {name!r} is a program",
            "write 'cmd:{command}'",
            name=name,
            command=command,
        )

    # A path is neither registered nor a module.
    if not place and "/" in first:
        return Message(
            "no-such-file",
            "controller {name!r}: there is no file {file}",
            "check the path; a program is written 'cmd:{name}', a class ./file.py:name",
            name=name,
            file=first,
        )

    # A colon after a path that is not Python looks like a mistyped ./file.py:name.
    if "/" in place and not place.endswith(".py"):
        return Message(
            "not-python",
            "controller {name!r}: {file} is not a Python file",
            "write ./file.py:name, or 'cmd:./program --flag'",
            name=name,
            file=place,
        )
    return None


def _classes_in(file: Path) -> list[str]:
    """Return the names of the classes in a file that can drive a robot, without running it."""
    try:
        tree = ast.parse(file.read_text("utf-8"))
    except (OSError, ValueError, SyntaxError):
        return []
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    return [
        one.name
        for one in classes
        if {"act", "act_many"} & {getattr(part, "name", "") for part in one.body}
    ]


def _recomposable(name: str) -> Controller:
    """Return a composition, whose parts in Python are new."""
    from sim.controllers.behaviours.composition import composition_named  # noqa: PLC0415 - for these only

    made = composition_named(name)
    if not isinstance(made, CompiledController):
        again = functools.partial(composition_named, name)
        remember(made, InstanceOrigin(f"controller {name!r}", again))
    return made


def _accept(name: str, thing: Any) -> Controller:
    if isinstance(thing, type):
        thing = instance_of(thing, f"controller {name!r}")
    if isinstance(thing, CompiledController):
        return thing
    with user_code(f"controller {name!r}: looking at its attributes"):
        act = "act_many" if hasattr(thing, "act_many") else "act"
        missing = [
            method for method in ("reset", act) if not callable(getattr(thing, method, None))
        ]
        senses = getattr(thing, "senses", DEFAULT_SENSES)
        needs = getattr(thing, "needs", RobotOptions())
    if missing:
        raise InvalidParameter(
            "not-a-controller",
            "controller {name!r} has no {missing}",
            "it must have reset() -> memory and act(observation, memory) -> (command, memory), or "
            "act_many for many robots, or be a CompiledController",
            name=name,
            missing=" and no ".join(missing),
        )
    check_declared(name, senses, needs)
    controller: Controller = thing
    return controller


CONTROLLERS = ControllerRegistry("worldgen.controllers", "controller", _accept)


def controller_of(given: str | Controller | type) -> Controller:
    """Return the controller with that name, or the given controller after checking it.

    Args:
        given: A name, a controller, or a class that makes one without arguments.

    Raises:
        InvalidParameter: If the name is unknown, the object is not a controller, or making it
            raises an exception.
    """
    if isinstance(given, str):
        admit_argument(given)
        return CONTROLLERS.get(given)
    return _accept(called(given), given)


def in_plain_place(name: str, *, resolve: bool = False) -> str:
    """Return a controller's name with its file's path normalised.

    ``./mine.py:Robot`` becomes ``mine.py:Robot``, so that both spellings are one controller.

    Args:
        name: The name, with or without options; names of other kinds are returned unchanged.
        resolve: True to use the file's full path, so that the name is the same in all folders.
    """
    found = _IN_A_FILE.fullmatch(name)
    if found is None:
        return name
    plain = os.path.realpath if resolve else os.path.normpath
    return same_origin(name, f"{plain(found['file'])}{found['rest']}")


def names_in(text: str) -> list[str]:
    """Split a comma-separated list of controllers.

    A comma after a program's name belongs to its command line, and one after a composition's name
    to its list, unless another controller follows: a registered one, ``file.py:name``,
    ``module:name``, or another program or composition.
    """
    names: list[str] = []
    for part in text.split(","):
        before = names[-1].lstrip() if names else ""
        in_command = is_process_name(before) or is_composition_name(before)
        if in_command and not _begins_a_controller(part.strip()):
            names[-1] += f",{part}"
        else:
            names.append(part)
    return names


def _begins_a_controller(text: str) -> bool:
    if is_process_name(text) or is_composition_name(text):
        return True
    try:
        name, _ = split_options(text)
    except InvalidParameter:
        return False
    return name in CONTROLLERS.names() or _NAMES_CODE.fullmatch(name) is not None


def called(given: object) -> str:
    """Return the name of a controller for messages and tables."""
    if isinstance(given, str):
        return given
    kind = type(given).__name__
    with user_code(f"controller {kind!r}: looking up its name"):
        names = [getattr(given, "name", None), getattr(given, "__name__", None), kind]
    return next(name for name in names if isinstance(name, str))
