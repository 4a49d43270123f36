"""Words that promise something about the future are used only where a proof backs them."""

import contextlib
import re
from unittest import mock

import pytest

from sim.fleet.run import FleetRun
from sim.runners.lattice import LatticeRun
from sim.thesis.run import ThesisRun
from sim.verdict import ARRIVALS, NEVER, STUCK, Verdict, without_arrival
from tests.repo.documented_commands import PAGES, ROOT, Command, Page, read_parts, run_page
from worldgen.files.grid import read_world

CLAIM = re.compile(r"\bnever \(|\b(?:loop|livelock|deadlock|starved) forever\b|\bnever arrives?\b")
"""What commands print about robots that provably do not arrive."""

PROVED = re.compile(r"\b(?:loop|livelock|deadlock|starved|trap|proved|proves|proof|recurs?)\b")
LONGER = 100
RUNS = ("worldgen run ", "worldgen compare ", "worldgen replay ")


@pytest.mark.parametrize("verdict", list(Verdict))
def test_never_is_said_of_verdicts_that_prove_it(verdict):
    proved = verdict in (Verdict.LOOP, Verdict.LIVELOCK, Verdict.DEADLOCK, Verdict.STARVED)
    assert (without_arrival(verdict) == "never") is proved
    assert (verdict in NEVER) is proved
    assert Verdict.STALLED in STUCK and Verdict.STALLED not in NEVER


def bare_claims(text: str) -> list[str]:
    """Return the rows of tables, and the paragraphs, that make a claim and name no proof."""
    pieces = []
    for paragraph in text.split("\n\n"):
        is_rows = paragraph.lstrip().startswith(("|", "```"))
        pieces += paragraph.splitlines() if is_rows else [paragraph]
    return [piece for piece in pieces if CLAIM.search(piece) and not PROVED.search(piece)]


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_pages_say_that_a_robot_never_arrives_only_next_to_the_proof(path):
    assert bare_claims(path.read_text("utf-8")) == []


def test_a_claim_without_a_proof_is_found():
    assert bare_claims("| `a` | never (stalled) |\n| `b` | never (loop) |") == [
        "| `a` | never (stalled) |"
    ]


def claims(command: Command) -> bool:
    return command.text.startswith(RUNS) and any(map(CLAIM.search, command.shown))


def pages() -> list[Page]:
    """Return the parts of pages in which a command prints that a robot never arrives."""
    return [
        part
        for path in PAGES
        for part in read_parts(path)
        if any(claims(one) for block in part.blocks if block.runs_here for one in block.commands)
    ]


@contextlib.contextmanager
def run_longer(found: list[str]):
    """Run whatever is proved to loop on, without a look at its states, and note what arrives."""

    def watched(original, arrived_in):
        def prove(self, *args, record):
            proof = original(self, *args, record=record)
            if proof is not None:
                options = self.runs[0].options if isinstance(self, FleetRun) else self.options
                steps = LONGER * options.steps
                outcome = self.run(steps, find_loop=False, record=False)
                found.append(arrived_in(outcome, proof))
            return proof

        return prove

    def alone(outcome, _proof):
        return outcome.ending if outcome.ending in ARRIVALS else ""

    def together(outcome, proof):
        waiting = {
            one for one, end in enumerate(proof.outcome.members) if end.ending not in ARRIVALS
        }
        late = [one for one in waiting if outcome.members[one].ending in ARRIVALS]
        return f"robots {late}" if late else ""

    with contextlib.ExitStack() as stack:
        for owner, name, arrived in (
            (LatticeRun, "prove", alone),
            (ThesisRun, "prove", alone),
            (FleetRun, "prove", together),
            (FleetRun, "prove_apart", together),
        ):
            patched = watched(getattr(owner, name), arrived)
            stack.enter_context(mock.patch.object(owner, name, patched))
        yield


@pytest.mark.nightly
@pytest.mark.usefixtures("drawn_seeds")
@pytest.mark.parametrize("page", pages(), ids=lambda page: f"{page.path.stem}")
def test_what_a_page_says_never_arrives_does_not_arrive_in_a_hundred_times_the_time(page, tmp_path):
    found: list[str] = []
    todo = [one for block in page.blocks if block.runs_here for one in block.commands]
    # If a command fails, the page's folder must not stay the current one.
    with contextlib.closing(run_page(page, tmp_path)) as steps:
        for command in todo:
            # Only the commands that make the claim: others may try thousands of worlds.
            with run_longer(found) if claims(command) else contextlib.nullcontext():
                done = next(steps)
            assert done.fault is None, done.fault
    assert found, "no claim was run again"
    assert not any(found), found


LOOPS = sorted(
    path
    for path in (ROOT / "corpora").rglob("*.grid")
    if re.search(rf'^verdict = "(?:{"|".join(NEVER)})"', path.read_text("utf-8"), re.MULTILINE)
)


@pytest.mark.nightly
@pytest.mark.parametrize("path", LOOPS, ids=lambda path: str(path.relative_to(ROOT / "corpora")))
def test_a_shipped_loop_does_not_arrive_in_a_hundred_times_the_time(path):
    from fuzz.failure import Failure

    found: list[str] = []
    failure = Failure.found_in(read_world(path))
    with run_longer(found):
        assert failure.run().verdict in NEVER
    assert found and not any(found), found
