"""The benchmark of POGEMA's Puzzles decides instances correctly."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from benchmarks.pogema import Instance, goal_distances, least_makespan, pibt_step, run_pibt


def swap(*rows: str) -> Instance:
    """Two agents at the ends of the first row that want to change places."""
    last = len(rows[0]) - 1
    return Instance("swap", 0, rows, ((0, 0), (0, last)), ((0, last), (0, 0)))


def random_instances(count: int) -> list[Instance]:
    """Small grids with two or three agents at random places."""
    rng = np.random.default_rng(1)
    found: list[Instance] = []
    while len(found) < count:
        solid = rng.random((3, 4)) < 0.3
        free = [(int(row), int(column)) for row, column in np.argwhere(~solid)]
        agents = int(rng.integers(2, 4))
        if len(free) < agents + 1:
            continue
        rows = tuple("".join("#" if cell else "." for cell in row) for row in solid)
        starts = [free[k] for k in rng.permutation(len(free))[:agents]]
        targets = [free[k] for k in rng.permutation(len(free))[:agents]]
        found.append(Instance("random", 0, rows, tuple(starts), tuple(targets)))
    return found


def makespan_by_brute_force(instance: Instance) -> int | None:
    """Compute the same answer with sets of joint states and plain loops."""
    steps = ((0, 0), (0, 1), (0, -1), (1, 0), (-1, 0))
    layer = {instance.starts}
    seen = set(layer)
    for makespan in itertools.count():
        if instance.targets in layer:
            return makespan
        if not layer:
            return None
        following = set()
        for state in layer:
            for chosen in itertools.product(steps, repeat=len(state)):
                after = tuple(
                    (row + dr, column + dc)
                    for (row, column), (dr, dc) in zip(state, chosen, strict=True)
                )
                pairs = itertools.combinations(range(len(state)), 2)
                if (
                    all(place in instance.cells for place in after)
                    and len(set(after)) == len(after)
                    and not any(after[i] == state[j] and after[j] == state[i] for i, j in pairs)
                ):
                    following.add(after)
        layer = following - seen
        seen |= layer
    raise AssertionError("unreachable")


def test_agents_cannot_change_places_in_a_corridor_without_a_bay() -> None:
    assert least_makespan(swap("....")) is None


def test_agents_change_places_in_a_corridor_with_a_bay() -> None:
    assert least_makespan(swap("....", "#.##")) == 5


def test_the_joint_search_agrees_with_brute_force() -> None:
    for instance in random_instances(25):
        assert least_makespan(instance) == makespan_by_brute_force(instance)


def test_pibt_in_a_corridor_ends_in_a_proved_recurrence() -> None:
    assert run_pibt(swap("....")).outcome in ("deadlock", "livelock")


@pytest.mark.parametrize("part", range(4))
def test_a_proved_recurrence_of_pibt_never_arrives(part: int) -> None:
    for instance in random_instances(80)[part::4]:
        run = run_pibt(instance)
        if run.outcome == "arrived":
            assert least_makespan(instance) is not None
            continue

        # Continue for twenty periods, without any rule that recognises a recurrence.
        targets = instance.numbers(instance.targets)
        distances = [goal_distances(instance.moves, target) for target in targets]
        places = instance.numbers(instance.starts)
        waits: tuple[int, ...] = (0,) * len(places)
        visited = [places]
        for _ in range(run.entry + 20 * run.period):
            places = pibt_step(instance.moves, distances, places, waits)
            waits = tuple(
                0 if place == target else wait + 1
                for place, target, wait in zip(places, targets, waits, strict=True)
            )
            visited.append(places)
        assert targets not in visited
        assert visited[run.entry :: run.period] == [visited[run.entry]] * 21
