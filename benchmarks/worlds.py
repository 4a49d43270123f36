"""Measure how fast worlds are made, proved, checked, written and read, against other programs.

``python -m benchmarks.worlds`` prints tables; ``--json`` prints one object; ``--document
docs/notes/search.md`` also writes the tables to that page, between its marks. Times are those
of one core's processor, the best of ``--rounds``, without compilation. Start-up is wall time, also
without compilation.

- ``worlds``: million cells per second of only a layout, and of ``generate``: layout, proof and
  world.
- ``proofs``: seconds to decide one world of the largest of ``--sizes``, and to check the
  certificate.
- ``batch``: microseconds for each of many worlds of 30 x 30 cells, without and with its witness;
  and the same with a wall across, without and with the cut that proves it.
- ``files``: seconds to write and read a world of the largest size.
- ``start``: seconds from the command line.

Peers of the proof look at whole cells: walls are inflated by the radius (scipy's exact distance
transform, from cell to cell), and the rest is labelled (scipy) or searched (tcod). That is faster,
but a different question: the robot is in the middle of a cell, so a passage of two cells stops a
disc of 1.4. ``agrees`` says whether the peer's answer was the true one. A peer that is not
installed is named.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from worldgen import generate
from worldgen.family import FAMILIES, stream_for
from worldgen.files.grid import dumps, loads, read_world, write_world
from worldgen.lattice import radius_in_cells
from worldgen.reach import REACHABLE, check_certificate, decide
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--sizes", "60", "--rounds", "1")

STILL = ("corridor", "trap", "maze", "rooms", "cave", "forest", "rubble")
BATCH = 100
MARKS = (
    "<!-- table: python -m benchmarks.worlds --document docs/notes/search.md -->",
    "<!-- end of table -->",
)


def _layout(name: str, size: int, seed: int = 1, **params: Any) -> World:
    made_by = FAMILIES.get(name)
    return made_by.build(stream_for(seed, name, 0), **made_by.complete({"size": size, **params}))


def _best(work: Callable[[], Any], rounds: int) -> float:
    """Return the least seconds of processor time; the first run only compiles and loads."""
    work()
    best = float("inf")
    for _ in range(rounds):
        begin = time.process_time()
        work()
        best = min(best, time.process_time() - begin)
    return best


def _rates(sizes: list[int], rounds: int) -> dict[str, Any]:
    rates: dict[str, Any] = {}
    for name in STILL:
        for size in sizes:
            layout = _best(functools.partial(_layout, name, size), rounds)
            whole = _best(functools.partial(generate, name, 1, size=size), rounds)
            rates.setdefault(name, {})[size] = {
                "layout": size**2 / layout / 1e6,
                "generate": size**2 / whole / 1e6,
            }
    return rates


def _scattered(side: int, radius: float, *, blocked: bool) -> World:
    """Return sparse single cells that a disc can pass, and perhaps a row that stops it.

    ``radius`` is the disc's, in cells.
    """
    chance = np.random.default_rng(7)
    walls = np.zeros((side, side), np.bool_)
    room = int(radius) + 3
    count = int(0.004 * side**2 / radius**1.5)
    walls[chance.integers(0, side, count), chance.integers(0, side, count)] = True
    walls[: 3 * room, : 3 * room] = walls[-3 * room :, -3 * room :] = False
    if blocked:
        walls[side // 2, :: int(2 * radius)] = True
    near = room / 10
    far = (side - room) / 10
    return World(walls, Pose(near, near), Target(far, far, 0.05), robot_radius=radius / 10)


def _asked(side: int) -> Iterator[tuple[str, World]]:
    """Yield the cases of the proof: worlds of every kind, and discs of many widths."""
    for name in STILL:
        yield name, _layout(name, side)
    yield "maze, backtracker", _layout("maze", side, algorithm="backtracker")
    yield "maze, robot 4.8 cells wide", _layout("maze", side, passage=5, robot_radius=0.24)
    # Worlds without walls, or with one wall, bound the time from both sides.
    empty = np.zeros((side, side), np.bool_)
    ends = Pose(0.15, 0.15), Target(side / 10 - 0.15, side / 10 - 0.15, 0.05)
    yield "nothing in the way", World(empty, *ends)
    wall = empty.copy()
    wall[side // 2] = True
    yield "one wall across", World(wall, *ends)
    # Obstacles of several radii, once with a gap left and once closed.
    for radius in (3, 10, 30):
        yield (
            f"cells here and there, radius {radius} cells",
            _scattered(side, radius, blocked=False),
        )
        yield (
            f"a row of posts across, radius {radius} cells",
            _scattered(side, radius, blocked=True),
        )


def _widened(world: World) -> Any:
    """Return cells whose centre is at least the radius from all solid cells (usual inflation)."""
    ndimage: Any = importlib.import_module("scipy.ndimage")
    distance = ndimage.distance_transform_edt(~np.pad(world.walls, 1, constant_values=True))[
        1:-1, 1:-1
    ]
    return distance - 0.5 >= float(radius_in_cells(world))


def _cell(world: World, point: Pose | Target) -> tuple[int, int]:
    return min(int(point.y / world.cell_size), world.height - 1), min(
        int(point.x / world.cell_size), world.width - 1
    )


def _scipy_labels(world: World) -> bool:
    ndimage: Any = importlib.import_module("scipy.ndimage")
    labels = ndimage.label(_widened(world), np.ones((3, 3)))[0]
    home = labels[_cell(world, world.start)]
    return bool(home and home == labels[_cell(world, world.target)])


def _tcod_path(world: World) -> bool:
    path: Any = importlib.import_module("tcod.path")
    free = _widened(world)
    begin = _cell(world, world.start)
    end = _cell(world, world.target)
    finder = path.Pathfinder(path.SimpleGraph(cost=free.astype(np.int8), cardinal=70, diagonal=99))
    finder.add_root(begin)
    return bool(free[begin] and free[end] and len(finder.path_to(end)) > 1)


PEERS: dict[str, Callable[[World], bool]] = {"scipy labels": _scipy_labels, "tcod path": _tcod_path}


def _proofs(side: int, rounds: int, absent: set[str]) -> dict[str, Any]:
    proofs: dict[str, Any] = {}
    for name, world in _asked(side):
        decision = decide(world)
        one: dict[str, Any] = {
            "result": decision.result,
            "seconds": _best(functools.partial(decide, world), rounds),
        }
        with_proof = functools.partial(check_certificate, world, decision.certificate)
        one["check"] = _best(with_proof, 1)
        one["valid"] = with_proof().valid
        # Peers decide reachability without a proof, so the answers are compared as well.
        for peer, ask in PEERS.items():
            try:
                answer = ask(world)
                seconds = _best(functools.partial(ask, world), 1)
            except ImportError as error:
                absent.add(f"{peer}: not installed ({error})")
            else:
                agrees = answer == (decision.result == REACHABLE)
                one[peer] = {
                    "seconds": seconds,
                    "ratio": seconds / one["seconds"],
                    "agrees": agrees,
                }
        proofs[name] = one
    return proofs


def _decide_all(worlds: Sequence[World], *, certificate: bool = True) -> None:
    for world in worlds:
        decide(world, certificate=certificate)


def _batch(rounds: int) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name in STILL:
        worlds = [_layout(name, 30, seed) for seed in range(BATCH)]
        one: dict[str, float] = {}
        one["decided"] = (
            _best(functools.partial(_decide_all, worlds, certificate=False), rounds) / BATCH * 1e6
        )
        one["with witness"] = _best(functools.partial(_decide_all, worlds), rounds) / BATCH * 1e6
        walled = [_walled(world) for world in worlds]
        one["blocked"] = (
            _best(functools.partial(_decide_all, walled, certificate=False), rounds) / BATCH * 1e6
        )
        one["with cut"] = _best(functools.partial(_decide_all, walled), rounds) / BATCH * 1e6
        one["scipy labels"] = (
            _best(lambda worlds=worlds: [_scipy_labels(world) for world in worlds], 1) / BATCH * 1e6
        )
        result[name] = one
    return result


def _walled(world: World) -> World:
    """Return the world with a wall halfway between start and target, across all of it."""
    walls = world.walls.copy()
    (from_row, from_column), (to_row, to_column) = (
        _cell(world, world.start),
        _cell(world, world.target),
    )
    if abs(to_row - from_row) > abs(to_column - from_column):
        walls[(from_row + to_row) // 2] = True
    else:
        walls[:, (from_column + to_column) // 2] = True
    return replace(world, walls=walls)


def _files(side: int, rounds: int) -> dict[str, Any]:
    result: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        packed = Path(folder) / "world.grid.gz"
        foreign = Path(folder) / "world.npz"
        for name, params in (
            ("maze", {}),
            ("maze, backtracker", {"algorithm": "backtracker"}),
            ("cave", {}),
        ):
            world = generate(name.split(",")[0], 1, size=side, **params)
            text = dumps(world)
            result[name] = {
                "bytes": len(text),
                "write": _best(functools.partial(dumps, world), rounds),
                "read": _best(functools.partial(loads, text), rounds),
                "write .gz": _best(
                    functools.partial(write_world, world, packed, force=True), rounds
                ),
                "read .gz": _best(functools.partial(read_world, packed), rounds),
                "numpy.savez_compressed": _best(
                    functools.partial(np.savez_compressed, foreign, world.walls), rounds
                ),
            }
    return result


def _start(rounds: int) -> dict[str, float]:
    """Return wall seconds of whole commands."""
    commands = {
        "worldgen --help": ["--help"],
        "worldgen maze": ["maze", "--seed", "1"],
        "worldgen maze --size 100": ["maze", "--size", "100", "--seed", "1"],
        "worldgen maze --size 600": ["maze", "--size", "600", "--seed", "1"],
    }
    result = {}
    for name, words in commands.items():
        times = []
        for _ in range(rounds + 1):
            begin = time.perf_counter()
            subprocess.run(
                [sys.executable, "-m", "worldgen", *words], check=True, capture_output=True
            )
            times.append(time.perf_counter() - begin)
        result[name] = min(times[1:])
    return result


def measure(sizes: list[int], rounds: int) -> dict[str, Any]:
    """Return all results as one object."""
    absent: set[str] = set()
    side = sizes[-1]
    return {
        "side": side,
        "start": _start(rounds),
        "worlds": _rates(sizes, rounds),
        "proofs": _proofs(side, rounds, absent),
        "batch": _batch(rounds),
        "files": _files(side, rounds),
        "absent": sorted(absent),
    }


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _markdown(result: dict[str, Any]) -> str:
    """Return the tables of one run."""
    side = result["side"]
    sizes = [int(size) for size in next(iter(result["worlds"].values()))]
    by_size = [[rates[size] for size in rates] for rates in result["worlds"].values()]
    worlds = [
        [name, *(f"{one[case]:.1f}" for one in row for case in ("layout", "generate"))]
        for name, row in zip(result["worlds"], by_size, strict=True)
    ]
    proofs = [
        [
            name,
            one["result"],
            f"{one['seconds']:.3f}",
            f"{one['check']:.3f}",
            *(_peer(one.get(peer)) for peer in PEERS),
        ]
        for name, one in result["proofs"].items()
    ]
    batch = [
        [name, *(f"{number:,.0f}" for number in one.values())]
        for name, one in result["batch"].items()
    ]
    files = [
        [name, *(f"{one[key]:.3f}" for key in list(one)[1:])]
        for name, one in result["files"].items()
    ]
    start = [
        [f"`{name}`" if name.startswith("worldgen") else name, f"{s:.2f}"]
        for name, s in result["start"].items()
    ]
    parts = [
        "Million cells a second:",
        _table(
            [
                "family",
                *(f"{case}, {size}" for size in sizes for case in ("layout", "whole world")),
            ],
            worlds,
        ),
        f"Proofs at {side} x {side} cells, s; in brackets the peer's time over ours:",
        _table(["world", "answer", "proof", "check", *PEERS], proofs),
        "Microseconds for a world of 30 x 30 cells:",
        _table(["family", "decided", "with witness", "blocked", "with cut", "scipy labels"], batch),
        f"Files of {side} x {side} cells, s:",
        _table(["world", *list(next(iter(result["files"].values())))[1:]], files),
        "Start-up, s:",
        _table(["command", "s"], start),
        *(f"Left out: {why}." for why in result["absent"]),
    ]
    return "\n\n".join(parts)


def _peer(one: dict[str, Any] | None) -> str:
    if one is None:
        return "-"
    return f"{one['seconds']:.3f} ({one['ratio']:.1f} x){'' if one['agrees'] else ', wrong'}"


def documented(text: str, tables: str, marks: tuple[str, str] = MARKS) -> str:
    """Return a document with new tables between its marks.

    Raises:
        ValueError: If it has no marks.
    """
    before, found, rest = text.partition(marks[0])
    _, end, after = rest.partition(marks[1])
    if not (found and end):
        raise ValueError(f"no {marks[0]} and {marks[1]}; add the two lines where the tables belong")
    return f"{before}{marks[0]}\n\n{tables}\n\n{marks[1]}{after}"


def main() -> None:
    """Run all and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--sizes", default="600,2000", help="cells a side, with commas between (default 600,2000)"
    )
    parser.add_argument("--rounds", type=int, default=3, help="rounds; the best counts (default 3)")
    parser.add_argument("--document", type=Path, help="put the tables into this document too")
    arguments = parser.parse_args()
    result = measure(sorted(int(size) for size in arguments.sizes.split(",")), arguments.rounds)
    tables = _markdown(result)
    if arguments.document is not None:
        arguments.document.write_text(documented(arguments.document.read_text(), tables))
    click.echo(json.dumps(result) if arguments.json else tables)


if __name__ == "__main__":
    main()
