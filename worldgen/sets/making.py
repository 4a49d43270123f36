"""Make worlds of given identities, in this process or in several.

Both give the same bytes in the same order.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from itertools import islice
from typing import cast

from worldgen.difficulty import measure
from worldgen.errors import GenerationFailed, WorldgenError
from worldgen.files.grid import dumps, world_digest
from worldgen.generation import generate
from worldgen.plugins.workers import LISTEN, WorkerPool, ctrl_c_held_back
from worldgen.world import Provenance, Value, World

# Area that a process gets at a time, square metres: some tenths of a second of work.
_CELLS = 50_000
# Limit on the worlds that a process gets at a time.
_MOST = 64
# Pieces of work per process that are assigned or finished early.
_WAITING = 2


@dataclass(frozen=True)
class Job:
    """A world to make.

    Args:
        family: Its family, as named for the registry.
        seed: Its seed.
        params: Its parameters; the file's provenance names these and no others.
        metrics: Metrics for the file's provenance; ``None`` to measure them now.
    """

    family: str
    seed: int
    params: Mapping[str, Value]
    metrics: Mapping[str, float] | None


@dataclass(frozen=True)
class Made:
    """A world that has been made.

    Args:
        seed: Its seed.
        params: Its parameters.
        data: Contents of its file.
        digest: The world's id.
        sha256: SHA-256 of the file.
        metrics: Its metrics.
        stratum: Lower and upper end of the stratum of difficulty that it was found for, if there
            are strata.
    """

    seed: int
    params: Mapping[str, Value]
    data: bytes
    digest: str
    sha256: str
    metrics: Mapping[str, float]
    stratum: tuple[float, ...] = ()

    @classmethod
    def of(cls, world: World, params: Mapping[str, Value], metrics: Mapping[str, float]) -> Made:
        """Return the file of a world whose provenance names these parameters and metrics."""
        # generate() makes no world without one.
        made = cast("Provenance", world.provenance)
        data = dumps(replace(world, provenance=replace(made, params=params, metrics=metrics)))
        return cls(
            made.seed, params, data, world_digest(world), hashlib.sha256(data).hexdigest(), metrics
        )


_Done = tuple[list[Made], WorldgenError | None]


def make_all(jobs: Iterable[Job], workers: int = 1) -> Iterator[Made]:
    """Make worlds in the order of the jobs.

    Args:
        jobs: The worlds to make.
        workers: Number of processes; 1 means this one.

    Raises:
        WorldgenError: If making one of them raises it, after all earlier worlds were returned; or
            if a process dies.
    """
    # One worker needs no pool: the worlds are made in this process.
    if workers == 1:
        yield from map(_make, jobs)
        return
    pool = WorkerPool(workers)
    # Ctrl+C is delivered only between worlds, so that no half-made world is yielded.
    with ctrl_c_held_back() as listen:
        try:
            yield from _with_pool(pool, iter(jobs), workers, listen)
        except BrokenProcessPool as error:
            pool.end()
            raise GenerationFailed(
                "worker-died",
                "a worker process died, perhaps for lack of memory",
                "use fewer workers with --workers",
                at_terminal=True,
            ) from error
        # Whatever else stops the caller, no worker is left running.
        except BaseException:
            pool.end()
            raise
        pool.shutdown()


def _with_pool(
    pool: WorkerPool, jobs: Iterator[Job], workers: int, listen: Callable[[], None]
) -> Iterator[Made]:
    waiting: deque[Future[_Done]] = deque()
    while True:
        # Keep a bounded number of pieces submitted: worlds are made ahead of need, but memory stays
        # flat.
        while len(waiting) < workers * _WAITING and (piece := _next_piece(jobs)):
            waiting.append(pool.submit(_make_piece, piece))
        if not waiting:
            return
        # Take the results in order of submission, so the order doesn't depend on the workers.
        made, error = _wait(waiting.popleft(), listen)
        for world in made:
            yield world
            listen()
        # The worlds made before the error have been yielded; now report it.
        if error is not None:
            raise error


def _wait(future: Future[_Done], listen: Callable[[], None]) -> _Done:
    while True:
        listen()
        try:
            return future.result(LISTEN)
        except TimeoutError:
            # The work itself timed out.
            if future.done():
                raise


def _next_piece(jobs: Iterator[Job]) -> list[Job]:
    first = next(jobs, None)
    if first is None:
        return []
    side = first.params.get("size", 100)
    cells = side * side if isinstance(side, int) and side > 0 else _CELLS
    return [first, *islice(jobs, min(_MOST, _CELLS // cells))]


def _make_piece(jobs: list[Job]) -> _Done:
    made: list[Made] = []
    for job in jobs:
        try:
            made.append(_make(job))
        except WorldgenError as error:
            return made, error
    return made, None


def _make(job: Job) -> Made:
    world = generate(job.family, job.seed, **job.params)
    return Made.of(
        world, job.params, measure(world).as_dict() if job.metrics is None else job.metrics
    )
