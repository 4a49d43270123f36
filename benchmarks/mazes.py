"""Measure how fast mazes are made, here and by other libraries, and the memory of a large one.

``python -m benchmarks.mazes`` prints tables; ``--json`` prints one object. Rates are million cells
per second of processor time on one core, the best of ``--rounds``; cells are those of the resulting
square, with passages and walls one cell wide. ``tree`` is only the maze, as links between chambers;
``grid`` is maze and solid cells; ``world`` is a whole World, without its proof. ``fill`` is the
cost of writing one byte a cell.

Peers run once at each side of ``--sizes``, and at 60, as long as a run is expected to take at most
``--peer-seconds``; the ratio is that of ``grid`` at the peer's largest side. A peer that is not
installed is named. The peers differ: labmaze and tcod have none of these algorithms (labmaze: a
maze between rooms, here without rooms; tcod: a binary space partition), and the Python peers return
grids or lattices of another kind.

``python -m benchmarks.mazes --memory`` makes one maze with each algorithm that fits, each in its
own process, at the largest of ``--sizes``, and reports its peak memory beyond the resulting grid.
"""

from __future__ import annotations

import argparse
import importlib
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np

from worldgen.families.builtin.maze import maze
from worldgen.families.parts.mazes import METHODS, cells_of, grow, pitch
from worldgen.random_streams import RandomStream

# The words of a round that takes seconds; the gate runs it.
TINY = ("--sizes", "60", "--rounds", "1", "--peer-seconds", "0")

LARGE = (
    "eller",
    "sidewinder",
    "binary-tree",
    "recursive-division",
    "backtracker",
    "hunt-and-kill",
    "wilson",
    "growing-tree",
)
FIRST_PEER_SIDE = 60

# Share of the chambers a side.
Maker = Callable[[int], Any]


def _mazelib(name: str) -> Maker:
    generator: Any = getattr(importlib.import_module(f"mazelib.generate.{name}"), name)
    return lambda chambers: generator(chambers, chambers).generate()


def _maze_dataset(name: str) -> Maker:
    generators: Any = importlib.import_module("maze_dataset.generation").LatticeMazeGenerators
    make = getattr(generators, name)
    return lambda chambers: make(grid_shape=np.array([chambers, chambers]))


def _labmaze() -> Maker:
    library: Any = importlib.import_module("labmaze")
    return lambda chambers: library.RandomMaze(
        2 * chambers + 1, 2 * chambers + 1, max_rooms=0, random_seed=1
    )


def _tcod() -> Maker:
    library: Any = importlib.import_module("tcod.bsp")

    def make(chambers: int) -> Any:
        side = 2 * chambers + 1
        tree = library.BSP(0, 0, side, side)
        walls = np.ones((side, side), np.bool_)
        tree.split_recursive(depth=2 * side.bit_length(), min_width=3, min_height=3, max_horizontal_ratio=2,
                             max_vertical_ratio=2)  # fmt: skip
        for leaf in tree.pre_order():
            if not leaf.children:
                walls[leaf.y + 1 : leaf.y + leaf.height, leaf.x + 1 : leaf.x + leaf.width] = False
        return walls

    return make


# Peer: our algorithm that it is compared with, and how to get it.
PEERS: dict[str, tuple[str, Callable[[], Maker]]] = {
    "mazelib BacktrackingGenerator": ("backtracker", lambda: _mazelib("BacktrackingGenerator")),
    "mazelib Wilsons": ("wilson", lambda: _mazelib("Wilsons")),
    "mazelib AldousBroder": ("aldous-broder", lambda: _mazelib("AldousBroder")),
    "mazelib HuntAndKill": ("hunt-and-kill", lambda: _mazelib("HuntAndKill")),
    "mazelib Kruskal": ("kruskal", lambda: _mazelib("Kruskal")),
    "mazelib Prims": ("prim", lambda: _mazelib("Prims")),
    "mazelib GrowingTree": ("growing-tree", lambda: _mazelib("GrowingTree")),
    "mazelib Ellers": ("eller", lambda: _mazelib("Ellers")),
    "mazelib Sidewinder": ("sidewinder", lambda: _mazelib("Sidewinder")),
    "mazelib BinaryTree": ("binary-tree", lambda: _mazelib("BinaryTree")),
    "mazelib Division": ("recursive-division", lambda: _mazelib("Division")),
    "maze-dataset gen_dfs": ("backtracker", lambda: _maze_dataset("gen_dfs")),
    "maze-dataset gen_wilson": ("wilson", lambda: _maze_dataset("gen_wilson")),
    "maze-dataset gen_kruskal": ("kruskal", lambda: _maze_dataset("gen_kruskal")),
    "maze-dataset gen_prim": ("prim", lambda: _maze_dataset("gen_prim")),
    "labmaze RandomMaze": ("backtracker", _labmaze),
    "tcod BSP": ("recursive-division", _tcod),
}


def _grid(name: str, chambers: int, seed: int) -> Any:
    strips = pitch([1] * chambers, 1)
    links = grow(RandomStream(seed), np.ones((chambers, chambers), np.bool_), name)
    return cells_of(links, strips, strips)


def _world(name: str, side: int, seed: int) -> Any:
    params = {"size": side, "algorithm": name, "passage": 1, "robot_radius": 0.05}
    return maze.build(RandomStream(seed), **maze.complete(params))


def _seconds(make: Callable[[], Any]) -> float:
    begin = time.process_time()
    make()
    return time.process_time() - begin


def _cases(side: int, seed: int) -> Iterator[tuple[str, str, Callable[[], Any]]]:
    """Yield algorithm, case and function to time."""
    chambers = (side - 1) // 2
    full = np.ones((chambers, chambers), np.bool_)
    yield "fill", "fill", partial(np.ones, (2 * chambers + 1) ** 2, np.bool_)
    for name in METHODS:
        yield name, "tree", partial(grow, RandomStream(seed), full, name)
        yield name, "grid", partial(_grid, name, chambers, seed)
        yield name, "world", partial(_world, name, side, seed)


def _rate(side: int, seconds: float) -> float:
    """Return million cells per second."""
    return (2 * ((side - 1) // 2) + 1) ** 2 / max(seconds, 1e-9) / 1e6


def measure(sizes: list[int], rounds: int) -> dict[str, dict[int, dict[str, float]]]:
    """Return million cells per second of each algorithm, side and case.

    ``fill`` only writes memory.
    """
    best: dict[str, dict[int, dict[str, float]]] = {}
    for turn in range(rounds + 1):
        for side in sizes:
            for name, case, make in _cases(side, turn):
                rate = _rate(side, _seconds(make))
                rates = best.setdefault(name, {}).setdefault(side, {})
                # The first one only warms up.
                rates[case] = max(rate, rates.get(case, 0.0)) if turn > 0 else 0.0
    return best


def measure_peers(sizes: list[int], limit: float) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return million cells per second of each peer at each side that fits into the time.

    Also return which peers are missing, and why.
    """
    rates: dict[str, dict[str, Any]] = {}
    absent = []
    for name, (ours, load) in PEERS.items():
        try:
            make = load()
            done = _climb(make, sorted({FIRST_PEER_SIDE, *sizes}), limit)
        except (ImportError, AttributeError) as error:
            absent.append(f"{name}: not installed ({error})")
        except Exception as error:  # noqa: BLE001 - a peer's own fault is a result
            absent.append(f"{name}: {type(error).__name__}: {error}")
        else:
            side = max(done)
            # Make one maze untimed, so that neither caches nor compilation are measured.
            ours_once = partial(_grid, ours, (side - 1) // 2, 1)
            ours_once()
            own = max(_rate(side, _seconds(ours_once)) for _ in range(5))
            rates[name] = {
                "beside": ours,
                "rates": done,
                "side": side,
                "ours": own,
                "ratio": own / done[side],
            }
    return rates, absent


def _climb(make: Maker, sides: list[int], limit: float) -> dict[int, float]:
    done: dict[int, float] = {}
    seconds = 0.0
    before = sides[0]
    for side in sides:
        # The time of some grows with the square of the cells, or faster.
        if seconds * (side / before) ** 3 > limit:
            break
        seconds = _seconds(partial(make, (side - 1) // 2))
        before = side
        done[side] = _rate(side, seconds)
    return done


def peak_memory(name: str, side: int) -> dict[str, float]:
    """Return the cost of one large grid in a new process.

    It is given in seconds, and in bytes per cell beyond the grid itself.
    """
    code = f"from benchmarks.mazes import _take; _take({name!r}, {side})"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


def _take(name: str, side: int) -> None:
    # Modules loaded at first use do not count.
    _grid(name, 40, 1)
    before = _status("VmRSS")
    begin = time.process_time()
    grid = _grid(name, (side - 1) // 2, 1)
    seconds = time.process_time() - begin
    beyond = _status("VmHWM") - before - grid.nbytes
    click.echo(
        json.dumps(
            {
                "seconds": seconds,
                "bytes_a_cell": beyond / grid.size,
                "rate": grid.size / seconds / 1e6,
            }
        )
    )


def _status(field: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field):
            return int(line.split()[1]) * 1024
    raise LookupError(field)


def _tables(result: dict[str, Any], sizes: list[int]) -> str:
    lines = [
        "".join(
            [f"{'Mcells/s':24}", *(f"{f'{case} {side}':>14}" for side in sizes for case in _CASES)]
        )
    ]
    for name, by_side in result["ours"].items():
        numbers = (
            by_side[side].get(case)
            for side in sizes
            for case in (("fill",) if name == "fill" else _CASES)
        )
        lines.append("".join([f"{name:24}", *(f"{number:14,.1f}" for number in numbers)]))
    lines += ["", f"{'peer':34}{'side':>6}{'Mcells/s':>12}{'ours':>10}  ratio, and to which"]
    for name, peer in result["peers"].items():
        row = f"{name:34}{peer['side']:6}{peer['rates'][peer['side']]:12.3f}{peer['ours']:10.1f}"
        lines.append(f"{row}  {peer['ratio']:,.0f} x {peer['beside']}")
    return "\n".join([*lines, *(f"left out: {why}" for why in result["absent"])])


_CASES = ("tree", "grid", "world")


def main() -> None:
    """Run all and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--sizes", default="600,2000", help="cells a side, with commas between (default 600,2000)"
    )
    parser.add_argument("--rounds", type=int, default=5, help="rounds; the best counts (default 5)")
    parser.add_argument(
        "--peer-seconds",
        type=float,
        default=10.0,
        help="longest run of a peer (default 10); 0: none",
    )
    parser.add_argument(
        "--memory", action="store_true", help="measure memory instead, at the largest size"
    )
    arguments = parser.parse_args()
    sizes = sorted(int(side) for side in arguments.sizes.split(","))
    # Peak memory is of a whole process, so it has a run without timing.
    if arguments.memory:
        taken = {name: peak_memory(name, sizes[-1]) for name in LARGE}
        lines = (
            f"{name:24}{one['seconds']:8.2f} s {one['rate']:8.1f} Mcells/s "
            f"{one['bytes_a_cell']:6.2f} bytes a cell more"
            for name, one in taken.items()
        )
        click.echo(json.dumps(taken) if arguments.json else "\n".join(lines))
        return
    peers, absent = (
        measure_peers(sizes, arguments.peer_seconds) if arguments.peer_seconds > 0 else ({}, [])
    )
    result = {"ours": measure(sizes, arguments.rounds), "peers": peers, "absent": absent}
    click.echo(json.dumps(result) if arguments.json else _tables(result, sizes))


if __name__ == "__main__":
    main()
