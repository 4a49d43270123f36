"""The archive strategy fills kinds of behaviour, the same each time, and finds failures."""

from dataclasses import replace
from itertools import pairwise
from multiprocessing import get_context

import numpy as np
import pytest

from fuzz.campaign.store.journal import Journal, UnitRecord
from fuzz.campaign.unit import run_unit
from fuzz.layouts.features import decode_scene
from fuzz.screening import evaluate
from fuzz.search.archive import archive_table
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.result import Elite, SearchState
from sim.scenario import Scenario
from worldgen import read_world

CONFIG = CampaignConfig(Scenario("turn-right"), seed=3, examples=20, families=("archive",))


@pytest.fixture(scope="module")
def epochs():
    """Run three units, each of which knows the ones before."""
    results, memories = [], [SearchState()]
    for unit in range(3):
        results.append(run_unit(CONFIG, unit, memories[-1]))
        memories.append(memories[-1].after(results[-1]))
    return results, memories


@pytest.mark.gate
def test_the_archive_grows_from_epoch_to_epoch(epochs):
    filled = [len(memory.elites) for memory in epochs[1]]
    assert filled[0] == 0 and filled[1] > 50 and filled == sorted(set(filled))


@pytest.mark.gate
def test_no_cell_of_the_archive_gets_worse(epochs):
    for before, after in pairwise(epochs[1]):
        assert all(
            after.elites[cell].quality >= elite.quality for cell, elite in before.elites.items()
        )


@pytest.mark.nightly
def test_children_of_an_archive_behave_in_more_ways_than_what_is_drawn_afresh(epochs):
    afresh = [run_unit(CONFIG, unit).elites for unit in (1, 2)]
    assert len(epochs[1][3].elites) > len({**epochs[0][0].elites, **afresh[0], **afresh[1]})


def test_an_elite_is_what_its_world_shows(epochs):
    elites = list(epochs[1][-1].elites.values())[:20]
    layouts = np.array([np.frombuffer(elite.layout, np.uint8) for elite in elites])
    solid = [decode_scene(elite.layout).solid_cells for elite in elites]
    assert [-elite.quality for elite in elites] == solid
    assert evaluate(layouts, CONFIG.scenario, np.zeros(len(elites), np.uint64), 0.015).ran.all()


@pytest.mark.gate
def test_a_unit_of_the_archive_strategy_is_the_same_again(epochs):
    again = run_unit(CONFIG, 2, epochs[1][2])
    assert again.elites == epochs[0][2].elites and again.steps == epochs[0][2].steps
    assert {k: found.dumps() for k, found in again.failures.items()} == {
        k: found.dumps() for k, found in epochs[0][2].failures.items()
    }


@pytest.mark.gate
@pytest.mark.parametrize("strategy", ["archive", "boundary"])
def test_another_process_does_a_unit_to_the_same_end(epochs, strategy):
    config = replace(CONFIG, families=(strategy,))
    with get_context("spawn").Pool(1) as pool:
        there = pool.apply(run_unit, (config, 5, epochs[1][2]))
    here = run_unit(config, 5, epochs[1][2])
    assert (there.worlds, there.steps, there.met, there.elites) == (
        here.worlds,
        here.steps,
        here.met,
        here.elites,
    )


def test_failures_of_the_archive_strategy_replay(epochs):
    failures = [failure for result in epochs[0] for failure in result.failures.values()]
    assert len(failures) > 5 and all(replay(failure).confirmed for failure in failures[:6])


def test_who_fails_has_no_children_but_a_place_on_the_map(epochs):
    for cell, elite in epochs[1][-1].elites.items():
        assert (elite.verdict == "reached") is (len(cell) == 4)


def test_elites_come_back_from_a_journal_as_they_were(epochs, tmp_path):
    result = replace(epochs[0][1], failures={})
    journal = Journal(tmp_path / "journal.txt", "fingerprint")
    journal.append(UnitRecord.of(1, result, 1.0))
    ((_, record),) = journal
    assert record.result(read_world).elites == epochs[0][1].elites


def test_a_summary_shows_the_simplest_run_of_each_kind_and_failures_before_others():
    few, many, fails = (
        Elite(b"", -3.0, "reached"),
        Elite(b"", -9.0, "reached"),
        Elite(b"", -20.0, "loop"),
    )
    table = archive_table({(0, 1, 5, 5): many, (0, 1, 2, 2): few, (3, 3): fails, (3, 3, 0, 0): few})
    assert table["cells"] == [[0, 1, -3.0, "reached"], [3, 3, -20.0, "loop"]]
    assert [axis["name"] for axis in table["axes"]] == ["detour", "density"]


def test_a_campaign_without_an_archive_says_so():
    assert archive_table({}) is None


def test_a_cell_outside_the_archive_is_not_shown():
    inside, outside = (Elite(b"", -1.0, "loop") for _ in range(2))
    table = archive_table({(1, 2): inside, (999, 0): outside, (0, 999, 0, 0): outside})
    assert table["cells"] == [[1, 2, -1.0, "loop"]]
    assert archive_table({(999, 0): outside}) is None
