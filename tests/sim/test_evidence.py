"""Evidence: records to tables and back."""

import pytest

from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    CollisionEvidence,
    ContactEvidence,
    CoveredEvidence,
    FaultEvidence,
    JointLoopEvidence,
    LoopEvidence,
    ReachedEvidence,
    WallEvidence,
    evidence_table,
    read_evidence,
)
from sim.verdict import Verdict

FRAMES = ({"file": "mine.py", "line": 3, "function": "act"},)
JOINT = JointLoopEvidence(
    entry=4,
    period=2,
    state_digest="0" * 16,
    waiting=(1, 3),
    moving=(),
    blocked=((1, 3), (3, 1)),
    parked=((2, 90),),
)
EACH = {
    Verdict.REACHED: ReachedEvidence(step=5, wall_step=3),
    Verdict.COVERED: CoveredEvidence(step=5, cells=3),
    Verdict.LOOP: LoopEvidence(entry=0, period=4, state_digest="0" * 16),
    Verdict.LIVELOCK: JOINT,
    Verdict.DEADLOCK: JOINT,
    Verdict.STARVED: JOINT,
    Verdict.COLLISION: CollisionEvidence(step=3, robots=(1, 2)),
    Verdict.STALLED: BudgetEvidence(
        last_new_cell=3, kind="drifting", entry=4, period=2, box=(3, 1)
    ),
    Verdict.TIMEOUT: BudgetEvidence(last_new_cell=90, witness_multiple=50.0),
    Verdict.TUNNEL: WallEvidence(step=7, cell=(-1, 3), cause="slide", since=6, reached=9),
    Verdict.OVERLAP: WallEvidence(step=7, cell=(2, 3)),
    Verdict.CONTACT: ContactEvidence(step=2, cell=(-1, 4)),
    Verdict.BURNED: BurnedEvidence(step=2, cell=(4, 4), state="burning", robot=2),
    Verdict.CRASH: FaultEvidence(
        error="exit code 1", exit_code=1, step=2, stderr=("a", "b"), frames=FRAMES, bump=True
    ),
    Verdict.HANG: FaultEvidence(error="no answer", step=1, deadline=1.0, unfinished="{"),
    Verdict.INVALID_COMMAND: FaultEvidence(error="no speed", rule="no-speed", step=1),
}


def test_every_verdict_is_tried_here():
    assert set(EACH) == set(Verdict)


@pytest.mark.parametrize("verdict", EACH, ids=str)
def test_evidence_comes_back_from_its_table(verdict):
    assert read_evidence(verdict, evidence_table(EACH[verdict])) == EACH[verdict]


def test_what_is_unknown_is_not_in_the_table():
    assert evidence_table(ReachedEvidence(step=5)) == {"step": 5}


def test_a_table_without_what_the_evidence_needs_is_none():
    assert read_evidence(Verdict.LOOP, {"entry": 3, "period": "4", "state_digest": "0"}) is None


def test_optional_parts_of_another_type_and_unknown_names_are_passed_over():
    table = {"step": 5, "cell": [1, 2], "cause": 7, "since": True, "colour": "red"}
    assert read_evidence(Verdict.TUNNEL, table) == WallEvidence(step=5, cell=(1, 2))
