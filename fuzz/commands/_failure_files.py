"""The failures in the files, folders and archives that a command was given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fuzz.failure import Failure
from worldgen.cli.output import note, skip_bad_file
from worldgen.errors import FormatError
from worldgen.files.worlds import read_worlds
from worldgen.support.plain_text import counted
from worldgen.world import World


class FailureFiles:
    """Yields each failure with its path, and counts the worlds without one.

    Args:
        paths: Files, folders and archives.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self.others = 0
        self._paths = paths
        self._empty = list(dict.fromkeys(paths))

    def __iter__(self) -> Iterator[tuple[Path, Failure]]:
        for path, world in self._worlds():
            failure = Failure.found_in(world)
            if failure is None:
                self.others += 1
                continue
            self._empty = [one for one in self._empty if not path.is_relative_to(one)]
            yield path, failure
        for path in self._empty:
            what = "no world here has a" if path.is_dir() else "this world has no"
            note(f"{path}: {what} failure; worldgen run simulates it")
        if not self._empty and self.others:
            note(f"skipped {counted(self.others, 'world')} without a failure")

    def _worlds(self) -> Iterator[tuple[Path, World]]:
        try:
            yield from read_worlds(self._paths, self._skip)
        except FormatError as error:
            raise _of_campaign(error) from error

    def _skip(self, error: FormatError) -> None:
        # Whether a file that cannot be read has a failure is not known.
        self._empty = [one for one in self._empty if str(one) != error.source]
        skip_bad_file(_of_campaign(error))

    @property
    def is_complete(self) -> bool:
        """True if each path that was given has a failure."""
        return not self._empty


def _of_campaign(error: FormatError) -> FormatError:
    """Return an error about a folder without worlds, in other words if it is a campaign's."""
    folder = Path(error.source or "")
    from fuzz.campaign.store import MEMORY

    if error.code != "no-map-found" or not (folder / MEMORY).is_dir():
        return error
    return FormatError(
        "no-failure",
        "the campaign of this folder has found no failure",
        "worldgen fuzz --resume continues it",
        at_terminal=True,
        source=error.source,
    )
