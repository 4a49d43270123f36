"""Where a set's files are written: a folder, which may be packed into an archive at the end."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
from pathlib import Path

from worldgen.errors import OutputError
from worldgen.files.archives import ZipWriter, check_written, is_archive
from worldgen.files.whole import refused_writes
from worldgen.sets.journal import Journal
from worldgen.sets.manifest import MANIFEST, Manifest, ManifestEntry, read_manifest

# Suffix of the folder in which an archive grows.
PART = ".part"


def store_for(out: Path) -> SetFolder:
    """Return an archive if the name is an archive's, otherwise a folder.

    Raises:
        OutputError: If a folder has an archive's name, or a file a folder's; or if the archive
            isn't a zip file.
    """
    check_written(out)
    if is_archive(out):
        if out.is_dir():
            raise OutputError(
                "is-a-folder",
                "{out} is a folder with the name of an archive",
                "use another name",
                out=out,
            )
        return SetArchive(out)
    if out.exists() and not out.is_dir():
        raise OutputError(
            "is-a-file",
            "{out} is a file",
            "choose a folder for more than one world, or a .zip",
            out=out,
        )
    return SetFolder(out)


class SetFolder:
    """A folder with a file for each world.

    Whatever was written counts, however the process ends.

    Args:
        folder: The folder, created along with the first file.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._over_others = False
        self._journal = Journal(folder / MANIFEST)
        self._made: set[Path] = set()

    def find(self, *, force: bool) -> Manifest | None:
        """Return the set that an earlier run left; refuse a folder with other files in it."""
        self._over_others = force
        found = self._journal.read(force=force)
        if found is None and not force and self._folder.is_dir():
            others = sorted(
                path.name for path in self._folder.iterdir() if not path.name.startswith(".")
            )
            others = [name for name in others if name != MANIFEST]
            if others:
                raise OutputError(
                    "folder-not-empty",
                    "{folder} holds other files: {file}"
                    + (" and {more} more" if len(others) > 1 else ""),
                    "a set needs its own folder: choose another, or use --force to overwrite files "
                    "of the same names",
                    at_terminal=True,
                    folder=self._folder,
                    file=others[0],
                    more=len(others) - 1,
                )
        return found

    def start(self, header: bytes, over: Manifest | None = None) -> None:
        """Create the folder and the manifest's first line, after removing an old set's files."""
        with refused_writes(self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)
            for entry in over.entries if over else ():
                (self._folder / entry.file).unlink(missing_ok=True)
                if "/" in entry.file:
                    # The folder isn't empty yet.
                    with contextlib.suppress(OSError):
                        (self._folder / entry.file).parent.rmdir()
        self._journal.start(header)

    def resume(self, old: Manifest) -> int:
        """Count the files that match the manifest.

        All files after a missing or empty one are made again.
        """
        end = len(old.first)
        done = 0
        for entry, line in zip(old.entries, old.lines, strict=True):
            if not self.holds(entry, force=False):
                break
            end = end + len(line)
            done = done + 1
        self._journal.cut(end)
        return done

    def holds(self, entry: ManifestEntry, *, force: bool) -> bool:
        """Return True if the file of a world matches the manifest.

        A missing or empty file, as after a power cut, does not.

        Raises:
            OutputError: If it has other content, and ``force`` does not allow overwriting it.
        """
        file = self._folder / entry.file
        with refused_writes(file):
            data = file.read_bytes() if file.is_file() else b""
        same = hashlib.sha256(data).hexdigest() == entry.sha256
        if data and not same and not force:
            raise OutputError(
                "other-content",
                "{file} differs from the set's file",
                "move it away, or use --force",
                at_terminal=True,
                file=file,
            )
        return same

    def write(self, name: str, data: bytes, line: bytes) -> None:
        """Write the file, then add its line."""
        file = self._folder / name
        if not self._over_others and file.is_file():
            with refused_writes(file):
                other = file.read_bytes()
            if other and other != data:
                raise OutputError(
                    "other-content",
                    "{file} differs from the set's file",
                    "move it away, or use --force",
                    at_terminal=True,
                    file=file,
                )
        self.put(name, data)
        self._journal.append(line)

    def put(self, name: str, data: bytes) -> None:
        """Write a file under another name first, so that it appears complete or not at all."""
        file = self._folder / name
        with refused_writes(file):
            if file.parent not in self._made:
                file.parent.mkdir(exist_ok=True)
                self._made.add(file.parent)
            place_file(file, data)

    def finish(self) -> None:
        """Wait until the disk has stored the manifest."""
        self._journal.sync()

    def close(self) -> None:
        """Unlock it for other commands."""
        self._journal.close()


class SetArchive(SetFolder):
    """A set that is made in a folder next to an archive, and packed into it at the end.

    Args:
        archive: The archive.
    """

    def __init__(self, archive: Path) -> None:
        super().__init__(archive.with_name(archive.name + PART))
        self._archive = archive

    def find(self, *, force: bool) -> Manifest | None:
        """Return the set that an earlier run left in the folder; refuse a complete archive."""
        found = super().find(force=force)
        if self._archive.exists() and not force:
            # The earlier run was killed between its last two steps.
            if found is not None and found.finished:
                self._remove_folder()
            raise OutputError(
                "file-exists",
                "{archive} already exists",
                "use --force to replace it, or another name",
                at_terminal=True,
                archive=self._archive,
            )
        return found

    def start(self, header: bytes, over: Manifest | None = None) -> None:
        """Create the folder next to the archive."""
        super().start(header, over)
        if self._archive.exists() and not self._over_others:
            self._remove_folder()
            raise OutputError(
                "written-meanwhile",
                "{archive} was made by another command in the meantime",
                "look at it, or choose another archive",
                archive=self._archive,
            )

    def finish(self) -> None:
        """Pack the files, the manifest first."""
        packed = self._folder / ".packed"
        manifest = read_manifest(self._journal.path)
        # Pack into a temporary file and rename it, so that a reader never sees half an archive.
        with refused_writes(self._archive):
            with packed.open("wb") as stream:
                archive = ZipWriter(stream)
                archive.add(MANIFEST, b"".join((manifest.first, *manifest.lines)))
                for entry in manifest.entries:
                    archive.add(entry.file, self._bytes_of(entry))
                archive.close()
                # Without fsync, a crash after the rename could leave an empty file under the final
                # name.
                stream.flush()
                os.fsync(stream.fileno())
            packed.replace(self._archive)
        self._remove_folder()

    def _bytes_of(self, entry: ManifestEntry) -> bytes:
        file = self._folder / entry.file
        data = file.read_bytes() if file.is_file() else b""
        if hashlib.sha256(data).hexdigest() != entry.sha256:
            raise OutputError(
                "file-changed",
                "{file} was changed on disk in the meantime",
                "run the same command again",
                file=file,
            )
        return data

    def _remove_folder(self) -> None:
        # This happens on systems that cannot remove open files and have no locks.
        if os.name == "nt":
            self.close()
        shutil.rmtree(self._folder, ignore_errors=True)
        # Unlock only now, because another command must not start in a folder that is being removed.
        self.close()


def place_file(file: Path, data: bytes) -> None:
    """Move a file into place in one step.

    It does not wait for the disk, whose faults ``resume`` finds.
    """
    part = file.with_name(f".{file.name}{PART}")
    try:
        part.write_bytes(data)
        part.replace(file)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink()
        raise
