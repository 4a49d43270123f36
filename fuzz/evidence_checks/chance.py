"""``chance``: what is said of every draw, checked state by state in plain Python, apart from what explored them."""

from __future__ import annotations

from collections.abc import Iterable

from sim.chance import ARRIVED, ENDED, UNSEEN, Outcomes, states_of
from sim.trace import Trace
from sim.verdict import UNENDED, Verdict

__all__ = ["check_chance"]


def check_chance(outcomes: Outcomes, chance: str, runs: Iterable[tuple[Trace, str]]) -> str:
    """Check that the states are closed, the claim follows from them, and runs keep to them.

    ``trap``: no state is followed by the target, so no draw leads there. ``sure``: none is followed
        by another end, and
    each by the target or by a state of lower rank, so that from wherever the robot is it arrives
    with some probability that is bounded from below, again and again. ``part``: the start has a way
        down the ranks, and there is a state
    from which every way stays among states without one.

    Args:
        outcomes: States and what follows them.
        chance: The claim.
        runs: Ordinary runs, recorded, with the same controller and options but for seed and steps;
            and their verdicts.
    """
    wrong = _check_closure(outcomes)
    if wrong:
        return wrong
    wrong = {"trap": _check_trap, "sure": _check_sure, "part": _check_part}[chance](outcomes)
    return wrong or next(filter(None, (_check_run(outcomes, *run) for run in runs)), "")


def _check_closure(outcomes: Outcomes) -> str:
    """Check that nothing follows a state but states, and earlier ones lead to each but the first."""
    known = {0}
    for number, entry in enumerate(outcomes.following):
        values = sorted(value for value, _ in entry)
        if values not in ([UNSEEN], list(range(outcomes.coin))):
            return f"state {number} says what follows the values {values}, of {outcomes.coin}"
        if not all(
            after in (ARRIVED, ENDED) or 0 <= after < len(outcomes.states) for _, after in entry
        ):
            return f"state {number} is followed by one that was not looked at"
        if number not in known:
            return f"no state before it leads to state {number}"
        known.update(after for _, after in entry)
    return (
        ""
        if len(outcomes.following) == len(outcomes.states)
        else "not all states say what follows them"
    )


def _check_trap(outcomes: Outcomes) -> str:
    for number, entry in enumerate(outcomes.following):
        if any(after == ARRIVED for _, after in entry):
            return f"the target follows state {number}"
    return ""


def _check_sure(outcomes: Outcomes) -> str:
    for number, entry in enumerate(outcomes.following):
        if any(after == ENDED for _, after in entry):
            return f"state {number} may end elsewhere"
        if not _descends(outcomes, number):
            return f"no way leads from state {number} to one of lower rank"
    return ""


def _check_part(outcomes: Outcomes) -> str:
    number = 0
    while outcomes.ranks[number] > 1:
        lower = [
            after for _, after in outcomes.following[number] if _is_lower(outcomes, after, number)
        ]
        if not lower:
            return f"no way leads from state {number} to one of lower rank"
        number = lower[0]
    if not _descends(outcomes, number):
        return f"the target does not follow state {number}"
    lost = {number for number, rank in enumerate(outcomes.ranks) if not rank}
    for number in lost:
        if any(
            after == ARRIVED or (after >= 0 and after not in lost)
            for _, after in outcomes.following[number]
        ):
            return f"a way leads out of state {number}, where all is said to be lost"
    ends = any(after == ENDED for entry in outcomes.following for _, after in entry)
    return "" if lost or ends else "no state is lost"


def _descends(outcomes: Outcomes, number: int) -> bool:
    return any(_is_lower(outcomes, after, number) for _, after in outcomes.following[number])


def _is_lower(outcomes: Outcomes, after: int, number: int) -> bool:
    """Whether what follows a state is nearer to the target by rank."""
    if after == ARRIVED:
        return outcomes.ranks[number] > 0
    return after >= 0 and 0 < outcomes.ranks[after] < outcomes.ranks[number]


def _check_run(outcomes: Outcomes, trace: Trace, verdict: str) -> str:
    """Check that a run begins at the start, goes from states to such as follow them, and ends as one may end."""
    known: dict[bytes, set[int]] = {}
    for number, state in enumerate(outcomes.states):
        known.setdefault(state.tobytes(), set()).add(number)
    states = states_of(trace)
    may_be = {0} if states[0].tobytes() == outcomes.states[0].tobytes() else set()
    ends = verdict not in UNENDED
    for step in range(1, trace.steps + 1 - ends):
        after = {after for number in may_be for _, after in outcomes.following[number]}
        may_be = after & known.get(states[step].tobytes(), set())
        if not may_be:
            return f"a run is, after step {step}, in a state that does not follow"
    end = ARRIVED if verdict == Verdict.REACHED else ENDED
    if ends and not any(
        after == end for number in may_be for _, after in outcomes.following[number]
    ):
        return f"a run ends as {verdict} in step {trace.steps}, where no state says so"
    return ""
