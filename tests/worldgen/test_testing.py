"""The checks for users' own families find the faults that they claim to find."""

import itertools
import json
import os
import random
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from worldgen import testing
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, Family, check_between, family
from worldgen.testing import CHECKS, FAMILY_CHECKS, BrokenContract, check_family, layout_digest
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target, World

DEPOT = "./examples/own-family/depot_worlds.py:depot"
BY_NAME = {check.name: check for check in (*FAMILY_CHECKS, *CHECKS)}
COUNTER = itertools.count()


def room(rng, timeline=None):
    """A room with a randomly placed pillar."""
    walls = np.zeros((12, 12), bool)
    walls[6, 1 + rng.below(10)] = True
    return World(walls, Pose(0.2, 0.2), Target(1.0, 1.0, 0.05), timeline=timeline or Timeline())


def own(build, *, name="own", changes=False):
    return family(name, version=1, changes=changes)(build)


def counting(rng, *, size: int = 12) -> World:
    return World(
        np.zeros((12, 12), bool), Pose(0.2 + next(COUNTER) / 100, 0.2), Target(1.0, 1.0, 0.05)
    )


def fixed(rng, *, size: int = 12) -> World:
    return World(np.zeros((12, 12), bool), Pose(0.2, 0.2), Target(1.0, 1.0, 0.05))


def pythons_chance(rng, *, size: int = 12) -> World:
    random.random()
    return room(rng)


def numpys_chance(rng, *, size: int = 12) -> World:
    np.random.random()
    return room(rng)


def burning(rng, *, size: int = 12) -> World:
    return room(rng, Timeline.of([(1.0, 3, 3, CellState.BURNING)]))


def saying_again(rng, *, size: int = 12) -> World:
    return room(rng, Timeline.of([(1.0, 3, 3, CellState.FREE)]))


def unchecked(rng, *, size: int = 12) -> World:
    return World(np.zeros((size, size), bool), Pose(0.2, 0.2), Target(1.0, 1.0, 0.05))


def endless(rng, *, size: int = 12) -> World:
    """Runs forever on request."""
    while size == -2:
        pass
    check_between("size", size, 12, 12)
    return room(rng)


# In a module, because another process loads them.
loops_on_request = family("loops-on-request", version=1)(endless)


@family("exits-on-request", version=1)
def exits_on_request(rng, *, size: int = 12) -> World:
    if size == -2:
        os._exit(0)
    check_between("size", size, 12, 12)
    return room(rng)


def wordy(rng, *, size: int = 12) -> World:
    if size != 12:
        raise InvalidParameter("odd", "one line\nand another")
    return room(rng)


BROKEN = {
    "counting": (counting, "equal-seed-gives-equal-bytes", "seed 0 gives two different worlds"),
    "fixed": (fixed, "different-seeds-give-different-worlds", "seeds 0 to 5 give 1 worlds"),
    "pythons": (
        pythons_chance,
        "what-was-made-before-does-not-matter",
        "draws from Python's or NumPy's random",
    ),
    "numpys": (
        numpys_chance,
        "what-was-made-before-does-not-matter",
        "draws from Python's or NumPy's random",
    ),
    "still": (
        burning,
        "a-timeline-never-says-what-already-is",
        r"declare @family\(..., changes=True\)",
    ),
    "unexplained": (unchecked, "every-parameter-is-explained", "it has no docstring"),
    "silent": (endless, "every-parameter-is-explained", "size: not explained"),
    "unchecked": (
        unchecked,
        "an-absurd-value-is-refused-or-works",
        "size='-9223372036854775808' raises ValueError",
    ),
    "endless": (
        loops_on_request,
        "an-absurd-value-is-refused-or-works",
        "size='-2' takes more than 0.2 s",
    ),
    "ending": (exits_on_request, "an-absurd-value-is-refused-or-works", "size='-2' ends Python"),
    "wordy": (wordy, "an-absurd-value-is-refused-or-works", "is refused in more than one line"),
}


@pytest.mark.gate
@pytest.mark.parametrize(("build", "check", "message"), BROKEN.values(), ids=BROKEN)
def test_a_broken_promise_is_found(build, check, message, monkeypatch):
    monkeypatch.setattr(testing, "PATIENCE", 0.2)
    with pytest.raises(BrokenContract, match=message):
        BY_NAME[check](build if isinstance(build, Family) else own(build))


@pytest.mark.parametrize(
    ("build", "message"),
    [(burning, "a cell burns forever"), (saying_again, "changes to the state that it")],
)
def test_a_broken_timeline_is_found(build, message):
    with pytest.raises(BrokenContract, match=message):
        BY_NAME["a-timeline-never-says-what-already-is"](own(build, changes=True))


def test_a_witness_that_does_not_hold_is_found(monkeypatch):
    monkeypatch.setattr(
        testing, "check_certificate", lambda world: type("No", (), {"valid": False, "reason": "no"})
    )
    with pytest.raises(
        BrokenContract, match="seed 0: the independent checker refuses the witness: no"
    ):
        BY_NAME["the-independent-checker-accepts-the-witness"](FAMILIES.get("trap"))


def test_all_that_is_broken_is_told_at_once_with_its_case():
    def plain(rng, *, shape: Literal["a", "b"] = "a", size: int = 12) -> World:
        return fixed(rng)

    with pytest.raises(BrokenContract) as caught:
        check_family(own(plain))
    told = str(caught.value)
    assert (
        "own breaks its contract:" in told
        and "every-parameter-is-explained: it has no docstring" in told
    )
    assert "different-seeds-give-different-worlds (shape='b'): seeds 0 to 5 give 1 worlds" in told


def test_a_pinned_digest_that_changed_is_told():
    depot = FAMILIES.get(DEPOT)
    with pytest.raises(BrokenContract, match="but 0000 is pinned; raise the version") as caught:
        check_family(
            depot,
            golden={"aisles": "0000", "fishbone": layout_digest(depot, {"layout": "fishbone"})},
        )
    assert len(str(caught.value).splitlines()) == 2


def test_the_example_of_an_own_family_keeps_its_promises():
    done = worldgen("check-family", DEPOT)
    assert done.code == 0 and "depot version 1: 21 of 21 checks hold" in done.out


HALL = """
import numpy as np

from worldgen.compose import of_cells
from worldgen.family import family


@family("hall", version=1)
def hall(rng):
    \"\"\"Build the same hall for every seed.\"\"\"
    hall = of_cells(np.zeros((3, 11), bool)).border()
    return hall.with_start(2.5, 2.5).with_target(10.5, 2.5).layout()
"""


@pytest.mark.gate
def test_the_command_says_what_is_broken_and_ends_with_1(tmp_path):
    (tmp_path / "hall.py").write_text(HALL)
    hall = f"{tmp_path / 'hall.py'}:hall"
    done = worldgen("check-family", hall)
    assert (
        done.code == 1
        and "BROKEN different-seeds-give-different-worlds: seeds 0 to 5 give 1 worlds" in done.out
    )
    left_out = ("--except", "different-seeds-give-different-worlds", "--json", "--digests")
    found = json.loads(worldgen("check-family", hall, *left_out).out)
    assert not any(check["fault"] for check in found["checks"]) and list(found["digests"]) == [""]


def test_an_unknown_check_is_refused_by_name():
    done = worldgen("check-family", "trap", "--except", "everything")
    assert done.code == 2 and done.error_code == "unknown-name"


def test_the_golden_digests_of_the_example_are_those_of_its_test():
    text = Path("examples/own-family/tests/test_depot.py").read_text()
    depot = FAMILIES.get(DEPOT)
    for layout in ("aisles", "fishbone"):
        assert f'"{layout}": "{layout_digest(depot, {"layout": layout})}"' in text


def test_the_example_takes_no_name_that_a_family_of_worldgen_has():
    assert FAMILIES.get(DEPOT).name not in FAMILIES.names()
