"""Helpers shared by the commands that make sets: progress, interruptions, and the JSON object."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from worldgen.cli.output import draw_seed, emit_json, note
from worldgen.cli.robot_options import warn_of_start_in_target
from worldgen.errors import OutputError, WorldgenError
from worldgen.robot_overrides import RobotOverrides
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.sets import SetPlan

# Number of worlds below which starting processes takes longer than it saves.
_LARGE = 200


@dataclass(frozen=True)
class Output:
    """What a command writes, and where.

    Args:
        path: File of one world, or folder or archive of a set; None for stdout.
        count: Worlds of a set; None for one world.
        metrics: True to measure each world; None to decide by its size.
        force: True to replace what exists.
        as_json: True to print one JSON object.
    """

    path: Path | None
    count: int | None
    metrics: bool | None
    force: bool
    as_json: bool


def make_many(plan: SetPlan, seed: int | None, out: Path, *, force: bool, as_json: bool) -> None:
    """Make a set, or continue one.

    Args:
        plan: The set; its first seed may still change.
        seed: Seed of the first world; if omitted, the seed of an unfinished set there, or else a
        random one.
        out: Folder or archive.
        force: True to replace what exists.
        as_json: True to print one JSON object.
    """
    from worldgen.domain import MASK64
    from worldgen.files.worlds import read_worlds
    from worldgen.sets import make_set, manifest_of

    plan = plan.with_seed(_seed(plan, seed, out, force=force))
    header = plan.header
    count = plan.header.count
    with told(out, count, force=force) as progress:
        done = make_set(plan, out, workers=workers_for(count), force=force, progress=progress)
    last = (header.seed + count - 1) & MASK64
    note(
        f"{out}: {count} worlds of {header.family}, "
        + (
            f"found for {header.constraint!r}"
            if header.constraint
            else f"seeds {header.seed} to {last}"
        )
    )
    overrides = RobotOverrides.of(header.params)
    if overrides.target_radius is not None:
        path, first = next(read_worlds([out]))
        warn_of_start_in_target(overrides, first, f"{path}: ")
    if as_json:
        asked = {
            "family": header.family,
            "version": header.version,
            "seed": header.seed,
            "params": header.params,
        }
        asked |= {"constraint": header.constraint} if header.constraint else {}
        entries = [entry.as_dict() for entry in manifest_of(out).entries]
        files = [{**entry, "file": str(out / entry["file"])} for entry in entries]
        emit_json(
            {**asked, "count": count, "out": str(out), "resumed": done.resumed, "files": files}
        )


def _seed(plan: SetPlan, seed: int | None, out: Path, *, force: bool) -> int:
    from worldgen.sets import begun_set

    begun = begun_set(out) if seed is None and not force else None
    if begun is not None and begun == plan.with_seed(begun.seed).header:
        note(f"seed {begun.seed}", always=True)
        return begun.seed
    return draw_seed(seed)


def workers_for(count: int) -> int:
    """Return the number of processes for this many worlds: one per core that we may use."""
    if count < _LARGE:
        return 1
    usable = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else ()
    return min(len(usable) or os.cpu_count() or 1, 256)


@contextmanager
def told(out: Path, count: int, *, force: bool) -> Iterator[Callable[[int], None]]:
    """Yield a callback that takes the number of worlds saved so far.

    It reports that number if the work ends early. With ``force`` the same command would start over.
    """
    safe = -1
    with working(f"writing {out}") as work:

        def progress(done: int) -> None:
            # The first call reports the worlds that were on disk; later calls only advance the bar.
            nonlocal safe
            if safe < 0 < done:
                note(f"{out}: {done} of {count} worlds already exist; continuing")
            safe = done
            work.count(done, count, "worlds")

        try:
            yield progress
        except (KeyboardInterrupt, WorldgenError) as error:
            if safe >= 0:
                on = (
                    ""
                    if isinstance(error, WorldgenError) and not isinstance(error, OutputError)
                    else _going_on(out, force=force)
                )
                note(f"{out}: {safe} of {count} worlds are written{on}", always=True)
            raise


def _going_on(out: Path, *, force: bool) -> str:
    if not force:
        return "; the same command continues from there"
    moved = f", once {out} is moved away," if out.is_file() else ""
    return f"; the same command without --force{moved} continues from there"
