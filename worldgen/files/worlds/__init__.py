"""The worlds at a path: in a file, a folder or an archive.

Contents:
    read_worlds, walk: Read each world of files, folders and archives when it is reached.
    read_whole_world: Read a world to prove something about it.
    files_in, is_world_file: Find the world files in a folder.
    SIDECAR: Ending of the file next to an exported map.
    Skip: What is called with the error of a file that cannot be read.
"""

from worldgen.files.worlds.walking import (
    SIDECAR,
    Skip,
    files_in,
    is_world_file,
    read_whole_world,
    read_worlds,
    walk,
)

__all__ = [
    "SIDECAR",
    "Skip",
    "files_in",
    "is_world_file",
    "read_whole_world",
    "read_worlds",
    "walk",
]
