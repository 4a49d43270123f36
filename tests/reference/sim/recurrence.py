"""Finds the step in which a run's complete state recurs, whatever the motion model.

During a run, each state leaves a 64-bit fingerprint in a log. A state that equals an earlier
one is followed by the same states, so once any state has recurred, every later one has occurred
before. It is therefore enough to look up the last state of the budget: if it is new, no state of
the run has recurred. To stop early, some earlier states are looked up too, each twice as far along
as the previous one.

Equal fingerprints are only a claim. A second run proves it, up to the end of the first
period, that compares the complete states at both ends (``PROVE_LOOP``).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]
Words = npt.NDArray[np.uint64]

# Words of a state that share a fingerprint, which is computed again only when one of them
# changes.
BLOCK = 8
NEXT, TOUCHED = (
    0,
    1,
)  # marks: the step whose state is looked up next; whether the last step touched a wall
MARKS = 2

_FEW = 32  # words of a state that has no blocks
_FIRST = 16  # steps before the first lookup
_HALF = np.uint64(32)
_SHIFT = np.uint64(29)
_STRIDE = np.uint64(0x9E3779B97F4A7C15)  # tells blocks apart
_MIXER = np.uint64(0xBF58476D1CE4E5B9)
# Random odd numbers, one for each word of a block.
_FACTORS = np.array(
    [
        0xD6E8FEB86659FD93, 0xA0761D6478BD642F, 0xE7037ED1A0B428DB, 0x8EBC6AF09C88C6E3,
        0x589965CC75374CC3, 0x1D8E4E27C47D124F, 0xEB44ACCAB455D165, 0xC2B2AE3D27D4EB4F,
    ],
    np.uint64,
)  # fmt: skip


def _factors(count: int) -> list[int]:
    """SplitMix64's numbers from seed 0, made odd."""
    state, drawn = 0, []
    for _ in range(count):
        state = (state + 0x9E3779B97F4A7C15) % 2**64
        z = state
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % 2**64
        drawn.append((z ^ (z >> 31)) | 1)
    return drawn


FACTORS_OF_FEW = _factors(_FEW)
"""One for each word of a state that has no blocks."""


class Search(NamedTuple):
    """The data of the search for a recurrence.

    Args:
        known: (words,) int64, the last state whose fingerprint was computed; while a loop is
            proved, the state at its entry.
        prints: (blocks + 1,) uint64, the fingerprint of each block of ``known``, then their sum.
        log: (steps + 1,) uint64, the fingerprint of the state after each step; one entry if there
            is no search.
        marks: (MARKS,) int64, ``NEXT`` and ``TOUCHED``.
    """

    known: Ints
    prints: Words
    log: Words
    marks: Ints


def new_search(words: int, steps: int) -> Search:
    """Arrays for states of this many words and a run of this many steps.

    The log takes memory only as the run advances.
    """
    blocks = -(-words // BLOCK)
    return Search(
        np.zeros(words, np.int64),
        np.zeros(blocks + 1, np.uint64),
        np.zeros(steps + 1, np.uint64),
        np.zeros(MARKS, np.int64),
    )


def _fingerprint_of_block(state: Ints, block: int) -> Any:
    """A word's upper half is folded into its lower one.

    In floats that are small integers, only the upper half varies.
    """
    first = block * BLOCK
    mixed = np.uint64(block + 1) * _STRIDE
    for k in range(first, min(first + BLOCK, state.size)):
        word = np.uint64(state[k])
        mixed += (word ^ (word >> _HALF)) * _FACTORS[k - first]
    mixed = (mixed ^ (mixed >> _SHIFT)) * _MIXER
    return mixed ^ (mixed >> _HALF)


def _fingerprint_of_few(state: Ints) -> Any:
    """The same for a state of few words."""
    mixed = 0
    for factor, word in zip(FACTORS_OF_FEW, state.view(np.uint64).tolist(), strict=False):
        mixed += (word ^ (word >> 32)) * factor
    return np.uint64(mixed % 2**64)


def _fingerprint(search: Search, state: Ints) -> Any:
    """The sum of the blocks' fingerprints.

    Blocks that have not changed since the last call keep theirs.
    """
    if state.size <= _FEW:
        return _fingerprint_of_few(state)
    known, prints = search.known, search.prints
    last = prints.size - 1
    total = prints[last]
    for block in range(last):
        first = block * BLOCK
        after = min(first + BLOCK, state.size)
        changed = 0
        for k in range(first, after):
            changed |= state[k] ^ known[k]
        if changed != 0:
            mixed = _fingerprint_of_block(state, block)
            total += mixed - prints[block]
            prints[block] = mixed
            for k in range(first, after):
                known[k] = state[k]
    prints[last] = total
    return total


def begin_search(search: Search, state: Ints, quiet: int) -> None:
    """Begins with the state of step 0.

    Args:
        search: The search.
        state: The state.
        quiet: Step of the last event: earlier states prove nothing and are not logged.
    """
    total = np.uint64(0)
    for block in range(search.prints.size - 1):
        search.prints[block] = _fingerprint_of_block(state, block)
        total += search.prints[block]
    search.prints[search.prints.size - 1] = total
    keep(search, state)
    search.log[0] = total if state.size > _FEW else _fingerprint_of_few(state)
    search.marks[NEXT] = quiet + _FIRST


def keep(search: Search, state: Ints) -> None:
    """Copies a state."""
    for k in range(state.size):
        search.known[k] = state[k]


def _look_up(log: Words, quiet: int, step: int) -> int:
    """The last step before ``step``, and not before ``quiet``, with its fingerprint.

    -1 if there is none.
    """
    wanted, earlier = log[step], step - 1
    while earlier >= quiet and log[earlier] != wanted:
        earlier -= 1
    return earlier if earlier >= quiet else -1


def period_at(search: Search, state: Ints, step: int, quiet: int, budget: int) -> int:
    """Logs a state, and looks it up if its turn has come.

    Args:
        search: The search after the previous steps.
        state: The state after ``step``.
        step: Not before ``quiet``.
        quiet: Step of the last event, 0 if there is none.
        budget: The last step.

    Returns:
        The fewest steps since the state last occurred; 0 if it is new, or was not looked up.
    """
    search.log[step] = _fingerprint(search, state)
    if step < search.marks[NEXT] and step < budget:
        return 0
    search.marks[NEXT] = 2 * step - quiet + _FIRST
    earlier = _look_up(search.log, quiet, step)
    return step - earlier if earlier >= 0 else 0


def entry_of_loop(log: Words, quiet: int, step: int, period: int) -> int:
    """The first step, not before ``quiet``, from which the log repeats itself up to ``step``."""
    entry = step - period
    while entry > quiet and log[entry - 1] == log[entry - 1 + period]:
        entry -= 1
    return entry


def is_proved(search: Search, state: Ints, step: int, entry: int, end: int) -> bool:
    """Keeps the state of step ``entry``.

    At step ``end``, returns whether it recurs, word by word.
    """
    if step == entry:
        keep(search, state)
    if step != end:
        return False
    k = 0
    while k < state.size and state[k] == search.known[k]:
        k += 1
    return k == state.size
