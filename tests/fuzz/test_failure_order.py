"""Campaigns, corpora, the shrinker and reports choose by the same order of failures."""

import itertools
from pathlib import Path

import pytest

from fuzz.corpus import distinct, read_corpus, smallest
from fuzz.failure import Failure
from fuzz.overview import building
from fuzz.overview.clearest import clearest
from fuzz.report.answers import answers_for
from fuzz.shrink.queue import ShrinkQueue
from fuzz.triage.judging import JudgedRun
from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import SearchState, UnitResult

FAULTS = Path(__file__).parents[2] / "corpora" / "thesis-faults"


@pytest.fixture(scope="module")
def equal():
    """Return four different, equally simple failures in one world, in order."""
    one = Failure.read(FAULTS / "thesis-1-loop-104.grid")
    return sorted((one.noting(found_by=word) for word in "abcd"), key=lambda other: other.order)


@pytest.fixture
def corpus(equal, tmp_path):
    """Return entries of the same failures, named so that their paths are in the opposite order."""
    for number, failure in enumerate(equal):
        failure.write(tmp_path / f"{9 - number}.grid")
    return read_corpus([tmp_path]).entries


def test_of_two_different_failures_one_comes_first(equal):
    stored = [Failure.read(path) for path in sorted(FAULTS.glob("*.grid"))]
    for one, other in itertools.combinations([*equal, *stored], 2):
        assert (one.order < other.order) != (other.order < one.order)
    assert equal[0].order == Failure.of(equal[0].stored).order


def test_a_simpler_failure_comes_first_whatever_the_digests_are(equal):
    stored = [Failure.read(path) for path in sorted(FAULTS.glob("*.grid"))]
    for one, other in itertools.permutations([*equal, *stored], 2):
        assert one.size >= other.size or one.order < other.order


def test_a_corpus_orders_failures_as_they_order_themselves(equal, corpus):
    orders = [one.order for one in equal]
    assert [entry.facts.order for entry in distinct(corpus)] == orders
    assert [entry.facts.order for entry in distinct(reversed(corpus))] == orders
    assert [entry.facts.order for entry in smallest(corpus).values()] == orders[:1]


NEW = {"is_known": False, "is_interesting": True}


@pytest.mark.parametrize("places", [*itertools.permutations(range(4))], ids=str)
def test_a_campaign_keeps_the_first_failure_in_whatever_order_it_finds_them(
    equal, places, monkeypatch
):
    key = equal[0].key
    found = [equal[place] for place in places]
    triage = Triage(CampaignConfig(found[0].scenario, seed=1), UnitResult())
    monkeypatch.setattr(
        "fuzz.triage.triage.judge", lambda *_, **__: JudgedRun(found[triage.result.worlds], True)
    )
    queue = ShrinkQueue(shrinks=True, by_size=False)
    memory = SearchState()
    for failure in found:
        triage.enter(failure.world, failure.scenario, failure.verdict)
        triage.result.worlds += 1
        memory = memory.after(UnitResult(failures={key: failure}))
        queue.job_for(failure, **NEW)
    assert triage.result.failures == memory.failures == {key: equal[0]}
    assert queue.unshrunk(()) == [equal[0]]


def test_a_campaign_shrinks_the_first_failure_of_each_group_first(equal):
    queue = ShrinkQueue(shrinks=True, by_size=True)
    # Errors with different reasons are groups of their own.
    failures = [one.noting(cause="unknown", **{"class": str(n)}) for n, one in enumerate(equal)]
    jobs = [queue.job_for(failure, **NEW) for failure in failures]
    for job in reversed(jobs):
        queue.add(job)
    assert [queue.take().failure for _ in jobs] == sorted(failures, key=lambda one: one.order)


def test_a_report_shows_the_first_of_equally_clear_failures_as_clearest_and_smallest(
    equal, corpus, monkeypatch
):
    monkeypatch.setattr(building, "explained", lambda *_: None)
    (answer,) = answers_for(corpus[::-1], [])
    names = [(Path(one.file).name, Path(one.smallest).name) for one in answer.result.causes]
    assert names == [("9.grid", "9.grid")]
    assert clearest(reversed(equal)) is equal[0]
