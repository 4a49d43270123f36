"""The promises of every family, as checks that you can run on your own.

In a test: ``check_family(my_family)``, or one check at a time, ``pytest.mark.parametrize("check",
CHECKS, ids=str)``. On the command line: ``worldgen check-family NAME``.

A check is called with the family and a case, which is some of its parameters; it raises
``BrokenContract``.
"""

from __future__ import annotations

import contextlib
import math
import random
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace

import numpy as np

from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES, MARGIN, Family, Parameter
from worldgen.files.grid import dumps, loads, world_digest
from worldgen.generation import generate
from worldgen.plugins.workers import WorkerPool
from worldgen.reach import check_certificate, witness_margin
from worldgen.support.plain_text import quote
from worldgen.timeline import CellState
from worldgen.world import JointWitness, Value, Witness, World

__all__ = [
    "CHECKS",
    "FAMILY_CHECKS",
    "BrokenContract",
    "Check",
    "CheckOutcome",
    "check_family",
    "family_cases",
    "layout_digest",
    "run_checks",
    "shown",
]

# Limit in seconds for one absurd value, which must be refused immediately.
PATIENCE = 20
_SEEDS = 5
# Seeds that must not all give the same world.
_WIDE = 6
_ABSURD: dict[type, tuple[Value, ...]] = {
    int: (-(2**63), -2, 0, 1, 2**62),
    float: (-1e308, -1.0, 0.0, 1e-308, 1e308),
    str: ("", "no such word", "\x00", "\N{SNOWMAN}" * 100),
}
_WRONG: tuple[Value, ...] = (1, 1.5, True, "1", [], {})
_NOT_FINITE = (math.nan, math.inf, -math.inf)


class BrokenContract(AssertionError):
    """Raised if a family breaks a promise; the message names the seed and parameters."""


@dataclass(frozen=True)
class Check:
    """A promise of families.

    Args:
        name: The promise, as a sentence with dashes for spaces.
        run: Raises :class:`BrokenContract` if the promise is broken.
    """

    name: str
    run: Callable[[Family, Mapping[str, Value]], None]

    def __call__(self, family: Family, case: Mapping[str, Value] | None = None) -> None:
        """Run it for one case, the defaults if omitted."""
        self.run(family, case or {})

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class CheckOutcome:
    """The result of one check for one case.

    Args:
        check: The promise.
        case: The parameters.
        fault: The violation; empty if the promise is kept.
    """

    check: str
    case: Mapping[str, Value]
    fault: str = ""


def family_cases(family: Family) -> list[dict[str, Value]]:
    """Return the cases worth checking: each choice of the first parameter that has choices.

    If there is none, the defaults are the only case.
    """
    for parameter in family.parameters:
        if parameter.choices:
            return [{parameter.name: word} for word in parameter.choices]
    return [{}]


def layout_digest(family: Family, case: Mapping[str, Value] | None = None, seed: int = 7) -> str:
    """Return sixteen hex digits of a seed's world without its witness.

    Pin it in a test, and raise the family's version when it changes.
    """
    return world_digest(replace(generate(family, seed, **(case or {})), certificate=None))[:16]


def run_checks(
    family: Family, cases: list[dict[str, Value]] | None = None, *, without: Collection[str] = ()
) -> Iterator[CheckOutcome]:
    """Yield every check of every case; checks of the family as a whole run once.

    Args:
        family: The family.
        cases: Parameters to check it with; :func:`family_cases` if omitted.
        without: Names of checks to skip.
    """
    every_case = family_cases(family) if cases is None else cases
    for checks, some in ((FAMILY_CHECKS, [{}]), (CHECKS, every_case)):
        for case in some:
            for check in checks:
                if check.name not in without:
                    yield _outcome(check, family, case)


def _outcome(check: Check, family: Family, case: Mapping[str, Value]) -> CheckOutcome:
    try:
        check(family, case)
    except BrokenContract as fault:
        return CheckOutcome(check.name, case, str(fault))
    except WorldgenError as error:
        return CheckOutcome(check.name, case, f"no world: {error}")
    except Exception as error:  # noqa: BLE001 - a family is foreign code
        return CheckOutcome(check.name, case, f"raises {type(error).__name__}: {error}")
    return CheckOutcome(check.name, case)


def check_family(
    family: Family,
    cases: list[dict[str, Value]] | None = None,
    *,
    golden: Mapping[str, str] | None = None,
) -> None:
    """Run every check, and compare pinned digests.

    Args:
        family: The family.
        cases: Parameters to check it with; :func:`family_cases` if omitted.
        golden: :func:`layout_digest` by the first value of a case, or by "" for the defaults.

    Raises:
        BrokenContract: With a line for each broken promise.
    """
    # Collect every fault, so that one run of the test shows all of them.
    faults = [shown(found) for found in run_checks(family, cases) if found.fault]
    for case in (family_cases(family) if cases is None else cases) if golden is not None else []:
        key = str(next(iter(case.values()), ""))
        digest = layout_digest(family, case)
        pinned = (golden or {}).get(key)
        if digest != pinned:
            faults.append(
                f"seed 7{_in_parentheses(case)} gives {digest}, but {pinned} is pinned; raise the version, "
                f"or pin it again"
            )
    if faults:
        raise BrokenContract("\n".join((f"{family.name} breaks its contract:", *faults)))


def shown(found: CheckOutcome) -> str:
    """Return one line that describes a violation."""
    return f"{found.check}{_in_parentheses(found.case)}: {found.fault}"


def _in_parentheses(case: Mapping[str, Value]) -> str:
    settings = ", ".join(f"{name}={quote(str(value), 60)}" for name, value in case.items())
    return f" ({settings})" if settings else ""


def _demand(holds: bool, message: str) -> None:
    if not holds:
        raise BrokenContract(message)


# These checks of a case make a few of its worlds.


def _equal_seed(family: Family, case: Mapping[str, Value]) -> None:
    for seed in range(2):
        same = dumps(generate(family, seed, **case)) == dumps(generate(family, seed, **case))
        _demand(same, f"seed {seed} gives two different worlds; draw only from rng")


def _different_seeds(family: Family, case: Mapping[str, Value]) -> None:
    worlds = {world_digest(generate(family, seed, **case)) for seed in range(_WIDE)}
    _demand(
        len(worlds) == _WIDE,
        f"seeds 0 to {_WIDE - 1} give {len(worlds)} worlds; let rng decide more",
    )


def _certificate(family: Family, case: Mapping[str, Value]) -> None:
    for seed in range(_SEEDS):
        world = generate(family, seed, **case)
        report = check_certificate(world)
        held = isinstance(world.certificate, Witness | JointWitness) and report.valid
        _demand(held, f"seed {seed}: the independent checker refuses the witness: {report.reason}")


def _provenance(family: Family, case: Mapping[str, Value]) -> None:
    world = generate(family, 8, **case)
    made = world.provenance
    _demand(made is not None, "its worlds have no provenance")
    if made is not None:
        _demand(
            (made.family, made.version, made.seed) == (family.name, family.version, 8),
            "the provenance belongs to another world",
        )
        again = generate(family, made.seed, **made.params)
        _demand(dumps(again) == dumps(world), "a world cannot be rebuilt from its provenance")


def _file(family: Family, case: Mapping[str, Value]) -> None:
    world = generate(family, 2, **case)
    _demand(loads(dumps(world)) == world, "a world differs after it is read from its file")


def _no_global_state(family: Family, case: Mapping[str, Value]) -> None:
    alone = [dumps(generate(family, seed, **case)) for seed in (1, 2)]
    mixed = []
    kept = random.getstate(), np.random.get_state()
    try:
        for seed in (1, 2):
            random.seed(seed)
            np.random.seed(seed)
            generate("trap", 99 - seed)
            before = _other_chance()
            mixed.append(dumps(generate(family, seed, **case)))
            _demand(
                _other_chance() == before,
                "it draws from Python's or NumPy's random; draw only from rng",
            )
    finally:
        random.setstate(kept[0])
        np.random.set_state(kept[1])
    _demand(
        alone == mixed,
        "a world depends on what was made before it; keep nothing outside the function",
    )


def _other_chance() -> tuple[object, ...]:
    """Return the states of the generators that a family must not use."""
    state = np.random.get_state(legacy=False)["state"]
    return random.getstate(), state["key"].tobytes(), state["pos"]


def _timeline(family: Family, case: Mapping[str, Value]) -> None:
    for seed in range(_SEEDS):
        world = generate(family, seed, **case)
        _demand(
            family.changes or not world.is_dynamic,
            "its worlds change with time; declare @family(..., changes=True)",
        )
        now = world.walls.astype(int)
        for event in world.timeline:
            said = int(event.state) != now[event.iy, event.ix]
            _demand(
                bool(said),
                f"seed {seed}: at {event.time} s cell ({event.ix}, {event.iy}) changes to the "
                f"state that it already has",
            )
            now[event.iy, event.ix] = int(event.state)
        _demand(
            not (now == CellState.BURNING).any(),
            f"seed {seed}: a cell burns forever; add the time at which it burns out",
        )


def _margin(family: Family, case: Mapping[str, Value]) -> None:
    if MARGIN not in family.defaults():
        return
    world = generate(family, 1, **{**case, MARGIN: 0.5})
    if isinstance(world.certificate, Witness):
        _demand(
            witness_margin(world, world.certificate) >= 0.5,
            "a witness has a smaller margin than requested",
        )


CHECKS = (
    Check("equal-seed-gives-equal-bytes", _equal_seed),
    Check("different-seeds-give-different-worlds", _different_seeds),
    Check("the-independent-checker-accepts-the-witness", _certificate),
    Check("provenance-is-enough-to-make-the-world-again", _provenance),
    Check("a-world-comes-back-from-its-file", _file),
    Check("what-was-made-before-does-not-matter", _no_global_state),
    Check("a-timeline-never-says-what-already-is", _timeline),
    Check("the-margin-asked-for-is-kept", _margin),
)


# These checks are about the family as a whole: its parameters.


def _low_bits(family: Family, case: Mapping[str, Value]) -> None:
    same = dumps(generate(family, -1, **case)) == dumps(generate(family, 2**64 - 1, **case))
    _demand(same, "seeds -1 and 2**64 - 1, which are the same 64 bits, give two worlds")


def _explained(family: Family, case: Mapping[str, Value]) -> None:
    silent = [parameter.name for parameter in family.parameters if not parameter.help]
    _demand(bool(family.description), "it has no docstring; describe its worlds in a sentence")
    _demand(
        not silent, f"{', '.join(silent)}: not explained; describe them under Args in the docstring"
    )


def _unknown(family: Family, case: Mapping[str, Value]) -> None:
    with _refused("an unknown parameter"):
        generate(family, 0, **{**case, "no_such_parameter": 1})


def _other_type(family: Family, case: Mapping[str, Value]) -> None:
    for parameter in family.parameters:
        for value in _WRONG:
            fits = {type(parameter.default)} | (
                {int} if type(parameter.default) is float else set()
            )
            if type(value) not in fits:
                with _refused(f"{parameter.name}={value!r}"):
                    generate(family, 0, **{**case, parameter.name: value})
        if type(parameter.default) is float:
            for number in _NOT_FINITE:
                with _refused(f"{parameter.name}={number!r}"):
                    generate(family, 0, **{**case, parameter.name: number})


@contextlib.contextmanager
def _refused(what: str) -> Iterator[None]:
    """Expect the body to be refused with a one-line message."""
    try:
        yield
    except WorldgenError as error:
        _demand("\n" not in str(error), f"{what} is refused in more than one line")
        return
    raise BrokenContract(f"{what} is not refused")


def _absurd(family: Family, case: Mapping[str, Value]) -> None:
    values = [
        (parameter.name, value)
        for parameter in family.parameters
        for value in _absurd_values(parameter)
    ]
    # Another process makes the worlds, because only a process can be ended at any time.
    pool = WorkerPool(1)
    try:
        names = _names_for_processes(family)
        name = None
        # A script without ``if __name__ == "__main__"`` cannot start processes.
        with contextlib.suppress(BrokenProcessPool):
            name = pool.submit(_first_that_loads, names).result() if names else None
        for parameter, value in values:
            what = _setting(parameter, value)
            try:
                # No other process can load a family that a function defines: it has no time limit.
                if name is None:
                    fault = _fault_of_value(family, case, parameter, value)
                else:
                    waiting = pool.submit(_fault_of_named, name, case, parameter, value)
                    fault = waiting.result(PATIENCE)
            except TimeoutError:
                fault = f"{what} takes more than {PATIENCE} s; refuse values that are too large"
            except BrokenProcessPool:
                fault = f"{what} ends Python; refuse it"
            _demand(not fault, fault)
    finally:
        pool.end()


def _names_for_processes(family: Family) -> list[str]:
    """Return the names under which another process might find the family."""
    if family.name in FAMILIES.names() and FAMILIES.get(family.name) is family:
        return [family.name]
    module = sys.modules.get(family.build.__module__)
    if module is None or module.__name__ == "__main__":
        return []
    names = [name for name, thing in vars(module).items() if thing is family]
    # Python may not find a module by its name, such as a test's or one of a user's file.
    places = filter(None, (module.__name__, getattr(module, "__file__", None)))
    return [f"{place}:{name}" for place in places for name in names]


def _first_that_loads(names: list[str]) -> str | None:
    for name in names:
        with contextlib.suppress(InvalidParameter):
            FAMILIES.get(name)
            return name
    return None


def _fault_of_named(name: str, case: Mapping[str, Value], parameter: str, value: Value) -> str:
    """Call :func:`_fault_of_value` in another process."""
    return _fault_of_value(FAMILIES.get(name), case, parameter, value)


def _fault_of_value(family: Family, case: Mapping[str, Value], parameter: str, value: Value) -> str:
    """Return what is wrong with the world of a parameter's value, or with its refusal."""
    what = _setting(parameter, value)
    try:
        world: World = generate(family, 0, **{**case, parameter: value})
        if not check_certificate(world).valid:
            return f"{what} gives a world whose witness does not hold"
    except WorldgenError as error:
        if "\n" in str(error):
            return f"{what} is refused in more than one line"
    except Exception as error:  # noqa: BLE001 - a family is foreign code
        exception = f"{type(error).__name__}: {str(error)[:80]}"
        return f"{what} raises {exception}; refuse it with check_between() or the like"
    return ""


def _setting(parameter: str, value: Value) -> str:
    return f"{parameter}={quote(str(value))}"


def _absurd_values(parameter: Parameter) -> tuple[Value, ...]:
    if parameter.choices:
        return (*parameter.choices, *_ABSURD[str])
    return _ABSURD.get(type(parameter.default), (True, False))


FAMILY_CHECKS = (
    Check("a-seed-counts-by-its-low-64-bits", _low_bits),
    Check("every-parameter-is-explained", _explained),
    Check("an-unknown-parameter-is-refused", _unknown),
    Check("a-value-of-another-type-is-refused", _other_type),
    Check("an-absurd-value-is-refused-or-works", _absurd),
)
