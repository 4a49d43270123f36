"""The Puzzles of the POGEMA benchmark, each decided: no timeout column.

``python -m benchmarks.pogema --snapshot FOLDER --python PYTHON`` prints a Markdown table, with
``--json`` one object. FOLDER is ``raw_data_MAPF/05-puzzles`` of
github.com/Cognitive-AI-Systems/pogema-benchmark, with the published results of eight methods, and
PYTHON an interpreter that can import ``pogema==1.4.0`` and PyYAML.

An instance is *possible* if some joint plan on the grid brings all agents to their targets at the
same time; a search over all joint states decides it. In one step each agent moves to a free
neighbouring cell or waits. Two agents never share a cell or swap cells; following is allowed.

Each instance is also run with a deterministic PIBT. It arrives, or a recurrence proves that it
never does: ``deadlock`` if no agent still moves, ``livelock`` if one does.

Sources: Skrynnik et al., "POGEMA: A Benchmark Platform for Cooperative Multi-Agent Pathfinding",
ICLR 2025. Okumura, Machida, Defago, Tamura, "Priority Inheritance with Backtracking for Iterative
Multi-agent Path Finding", Artificial Intelligence 310, 2022.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import click
import numpy as np
import numpy.typing as npt

# The words of a round that takes seconds; the gate runs it.
TINY = ("--help",)  # the rest needs POGEMA and its published results

Ints = npt.NDArray[np.int64]

MOVES = ((-1, 0), (1, 0), (0, -1), (0, 1), (0, 0))
"""Steps (row, column), in the order in which PIBT prefers equally good ones; the last waits."""

_CHUNK = 4_096  # joint states that are expanded at a time, so that memory stays small


@dataclass(frozen=True)
class Instance:
    """A grid with agents.

    Args:
        name: Name of the map.
        seed: Seed with which the agents were placed.
        rows: The map, ``#`` solid.
        starts: (row, column) of each agent.
        targets: (row, column) of each agent.
    """

    name: str
    seed: int
    rows: tuple[str, ...]
    starts: tuple[tuple[int, int], ...]
    targets: tuple[tuple[int, int], ...]

    @property
    def key(self) -> tuple[str, int, int]:
        """Map, number of agents and seed, which name an instance in published results."""
        return self.name, len(self.starts), self.seed

    @cached_property
    def cells(self) -> dict[tuple[int, int], int]:
        """Number of each free cell."""
        free = (
            (row, column)
            for row, text in enumerate(self.rows)
            for column, letter in enumerate(text)
            if letter != "#"
        )
        return {cell: number for number, cell in enumerate(free)}

    @cached_property
    def moves(self) -> Ints:
        """(cells, 5) the cell to which each step leads, -1 if it is not free."""
        return np.array(
            [
                [self.cells.get((row + dr, column + dc), -1) for dr, dc in MOVES]
                for row, column in self.cells
            ],
            np.int64,
        )

    def numbers(self, places: Sequence[tuple[int, int]]) -> tuple[int, ...]:
        """Return the cells' numbers of places."""
        return tuple(self.cells[place] for place in places)


def least_makespan(instance: Instance) -> int | None:
    """Return the fewest steps after which all agents are at their targets; ``None`` if none do.

    Breadth-first search over all joint states, a layer at a time.
    """
    # Number the joint states like digits to the base of the number of cells.
    cells = len(instance.cells)
    agents = len(instance.starts)
    weights = cells ** np.arange(agents, dtype=np.int64)
    goal = int(np.dot(instance.numbers(instance.targets), weights))
    layer = np.array([instance.numbers(instance.starts)], np.int64)
    seen = np.zeros(cells**agents, bool)
    seen[layer @ weights] = True
    # Go layer by layer; large layers are expanded in chunks to bound the memory.
    steps = 0
    while len(layer):
        if seen[goal]:
            return steps
        found = []
        for first in range(0, len(layer), _CHUNK):
            following = _successors(instance.moves, layer[first : first + _CHUNK])
            codes, index = np.unique(following @ weights, return_index=True)
            new = ~seen[codes]
            seen[codes[new]] = True
            found.append(following[index[new]])
        layer = np.concatenate(found)
        steps += 1
    return None


def _successors(moves: Ints, states: Ints) -> Ints:
    """Return all joint states one step after some of ``states``, (n, agents).

    Agents are added one by one, so that a conflict between two rules out the moves of the others.
    """
    before = states
    after = np.zeros((len(states), 0), np.int64)
    for agent in range(states.shape[1]):
        # Each partial step once for each move of this agent.
        there = moves[before[:, agent]]
        before = np.repeat(before, len(MOVES), axis=0)
        after = np.repeat(after, len(MOVES), axis=0)
        chosen = there.reshape(-1)
        possible = chosen >= 0
        for other in range(agent):
            shares_cell = after[:, other] == chosen
            swaps = (after[:, other] == before[:, agent]) & (chosen == before[:, other])
            possible &= ~(shares_cell | swaps)
        before = before[possible]
        after = np.concatenate([after[possible], chosen[possible, None]], axis=1)
    return after


@dataclass(frozen=True)
class PibtRun:
    """How a run of PIBT ends.

    Args:
        outcome: ``arrived``, ``deadlock`` or ``livelock``.
        steps: Steps until all agents are at their targets, or until the recurrence was found.
        entry: Step at which the repeated part begins; -1 if they arrive.
        period: Steps until the positions come back; 0 if they arrive.
    """

    outcome: str
    steps: int
    entry: int = -1
    period: int = 0


def run_pibt(instance: Instance) -> PibtRun:
    """Run PIBT without random choices until it arrives or provably never does.

    A waiting time grows in each step and falls to 0 at the target, so the complete state of an
    agent that never arrives again never comes back. :func:`_repeats` has a rule that is sound
    nevertheless.
    """
    targets = instance.numbers(instance.targets)
    distances = [goal_distances(instance.moves, target) for target in targets]
    places = instance.numbers(instance.starts)
    waits: tuple[int, ...] = (0,) * len(places)
    history = [(places, waits)]
    visits: dict[tuple[int, ...], list[int]] = {places: [0]}
    while places != targets:
        places = pibt_step(instance.moves, distances, places, waits)
        waits = tuple(
            0 if place == target else wait + 1
            for place, target, wait in zip(places, targets, waits, strict=True)
        )
        history.append((places, waits))
        now = len(history) - 1
        # The same places and waits recur: from here the planner can only repeat itself.
        for entry in visits.setdefault(places, []):
            if places != targets and _repeats(history, entry):
                moved = len({state for state, _ in history[entry:]}) > 1
                return PibtRun("livelock" if moved else "deadlock", now, entry, now - entry)
        visits[places].append(now)
    return PibtRun("arrived", len(history) - 1)


def _repeats(history: list[tuple[tuple[int, ...], tuple[int, ...]]], entry: int) -> bool:
    """Return True if a run provably repeats itself from ``entry`` on.

    The positions are the same at ``entry`` and now. Decisions depend on positions and on the order
    of priorities alone. Let some waiting times have come back too, and let all others have grown
    throughout, each above every one of the former the whole time. Then the order is the same at
    each step of the next period: within either group by construction, and between them because
    the second has only grown. By induction the run repeats forever.
    """
    positions = len(history) - 1 - entry
    before = history[entry][1]
    after = history[-1][1]
    growing = [k for k, wait in enumerate(before) if after[k] == wait + positions]
    coming_back = [k for k, wait in enumerate(before) if after[k] == wait]
    if len(growing) + len(coming_back) < len(before):
        return False
    # Equal waiting times are ordered by the agents' numbers, so "above" has to be strict.
    return all(
        waits[one] > waits[other]
        for _, waits in history[entry:]
        for one in growing
        for other in coming_back
    )


def pibt_step(
    moves: Ints, distances: list[list[int]], places: tuple[int, ...], waits: tuple[int, ...]
) -> tuple[int, ...]:
    """Return the agents' next cells: those that have waited longest choose first."""
    # Nobody has chosen a cell yet.
    next_places = [-1] * len(places)
    occupant = {place: agent for agent, place in enumerate(places)}
    taken: set[int] = set()

    def choose(agent: int, pusher: int | None) -> bool:
        """Give an agent its best cell that is left, pushing whoever is in it."""
        options = [cell for cell in moves[places[agent]].tolist() if cell >= 0]
        for cell in sorted(options, key=distances[agent].__getitem__):
            if cell in taken or (pusher is not None and cell == places[pusher]):
                continue
            taken.add(cell)
            next_places[agent] = cell
            other = occupant.get(cell)
            if other is None or next_places[other] >= 0 or choose(other, agent):
                return True
            taken.discard(cell)

        # Nothing is left: it stays, and whoever pushed it looks for another cell.
        taken.add(places[agent])
        next_places[agent] = places[agent]
        return False

    # Agents choose in order of waiting time, and push others out of their cells.
    for agent in sorted(range(len(places)), key=lambda k: (-waits[k], k)):
        if next_places[agent] < 0:
            choose(agent, None)
    return tuple(next_places)


def goal_distances(moves: Ints, target: int) -> list[int]:
    """Return the steps from each cell to a target."""
    found = [len(moves)] * len(moves)
    found[target] = 0
    queue = deque([target])
    while queue:
        cell = queue.popleft()
        for other in moves[cell].tolist():
            if other >= 0 and found[other] > found[cell] + 1:
                found[other] = found[cell] + 1
                queue.append(other)
    return found


def read_instances(maps: Path, python: str) -> list[Instance]:
    """Let pogema place the agents of all instances."""
    script = Path(__file__).parent / "peers" / "pogema_instances.py"
    printed = subprocess.run(
        [python, str(script), str(maps)], check=True, capture_output=True, text=True
    ).stdout
    return [
        Instance(
            one["map"],
            one["seed"],
            tuple(one["rows"]),
            tuple((row, column) for row, column in one["starts"]),
            tuple((row, column) for row, column in one["targets"]),
        )
        for one in json.loads(printed)
    ]


def published_failures(folder: Path) -> dict[str, set[tuple[str, int, int]]]:
    """Return the instances that each method failed, from the published results."""
    failed = {}
    for file in sorted(folder.glob("*.json")):
        results = json.loads(file.read_text())
        failed[file.stem] = {
            (where["map_name"], where["num_agents"], where["seed"])
            for where, metrics in ((one["env_grid_search"], one["metrics"]) for one in results)
            if metrics["CSR"] < 1.0
        }
    return failed


def judge(instances: Sequence[Instance], folder: Path) -> dict[str, Any]:
    """Decide all instances and compare them with the published results."""
    makespans = {}
    runs = {}
    for number, instance in enumerate(instances, start=1):
        makespans[instance.key] = least_makespan(instance)
        runs[instance.key] = run_pibt(instance)
        if number % 40 == 0:
            click.echo(f"{number} of {len(instances)} instances", err=True)
    impossible = {key for key, steps in makespans.items() if steps is None}
    methods = {
        method: {
            "failed": len(failed),
            "impossible": len(failed & impossible),
            "own": len(failed - impossible),
            "credited_with_impossible": len(impossible - failed),
        }
        for method, failed in published_failures(folder).items()
    }
    outcomes = Counter(run.outcome for run in runs.values())
    return {
        "instances": len(instances),
        "impossible": len(impossible),
        "impossible_maps": sorted({name for name, _, _ in impossible}),
        "longest_optimum": max(steps for steps in makespans.values() if steps is not None),
        "pibt": dict(outcomes),
        "pibt_failed": sum(run.outcome != "arrived" for run in runs.values()),
        "pibt_impossible": sum(runs[key].outcome != "arrived" for key in impossible),
        "pibt_longest_period": max(run.period for run in runs.values()),
        "methods": methods,
    }


def table(found: dict[str, Any]) -> str:
    """Return the results as a Markdown table: what each method failed, and whose fault it was."""
    lines = ["| method | failed | of them impossible | its own |", "| --- | ---: | ---: | ---: |"]
    ranked = sorted(found["methods"].items(), key=lambda entry: (entry[1]["own"], entry[0]))
    lines += [
        f"| {method} | {row['failed']} | {row['impossible']} | {row['own']} |"
        for method, row in ranked
    ]
    stuck = found["pibt_impossible"]
    lines.append(
        f"| deterministic PIBT | {found['pibt_failed']} | {stuck} | {found['pibt_failed'] - stuck} |"
    )
    outcomes = ", ".join(f"{count} {name}" for name, count in sorted(found["pibt"].items()))
    lines += [
        "",
        f"{found['instances']} instances, {found['impossible']} impossible "
        f"({', '.join(found['impossible_maps'])}); the longest optimum has "
        f"{found['longest_optimum']} steps. Deterministic PIBT: {outcomes}; all proved, the longest "
        f"period has {found['pibt_longest_period']} steps.",
    ]
    return "\n".join(lines)


@click.command(help=__doc__)
@click.option("--snapshot", type=click.Path(exists=True, path_type=Path), required=True)
@click.option("--python", default=sys.executable, help="Interpreter that can import pogema.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def main(snapshot: Path, python: str, as_json: bool) -> None:
    """Decide the instances and print the results."""
    found = judge(read_instances(snapshot / "maps.yaml", python), snapshot)
    click.echo(json.dumps(found) if as_json else table(found))


if __name__ == "__main__":
    main()
