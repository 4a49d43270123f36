"""A campaign's live counts: they advance within a unit, cover all processes, and do not affect the
result.
"""

import time

import pytest

from fuzz.campaign.configure import configure
from fuzz.campaign.executors import InlineExecutor, ProcessExecutor
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import UnitDone
from fuzz.campaign.summary import describe_speed
from fuzz.unit.live import LIVE_FILE, LiveCounts, LiveState, count_live, read_live, shown_in
from fuzz.unit.options import CampaignOptions


def small(**options):
    return configure(
        CampaignOptions(controller="turn-right", families=("trap",), examples=8, **options), 1
    )


def test_each_run_is_counted_when_it_ends():
    with InlineExecutor() as executor:
        count_live("reached", 3, 30)
        count_live("loop", 2, 20)
        assert executor.counts() == LiveCounts(5, 50, 2)


def test_what_is_under_way_is_what_was_counted_and_not_handed_in():
    handed_in = LiveCounts().plus(3, 30, {"reached": 2, "loop": 1})
    assert LiveCounts(5, 50, 2).without(handed_in) == LiveCounts(2, 20, 1)
    assert LiveCounts(1, 10, 0).without(handed_in) == LiveCounts()


def test_a_campaign_counts_nothing_until_it_has_tried_something_and_each_run_once():
    campaign = Campaign(small(), units=2)
    assert campaign.live() == LiveState("preparing")
    for _ in campaign.run():
        pass
    live = campaign.live()
    assert (live.worlds, live.steps) == (campaign.state.worlds, campaign.state.steps)
    assert live.failed > 0


class Watched(InlineExecutor):
    """Notes the campaign's activity during each piece of work."""

    def __init__(self):
        super().__init__()
        self.seen = []

    def submit(self, work, /, *args, **kwargs):
        def watched():
            result = work(*args, **kwargs)
            live = self.campaign.live()
            self.seen.append((work.__name__, str(live.phase), live.shrinking > 0))
            return result

        return super().submit(watched)


def test_a_single_worker_is_searching_during_its_units_and_shrinking_only_failures():
    config = configure(
        CampaignOptions(controller="turn-right", families=("trap",), examples=8, shrink=True), 1
    )
    executor = Watched()
    executor.campaign = Campaign(config, units=2, executor=executor)
    for _ in executor.campaign.run():
        pass
    searching = ("run_unit", "searching", False)
    assert executor.seen[0] == searching
    others = {one for one in executor.seen if one[0] != "run_unit"}
    assert others == {("shrunk_or_same", "shrinking", True)}
    units = {one[:2] for one in executor.seen if one[0] == "run_unit"}
    assert units == {searching[:2]}


def count_one_and_wait(answer):
    count_live("loop", 1, 10)
    while not answer.exists():
        time.sleep(0.001)


@pytest.mark.gate
def test_the_runs_of_a_unit_in_progress_are_seen_from_another_process(tmp_path):
    answer = tmp_path / "seen"
    with ProcessExecutor(1) as executor:
        unit = executor.submit(count_one_and_wait, answer)
        while executor.counts() != LiveCounts(1, 10, 1):
            assert not unit.done()
        answer.touch()
        unit.result()


@pytest.mark.gate
def test_all_runs_of_other_processes_are_counted():
    campaign = Campaign(small(), units=2, executor=ProcessExecutor(2))
    for _ in campaign.run():
        pass
    assert campaign.live().worlds == campaign.state.worlds > 0


def test_a_file_says_what_goes_on_and_is_gone_afterwards(tmp_path):
    state = LiveState("searching", 7, 70, 1, 2, 0.5)
    with shown_in(tmp_path, lambda: state):
        while read_live(tmp_path) is None:
            pass
        assert read_live(tmp_path) == state
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("text", ["", "[]", '{"phase": 1, "more": 2}', "{"])
def test_a_file_that_is_not_whole_says_nothing(tmp_path, text):
    (tmp_path / LIVE_FILE).write_text(text)
    assert read_live(tmp_path) is None


def test_the_speed_of_a_search_is_described_once_a_unit_is_done():
    assert describe_speed(LiveState("searching", 7, 70)) == ""
    slow = LiveState("searching", 7, 70, rate=190.0, cost=0.31, own=0.95, left=40.0)
    assert describe_speed(slow) == (
        "; 190 worlds a minute, 0.31 s each (95 % your controller), about 40 s left"
    )
    assert describe_speed(LiveState("searching", rate=9e4, cost=1e-3)) == "; 90,000 worlds a minute"


def test_a_running_campaign_estimates_what_its_units_need():
    campaign = Campaign(small(), units=2)
    left = [campaign.live().left for event in campaign.run() if isinstance(event, UnitDone)]
    assert left[0] > left[1] == 0.0
    assert campaign.live().rate > 0.0 and campaign.live().cost > 0.0
