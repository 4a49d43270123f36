"""Check claims about every possible draw, state by state, independently of the exploration."""

from __future__ import annotations

from collections.abc import Iterable

from sim.episode.chance import ARRIVED, ENDED, UNSEEN, Outcomes, states_of
from sim.trace import Trace
from sim.verdict import UNENDED, Verdict


def check_chance(outcomes: Outcomes, chance: str, runs: Iterable[tuple[Trace, str]]) -> str:
    """Check that the states are closed, that they imply the claim, and that runs stay in them.

    ``trap``: the target follows no state, so no draw leads there. ``sure``: no state is followed
    by another ending, and each is followed by the target or by a state of lower rank; so from any
    state the robot arrives with a probability that is bounded from below, again and again.
    ``part``: ranks descend from the start to the target, and there is a state from which all paths
    stay among states without a rank.

    Args:
        outcomes: The states and their successors.
        chance: The claim.
        runs: Ordinary recorded runs with their verdicts. The controller and the options are the
            same, except for seed and steps.
    """
    wrong = _check_closure(outcomes)
    if wrong:
        return wrong
    wrong = {"trap": _check_trap, "sure": _check_sure, "part": _check_part}[chance](outcomes)
    return wrong or next(filter(None, (_check_run(outcomes, *run) for run in runs)), "")


def _check_closure(outcomes: Outcomes) -> str:
    """Check that all successors are known, and that each state but the first has a predecessor."""
    # States reached so far; the first is where every run starts.
    known = {0}
    for number, entry in enumerate(outcomes.following):
        values = sorted(value for value, _ in entry)
        if values not in ([UNSEEN], list(range(outcomes.coin))):
            return f"state {number} has successors for the draws {values}, of {outcomes.coin}"
        if not all(
            after in (ARRIVED, ENDED) or 0 <= after < len(outcomes.states) for _, after in entry
        ):
            return f"a successor of state {number} was not explored"
        if number not in known:
            return f"no earlier state leads to state {number}"
        known.update(after for _, after in entry)
    return (
        ""
        if len(outcomes.following) == len(outcomes.states)
        else "some states have no list of successors"
    )


def _check_trap(outcomes: Outcomes) -> str:
    for number, entry in enumerate(outcomes.following):
        if any(after == ARRIVED for _, after in entry):
            return f"state {number} leads to the target"
    return ""


def _check_sure(outcomes: Outcomes) -> str:
    for number, entry in enumerate(outcomes.following):
        if any(after == ENDED for _, after in entry):
            return f"state {number} may end elsewhere"
        if not _descends(outcomes, number):
            return f"state {number} has no successor of lower rank"
    return ""


def _check_part(outcomes: Outcomes) -> str:
    # Descend the ranks from the start to the target.
    number = 0
    while outcomes.ranks[number] > 1:
        lower = [
            after for _, after in outcomes.following[number] if _is_lower(outcomes, after, number)
        ]
        if not lower:
            return f"state {number} has no successor of lower rank"
        number = lower[0]
    if not _descends(outcomes, number):
        return f"state {number} does not lead to the target"
    # States without a rank are lost: they must not lead anywhere else.
    lost = {number for number, rank in enumerate(outcomes.ranks) if not rank}
    for number in lost:
        if any(
            after == ARRIVED or (after >= 0 and after not in lost)
            for _, after in outcomes.following[number]
        ):
            return (
                f"state {number} is claimed to be lost, but some draw leads out of the lost states"
            )
    ends = any(after == ENDED for entry in outcomes.following for _, after in entry)
    return "" if lost or ends else "no state is lost"


def _descends(outcomes: Outcomes, number: int) -> bool:
    return any(_is_lower(outcomes, after, number) for _, after in outcomes.following[number])


def _is_lower(outcomes: Outcomes, after: int, number: int) -> bool:
    """Return True if a successor has a lower rank, so that it is nearer to the target."""
    if after == ARRIVED:
        return outcomes.ranks[number] > 0
    return after >= 0 and 0 < outcomes.ranks[after] < outcomes.ranks[number]


def _check_run(outcomes: Outcomes, trace: Trace, verdict: str) -> str:
    """Check that a run starts in the first state, moves to successors, and ends where it may."""
    known: dict[bytes, set[int]] = {}
    for number, state in enumerate(outcomes.states):
        known.setdefault(state.tobytes(), set()).add(number)
    states = states_of(trace)
    # Several states may have the same bytes, so keep every state that the run may be in.
    may_be = {0} if states[0].tobytes() == outcomes.states[0].tobytes() else set()
    ends = verdict not in UNENDED
    for step in range(1, trace.steps + 1 - ends):
        after = {after for number in may_be for _, after in outcomes.following[number]}
        may_be = after & known.get(states[step].tobytes(), set())
        if not may_be:
            return f"after step {step} a run is in a state that does not follow the previous one"
    end = ARRIVED if verdict == Verdict.REACHED else ENDED
    if ends and not any(
        after == end for number in may_be for _, after in outcomes.following[number]
    ):
        return f"a run ends as {verdict} in step {trace.steps}, which no state allows"
    return ""
