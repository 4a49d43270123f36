"""Notice edits of files whose code the studio runs.

Python keeps the code of a module that it has loaded. So when the contents of a user's file change,
the process that has loaded it is replaced, and the page receives the file's name.
"""

from __future__ import annotations

import functools
import os
import shlex
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from fuzz.studio.requests.protocol import CodeFile
from worldgen.errors import InvalidParameter
from worldgen.parameters import split_options
from worldgen.plugins.user_modules import digest_of_source, sources_read
from worldgen.support.paths import expanded

UNKNOWN = "?"
"""Digest of code that was read at an unknown time during an edit; no file's contents equal it."""

# A larger file, such as a library with everything in it, is recognised by its time and size.
_LARGEST = 16 << 20  # bytes
_FILE_TIMES = 1.0  # s: coarsest step of a file system's times
# What the file system reported about each file when its contents were last read, and their digest.
_read: dict[str, tuple[tuple[int, ...], str]] = {}


def digest_of_file(path: str) -> str:
    """Return a digest of a file's contents; empty if it cannot be read.

    The contents are read again only if the file's times, size or number have changed.
    """
    try:
        facts = Path(path).stat()
        if facts.st_size > _LARGEST:
            return f"{facts.st_mtime_ns}-{facts.st_size}"
        # The time of the last change of any kind cannot be set, so it also reveals an edit that
        # keeps time and size.
        seen = (facts.st_mtime_ns, facts.st_ctime_ns, facts.st_size, facts.st_ino)
        known = _read.get(path)
        if known is not None and known[0] == seen:
            return known[1]
        digest = digest_of_source(Path(path).read_bytes())
    except (OSError, ValueError):  # ValueError: a NUL in the name
        return ""
    # A file that has just been written can be written again with the same time stamp.
    if time.time() - max(facts.st_mtime, facts.st_ctime) > _FILE_TIMES:
        _read[path] = (seen, digest)
    return digest


def loaded_files(since: float) -> dict[str, str]:
    """Return the user's files whose code this process has loaded, with the digest of each.

    Args:
        since: When the process began with its current request, s since 1970. A file that Python
            itself loaded and that was written later may have been read before or after that.
    """
    from sim.controllers.crash_frames import is_users_file  # noqa: PLC0415 - loads the simulator

    found = sources_read()
    files = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    for file in files:
        if not isinstance(file, str) or file in found or not is_users_file(file):
            continue
        try:
            is_settled = Path(file).stat().st_mtime < since - _FILE_TIMES
        except OSError:
            is_settled = False
        found[file] = digest_of_file(file) if is_settled else UNKNOWN
    return found


def edited_files(loaded: Mapping[str, str]) -> list[str]:
    """Return the files that have changed since their code was loaded.

    Args:
        loaded: Files with their digests, as ``loaded_files`` returns them.
    """
    return [file for file, digest in loaded.items() if digest_of_file(file) != digest]


def code_files(digests: Mapping[str, str], named: Sequence[str]) -> list[CodeFile]:
    """Return the page's entries of files, with the names of the controllers that may run each."""
    found = []
    for file, digest in digests.items():
        path = Path(file)
        own = [label for label in named if file in own_files(label)]
        in_same_folder = [
            label
            for label in named
            if any(path.is_relative_to(Path(part).parent) for part in own_files(label))
        ]
        affected = own or in_same_folder or named
        controllers = sorted({name for label in affected for name in _plain_names(label)})
        found.append(CodeFile(file, path.name, digest, controllers))
    return found


def _plain_names(label: str) -> list[str]:
    """Return a controller's name without its options; of a composition, the user's behaviours."""
    from sim.controllers.behaviours import catalogue  # noqa: PLC0415 - loads the simulator

    try:
        if catalogue.is_composition_name(label):
            return [name for name in catalogue.listed_names(label) if ":" in name]
        return [split_options(label)[0]]
    except InvalidParameter:  # a program's arguments can contain a plus
        return [label]


@functools.cache
def own_files(label: str) -> tuple[str, ...]:
    """Return the files that a controller's name contains; empty for one in a module."""
    from fuzz.studio.requests.running import names_of  # noqa: PLC0415 - loads the simulator
    from sim.controllers.behaviours.catalogue import is_composition_name  # noqa: PLC0415
    from sim.controllers.programs.process import is_process_name  # noqa: PLC0415
    from sim.controllers.shared.object_file import is_library_name, library_file  # noqa: PLC0415

    for name in names_of((label,)):
        if is_composition_name(name):
            continue  # the user's behaviours in it come separately
        if is_process_name(name):
            # A program starts again with each run. Its script is watched only to report changes.
            try:
                words = shlex.split(name.partition(":")[2])
            except ValueError:  # an unclosed quote, which the run reports
                return ()
            return tuple(os.path.realpath(word) for word in words if Path(word).is_file())
        if is_library_name(name):
            return (os.path.realpath(library_file(name)),)
        place = name.rpartition(":")[0]
        if place.endswith(".py"):
            return (os.path.realpath(expanded(place)),)
    return ()
