"""The contract of a Python controller, and the message for a controller that breaks it.

A controller that returns the wrong thing has not crashed; it is incomplete. If it does so in its
first step, no run can show anything, so this is a usage error. If only some branch forgets the
memory, the search has found that branch: the verdict is ``invalid-command``, and the world that
leads into the branch is the failure.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from sim.clock.controller_time import UNKNOWN_SOURCE
from sim.controllers.controller_error import ControllerError, rule_of
from sim.evidence import Evidence, FaultEvidence
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, Message
from worldgen.support.plain_text import shown

# Characters of an answer that are quoted.
_LONGEST_ANSWER = 200
_RETURN = "end {} with: return Command(speed, turn_rate), memory"
_MEMORY = "return a tuple of numbers whose length never changes, such as () or (0.0, 1.0)"


class ContractBroken(ControllerError, TypeError):
    """Raised if a controller returned something that the contract does not allow.

    Args:
        rule: Name of the broken rule, in lower case with dashes; a bucket is named after it.
        error: The fault, in the same words in every replay.
        answer: The returned value.
        remedy: How to fix it.
    """

    def __init__(self, rule: str, error: str, answer: object, remedy: str) -> None:
        super().__init__(
            Verdict.INVALID_COMMAND,
            error,
            {"rule": rule, "answer": _in_short(answer), "remedy": remedy},
        )


def no_memory(answer: object, method: str = "act") -> ContractBroken:
    """Return the error for an answer that is not a command and a memory."""
    fields = getattr(answer, "_fields", ())
    if answer is None:
        what = "returned nothing"
    elif "turn_rate" in fields or isinstance(answer, int | float | np.number):
        what = "returned a command without a memory"
    else:
        what = "did not return a command and a memory"
    return _broken(method, what, answer)


def no_command(answer: object, method: str = "act") -> ContractBroken:
    """Return the error for an answer whose first part is not a command."""
    return _broken(method, "did not return a command", answer)


def _broken(method: str, what: str, answer: object) -> ContractBroken:
    error = f"{method} {what}"
    return ContractBroken(rule_of(error), error, answer, _RETURN.format(method))


def state_survives_reset(controller: str, places: Iterable[str]) -> Message:
    """Return the message about state that a controller keeps from one run to the next.

    Args:
        controller: The controller's name.
        places: Where it keeps it, such as ``self.hits``.
    """
    return Message(
        "state-survives-reset",
        "state of {controller} survives reset(): {places!l}",
        "make it in reset(), or keep it in the memory; otherwise loops cannot be proved, and "
        "failures that do not repeat are dropped",
        controller=controller,
        places=sorted(places),
    )


def runs_differ(controller: str, sources: Iterable[str]) -> Message:
    """Return the message about a controller that depends on more than a run begins with.

    Args:
        controller: The controller's name.
        sources: What makes them differ, such as ``time.time() (mine.py:12)``.
    """
    remedy = (
        "add +frozen_time to its name: it then sees simulated time, and chance that begins with "
        "the run's seed; if it is there already, count steps in the memory instead"
    )
    if set(sources) == {UNKNOWN_SOURCE}:
        remedy = "let nothing but its observation and its memory decide what it does"
    return Message(
        "runs-differ",
        "{controller} uses {sources!l}, so equal runs of it may differ: its loops cannot be proved, "
        "and failures that do not repeat are dropped",
        remedy,
        controller=controller,
        sources=sorted(sources),
    )


def flat_memory(memory: Any, size: int | None = None) -> tuple[float, ...]:
    """Return a controller's memory as floats.

    Args:
        memory: What ``reset`` or ``act`` returned.
        size: Required length; any length if omitted.

    Raises:
        ContractBroken: If it is not a tuple of numbers, or has another length.
    """
    if not isinstance(memory, tuple) or not all(
        isinstance(value, int | float | np.number) for value in memory
    ):
        raise ContractBroken(
            "the-memory-is-not-a-tuple-of-numbers",
            "the memory is not a tuple of numbers",
            memory,
            _MEMORY,
        )
    if size is not None and len(memory) != size:
        raise ContractBroken(
            "the-memory-had-numbers-and-now-has",
            f"the memory had {size} numbers and now has {len(memory)}",
            memory,
            "keep the length that reset() returned",
        )
    return tuple(float(value) for value in memory)


def check_contract(name: str, evidence: Evidence | None, steps: int) -> None:
    """Refuse a controller that breaks the contract in its first step.

    Args:
        name: The controller's name, for the message.
        evidence: Evidence of the run, or the known facts about the controller's fault.
        steps: Steps of the run.

    Raises:
        InvalidParameter: If it does.
    """
    if isinstance(evidence, FaultEvidence) and evidence.remedy is not None and steps <= 1:
        raise InvalidParameter(
            "contract-broken",
            "controller {name!r}: {fault}: {answer}",
            "{remedy}",
            name=name,
            fault=evidence.error,
            answer=evidence.answer,
            remedy=evidence.remedy,
        )


def _in_short(answer: object) -> str:
    try:
        text = shown(repr(answer))
    except Exception:  # noqa: BLE001 - the user's own repr may raise anything
        text = f"a {type(answer).__name__}"
    return text if len(text) <= _LONGEST_ANSWER else f"{text[:_LONGEST_ANSWER]}..."
