"""Simulate many runs in one call: worlds x controllers x starts x seeds, on all cores.

Results come back in arrays, one entry per run, so that they can be analysed as a table.
"""

from __future__ import annotations

import itertools
import os
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from threading import Event
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import lib
from sim.controllers.base import Controller
from sim.controllers.catalogue import called, controller_of
from sim.episode import simulate
from sim.motion import MOTIONS
from sim.options.run import RunOptions, options_from, poses_of, seeds_of, whole, worlds_of
from sim.outcome import ENDINGS
from sim.runners.controller_host import ControllerHost, host_of
from sim.runners.lattice import LatticeRun
from sim.runners.lockstep import run_in_lockstep
from sim.runners.many import run_many
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.lattice import UNIT
from worldgen.support.arrays import Bools, Floats, Ints, Words
from worldgen.world import Pose, Value, World

VERDICTS = tuple(Verdict)
"""The verdict for each number in :attr:`Runs.verdict`."""

# Runs in one call of the core: few enough that every core gets something to do.
_MOST_AT_ONCE = 256

# Limit on robots in lockstep: enough to make NumPy worthwhile, few enough for the processor's
# cache.
_MOST_IN_A_GROUP = 1024

# Limit on the memory of the robots of one group, bytes.
_GROUP_BYTES = 1 << 26

# Limit on the memory of the logs of all current runs, bytes. Loops are found in them; they take 8
# bytes per step.
_LOG_BYTES = 1 << 30
_MOST_WORKERS = 1024
_CODE = {verdict: np.int8(code) for code, verdict in enumerate(VERDICTS)}


@dataclass(frozen=True, eq=False)
class Runs:
    """Results of many runs; every array is of shape (n,), with one entry per run.

    Args:
        world: int64, index of the world.
        controller: int64, index of the controller, also into ``names``.
        start: int64, index of the start.
        seed: uint64, the run's seed.
        verdict: int8, index into :data:`VERDICTS`.
        steps: int64, steps simulated, as in :attr:`sim.Episode.steps`.
        time: float64, simulated time, s.
        path_length: float64, distance driven, m.
        collisions: int64, number of times that the robot began to touch a wall.
        area_covered: float64, area of the cells that its centre was in after a step, m2.
        goals_reached: int64, how many of its waypoints and its target the robot arrived at.
        digest: uint64, the trace's digest; 0 unless it was requested.
        names: Names of the controllers.
    """

    world: Ints
    controller: Ints
    start: Ints
    seed: Words
    verdict: npt.NDArray[np.int8]
    steps: Ints
    time: Floats
    path_length: Floats
    collisions: Ints
    area_covered: Floats
    goals_reached: Ints
    digest: Words
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.verdict)

    @property
    def verdicts(self) -> npt.NDArray[np.str_]:
        """(n,) The verdicts as words."""
        return np.array(VERDICTS)[self.verdict]

    @property
    def reached(self) -> Bools:
        """(n,) True where the target was reached."""
        found: Bools = self.verdict == _CODE[Verdict.REACHED]
        return found

    def to_numpy(self) -> npt.NDArray[Any]:
        """Return one structured array with a field for each array of this record.

        Pandas and similar libraries read it as a table.
        """
        columns = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "names"}
        table = np.zeros(len(self), [(name, column.dtype) for name, column in columns.items()])
        for name, column in columns.items():
            table[name] = column
        return table

    def __repr__(self) -> str:
        lines = [f"{len(self)} runs, {int(self.steps.sum()):,} steps"]
        for index, name in enumerate(self.names):
            own = self.controller == index
            counts = Counter(self.verdict[own].tolist())
            words = ", ".join(f"{VERDICTS[code]} {count}" for code, count in sorted(counts.items()))
            times = self.time[own & self.reached]
            median = f"; median time {np.median(times):.3f} s" if len(times) else ""
            lines.append(f"  {name}: {words}{median}")
        return "\n".join(lines)


@dataclass(frozen=True)
class _RunBlock:
    """Runs of one controller in one world, and the rows of the results that they fill."""

    world: World
    host: ControllerHost
    rows: range
    starts: tuple[Pose, ...]
    options: RunOptions

    @property
    def in_core(self) -> bool:
        """Whether the core makes all of its runs in one call."""
        return self._is_on_lattice and self.host.in_core

    @property
    def in_lockstep(self) -> bool:
        """Whether one call of the controller acts in all of its runs."""
        return self._is_on_lattice and self.host.acts_for_many

    @property
    def _is_on_lattice(self) -> bool:
        return MOTIONS.get(self.options.motion).on_lattice


def simulate_many(
    worlds: World | Sequence[World],
    controllers: str | Controller | type | Sequence[str | Controller | type],
    options: RunOptions | None = None,
    *,
    seeds: int | Sequence[int] = 1,
    starts: Sequence[Pose] | None = None,
    digest: bool = False,
    workers: int | None = None,
    **settings: Value,
) -> Runs:
    """Run every controller in every world from every start with every seed.

    The results equal those of :func:`sim.simulate` bit for bit, whatever the number of workers.
    Rows are ordered by world, then controller, start and seed. Compiled controllers run on all
    cores; the others run one after another.

    Args:
        worlds: One world or several.
        controllers: Names of controllers, controllers themselves, or their classes.
        options: How the runs are done, as for :func:`sim.simulate`.
        seeds: The seeds, or the number of seeds to use, counted from 0.
        starts: Poses to start from in every world; if omitted, each world's own start.
        digest: True to compute the digest of each trace.
        workers: Threads, 1 to 1024; if omitted, one per core.
        **settings: Single options, as an alternative to ``options``:
            ``motion="endpoint", steps=5000, beams=36``.

    Returns:
        The results of all runs.

    Raises:
        InvalidParameter: If there is nothing to run, or a name or an option is unknown or of the
            wrong type.
        InvalidWorld: If the robot does not fit at a start.
    """
    # Turn each argument into a list, and refuse a call that would run nothing.
    found = worlds_of(worlds)
    if isinstance(controllers, str) or not isinstance(controllers, Sequence):
        controllers = [controllers]
    hosts = [host_of(controller_of(one)) for one in controllers]
    numbers = seeds_of(seeds)
    poses = None if starts is None else poses_of(starts)
    threads = (
        os.cpu_count() or 1 if workers is None else whole("workers", workers, 1, _MOST_WORKERS)
    )
    if not found or not hosts or not len(numbers) or poses == ():
        raise InvalidParameter(
            "nothing-given",
            "nothing to run",
            "use at least one world, one controller, one start and one seed",
        )
    if "seed" in settings or (isinstance(options, RunOptions) and options.seed):
        raise InvalidParameter(
            "seed-for-many-runs",
            "seed belongs to a single run; for many runs write seeds=5 or seeds=[3, 8]",
        )

    # Plan all runs. Compiled controllers share the threads, vector controllers run in lockstep, and
    # everything else runs one at a time.
    places = 1 if poses is None else len(poses)
    runs = _empty(len(found), [called(one) for one in controllers], places, numbers)
    jobs = list(_jobs(found, hosts, poses, len(numbers), options, settings))
    threaded = [job for job in jobs if job.in_core]
    _run_side_by_side(
        threaded, _at_once(threads, (job.options.steps for job in threaded)), runs, digest
    )
    _run_in_lockstep([job for job in jobs if job.in_lockstep], runs, digest)
    for job in jobs:
        if not (job.in_core or job.in_lockstep):
            _run_each(job, job.rows, runs, digest)
    return runs


def _run_side_by_side(jobs: Sequence[_RunBlock], threads: int, runs: Runs, digest: bool) -> None:
    """Run jobs in threads; an exception here, such as Ctrl-C, soon stops the threads too."""
    stop = Event()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for _ in pool.map(lambda job: _run_compiled(job, runs, digest, stop), jobs):
                pass
        except BaseException:
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _empty(worlds: int, names: Sequence[str], starts: int, seeds: Words) -> Runs:
    shape = (worlds, len(names), starts, len(seeds))
    world, controller, start, seed = (axis.ravel() for axis in np.indices(shape))
    count = len(world)
    return Runs(
        world=world,
        controller=controller,
        start=start,
        seed=seeds[seed],
        verdict=np.zeros(count, np.int8),
        steps=np.zeros(count, np.int64),
        time=np.zeros(count),
        path_length=np.zeros(count),
        collisions=np.zeros(count, np.int64),
        area_covered=np.zeros(count),
        goals_reached=np.zeros(count, np.int64),
        digest=np.zeros(count, np.uint64),
        names=tuple(names),
    )


def _jobs(
    worlds: Sequence[World],
    hosts: Sequence[ControllerHost],
    poses: tuple[Pose, ...] | None,
    seeds: int,
    given: RunOptions | None,
    settings: Mapping[str, Value],
) -> Iterator[_RunBlock]:
    first = 0
    # Check all starts before the first run: replace() raises if a pose is outside its world.
    for world, pose in itertools.product(worlds, poses or ()):
        replace(world, start=pose)
    for world, host in itertools.product(worlds, hosts):
        starts = poses or (world.start,)
        options = options_from(world, given, settings)
        rows = range(first, first + len(starts) * seeds)
        first = rows.stop
        for begin in range(rows.start, rows.stop, _MOST_AT_ONCE):
            part = range(begin, min(begin + _MOST_AT_ONCE, rows.stop))
            yield _RunBlock(world, host, part, starts, options)


def _at_once(most: int, steps: Iterable[int]) -> int:
    """Return the number of runs of this many steps, up to ``most``, whose logs fit into memory."""
    return max(1, min(most, _LOG_BYTES // (8 * (max(steps, default=0) + 1))))


def _run_in_lockstep(jobs: Sequence[_RunBlock], runs: Runs, digest: bool) -> None:
    """Run jobs together where possible: those of one controller, in worlds of one shape."""
    kinds: dict[tuple[int, Any, Any], list[tuple[_RunBlock, LatticeRun]]] = {}
    for job in jobs:
        run = LatticeRun(replace(job.world, start=job.starts[0]), job.host, job.options)
        kinds.setdefault((id(job.host), *run.shapes), []).append((job, run))
    for alike in kinds.values():
        _run_alike(alike, runs, digest)


def _run_alike(alike: Sequence[tuple[_RunBlock, LatticeRun]], runs: Runs, digest: bool) -> None:
    """Run similar jobs in lockstep, a limited number of robots at a time.

    If the controller cannot act for many robots, fall back to one run at a time.
    """
    host = alike[0][0].host

    # Lay out one row per robot: its row of the results, its world and its pose on the lattice.
    starts = []
    packed = [run for _, run in alike]
    for job, run in alike:
        places = np.array([run.start_of(pose) for pose in job.starts], np.int64)
        starts.append(places[runs.start[job.rows.start : job.rows.stop]])
    rows = np.concatenate([np.arange(job.rows.start, job.rows.stop) for job, _ in alike])
    world = np.repeat(np.arange(len(alike)), [len(job.rows) for job, _ in alike])
    poses = np.concatenate(starts)
    metres = np.array([float(run.settings.metres) for run in packed])

    # Limit a group by the cache, by the memory of its robots, and by the size of their logs.
    most = max(1, min(_MOST_IN_A_GROUP, _GROUP_BYTES // max(run.bytes_per_robot for run in packed)))
    most = _at_once(most, (run.options.steps for run in packed))

    # Run group by group; None means that the controller broke its contract for some of the robots.
    for first in range(0, len(rows), most):
        part = slice(first, first + most)
        used, index = np.unique(world[part], return_inverse=True)
        found = run_in_lockstep(
            host,
            [packed[k] for k in used],
            index,
            poses[part],
            runs.seed[rows[part]],
            digest=digest,
        )
        if found is None:
            warnings.warn(
                f"{called(host.controller)} raised an exception for some of its robots, or changed "
                "something outside its memory; it now runs for one robot at a time, which takes "
                "far longer",
                stacklevel=2,
            )
            for row, which in zip(rows[part].tolist(), world[part].tolist(), strict=True):
                _run_each(alike[which][0], range(row, row + 1), runs, digest)
        else:
            _fill(
                runs, rows[part], found, alike[0][0].options.time_step, metres[world[part]], digest
            )


def _run_compiled(job: _RunBlock, runs: Runs, digest: bool, stop: Event) -> None:
    """Run a job in one call of the core; if the controller raises, run each of its runs alone."""
    run = LatticeRun(replace(job.world, start=job.starts[0]), job.host, job.options)
    places = np.array([run.start_of(pose) for pose in job.starts], np.int64)
    rows = slice(job.rows.start, job.rows.stop)
    reports = run_many(run, places[runs.start[rows]], runs.seed[rows], digest=digest, stop=stop)
    if len(reports) and reports["ending"][-1] == lib.WG_CRASH:
        _run_each(job, job.rows, runs, digest)
        return
    _fill(runs, rows, reports, job.options.time_step, float(run.settings.metres), digest)


def _fill(
    runs: Runs,
    rows: slice | Ints,
    reports: npt.NDArray[Any],
    time_step: float,
    metres: float | Floats,
    digest: bool,
) -> None:
    """Turn the core's reports into results, by the rules of :attr:`sim.outcome.Outcome.verdict`."""
    ending = reports["ending"]
    steps = reports["steps"]
    decided = (lib.WG_TUNNEL, lib.WG_CONTACT, lib.WG_BURNED, lib.WG_INVALID_COMMAND)

    # Later rules override earlier ones: first a spent budget, then an ending of the core, then a
    # cut into a wall, then an event that ends a run in the step in which it happens.
    confined = reports["last_new_cell"] <= steps // 2
    verdict = np.where(confined, _CODE[Verdict.STALLED], _CODE[Verdict.TIMEOUT])
    for code in (lib.WG_LOOP, lib.WG_REACHED, lib.WG_COVERED):
        verdict = np.where(ending == code, _CODE[Verdict(ENDINGS[code])], verdict)
    verdict = np.where(reports["overlap_step"] >= 0, _CODE[Verdict.OVERLAP], verdict)
    for code in decided:
        verdict = np.where(ending == code, _CODE[Verdict(ENDINGS[code])], verdict)
    runs.verdict[rows] = verdict
    runs.steps[rows] = steps
    runs.time[rows] = np.round(steps * time_step, 9)
    runs.path_length[rows] = reports["path_length"] * metres
    runs.collisions[rows] = reports["collisions"]
    runs.area_covered[rows] = reports["cells_visited"] * (metres * UNIT) ** 2
    runs.goals_reached[rows] = reports["goals"]
    if digest:
        runs.digest[rows] = reports["digest"]


def _run_each(job: _RunBlock, rows: range, runs: Runs, digest: bool) -> None:
    for row in rows:
        world = replace(job.world, start=job.starts[runs.start[row]])
        episode = simulate(
            world, job.host.controller, replace(job.options, seed=int(runs.seed[row]))
        )
        runs.verdict[row] = _CODE[episode.verdict]
        for name in ("steps", "time", "path_length", "collisions", "area_covered"):
            getattr(runs, name)[row] = getattr(episode, name)
        goals = episode.goals_reached
        runs.goals_reached[row] = episode.verdict == Verdict.REACHED if goals is None else goals
        if digest:
            runs.digest[row] = int(episode.trace_digest, 16)
