"""Targets: how their text is parsed, which results meet them, and how far off the others are."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.find import parse_targets
from sim import simulate
from tests.helpers.command_line import worldgen
from worldgen import read_world
from worldgen.errors import InvalidParameter

CONFIGURATIONS = Path(__file__).parents[2] / "corpora" / "thesis"

CONTROLLERS = '''
from sim import Command

class Creeps:
    """Straight on, so slowly that it still enters new cells when its time is over."""
    def reset(self): return ()
    def act(self, observation, memory): return Command(0.0066, 0.0), memory

class Coin:
    """Straight on at full speed, left by chance: which way depends on the seed."""
    def reset(self): return ()
    def act(self, observation, memory): return Command(observation.top_speed, 0.0, used_random=True), memory
'''

ROOM = (
    "%worldgen-grid 1\ncell_size = 0.1\nrobot_radius = 0.07\nstart = [0.25, 0.25, 0.0]\ntarget = "
    "[2.85, 0.25, 0.05]\n"
    "\n%cells\n"
    + "\n".join(["#" * 31, *["#" + "." * 24 + "#...." + "#"] * 3, "#" * 31])
    + "\n%end\n"
)


def target_of(text, **options):
    (one,) = parse_targets(text, **options)
    return one


@pytest.fixture
def room(tmp_path):
    (tmp_path / "room.grid").write_text(ROOM)
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    return read_world(tmp_path / "room.grid"), f"{tmp_path}/mine.py"


@pytest.mark.parametrize(
    ("outcome", "low", "high"),
    [
        ("reached", None, None),
        ("reached@330", 330, 330),
        ("reached@389..600", 389, 600),
        ("reached@<400", None, 399),
        ("reached@>400", 401, None),
        ("reached@4.95s", 330, 330),
        ("reached@3s..4.5s", 200, 300),
        ("loop@104", 104, 104),
        ("loop@>104", 105, None),
    ],
)
def test_numbers_behind_an_outcome_are_a_range(outcome, low, high):
    one = target_of(f"turn-left={outcome}")
    assert (one.low, one.high, one.text) == (low, high, outcome)


def test_seconds_count_in_the_time_step_of_the_controller():
    assert target_of("turn-left+time_step=0.03=reached@3s").low == 100
    assert target_of("turn-left=reached@3s", time_step=0.1).low == 30


def test_a_controller_may_name_its_own_motion_and_switches():
    one, other = parse_targets(
        "thesis-1+noise+motion=stepped=loop, turn-left=reached", motion="endpoint"
    )
    assert (one.scenario.run.motion, one.scenario.run.thesis.noise, other.scenario.run.motion) == (
        "stepped",
        True,
        "endpoint",
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "outcome '' is not CONTROLLER=OUTCOME"),
        ("turn-left", "'turn-left' is not CONTROLLER=OUTCOME"),
        ("turn-left=loop,", "outcome '' is not CONTROLLER=OUTCOME"),
        ("=loop", "'=loop' is not CONTROLLER=OUTCOME"),
        ("turn-left=", "outcome '' of turn-left is not one of stuck, fails, reached"),
        ("turn-left=lost", "outcome 'lost' of turn-left is not one of"),
        ("turn-left=Loop", "outcome 'Loop' of turn-left is not one of"),
        ("turn-lfet=loop", "did you mean 'turn-left'"),
        ("turn-left=stalled@30", "only reached and loop take steps after @"),
        ("turn-left=reached@", "outcome 'reached@' of turn-left is not one of"),
        ("turn-left=reached@soon", "steps 'soon' are not of a form such as 330"),
        ("turn-left=reached@0", "no number of steps matches"),
        ("turn-left=reached@<1", "no number of steps matches"),
        ("turn-left=reached@600..389", "no number of steps matches"),
        ("turn-left=reached@-3", "steps '-3' are not of a form such as 330"),
        ("turn-left=reached@1.5", "1.5 is not a whole number of steps"),
        ("turn-left=reached@0.01s", "0.01s is not a whole number of steps"),
        ("turn-left=reached@99999999", "is not a whole number of steps up to 10 million"),
        ("turn-left+motion=stepped+noize=loop", "noize"),
    ],
)
def test_a_malformed_target_is_a_sentence_and_code_2(text, message, tmp_path):
    result = worldgen(
        "find", "--outcome", text, "--units", 1, "--seed", 1, "--out", tmp_path / "w.grid"
    )
    assert result.code == 2 and message in result.err and "Traceback" not in result.err
    assert len(result.err.splitlines()) <= 2


@given(st.text(st.sampled_from("turn-lefabcdp=@.<>,+s019 \n"), max_size=40))
def test_any_text_is_a_target_or_refused(text):
    try:
        assert parse_targets(text)
    except InvalidParameter as error:
        assert str(error)


@pytest.mark.parametrize(
    ("outcome", "verdict", "steps"),
    [
        ("thesis-1=reached", "reached", 2554),
        ("thesis-2=loop", "loop", 104),
        ("thesis-2=stuck", "loop", 104),
        ("thesis-2=never", "loop", 104),
    ],
)
def test_an_outcome_without_number_is_fulfilled_by_any(outcome, verdict, steps):
    result = target_of(outcome, motion="stepped").look(
        read_world(CONFIGURATIONS / "config-05.grid")
    )
    assert (result.verdict, result.steps, result.distance) == (verdict, steps, 0.0)


@pytest.mark.parametrize(
    ("outcome", "distance"),
    [
        ("thesis-1=reached@2554", 0.0),
        ("thesis-1=reached@2500..2600", 0.0),
        ("thesis-1=reached@2000", 554 / 2000),
        ("thesis-1=reached@>2553", 0.0),
        ("thesis-1=reached@>3192", (3193 - 2554) / 3193),
        ("thesis-1=reached@10", 2.0),
        ("thesis-1=fails", 2.0 - 2554 / 20_000),
        ("thesis-1=tunnel", 2.0 - 2554 / 20_000),
        ("thesis-2=loop@104", 0.0),
        ("thesis-2=loop@>104", 1 / 105),
        ("thesis-2=stalled", 2.0),
        ("thesis-2=fails", 0.0),
    ],
)
def test_how_near_a_run_is_to_what_is_wanted(outcome, distance):
    result = target_of(outcome, motion="stepped").look(
        read_world(CONFIGURATIONS / "config-05.grid")
    )
    assert result.distance == pytest.approx(distance, abs=1e-12)


def test_stuck_without_chance_is_a_loop_or_a_stall_and_no_timeout(room):
    world, mine = room
    result = target_of(f"{mine}:Creeps=stuck").look(world)
    assert result.verdict == "timeout" and result.distance == 2.0


def test_stuck_with_chance_is_not_to_arrive_in_the_budget():
    result = target_of("thesis-3=stuck", motion="stepped").look(
        read_world(CONFIGURATIONS / "config-05.grid")
    )
    assert (result.verdict, result.share, result.seeds, result.distance) == (
        "timeout",
        0.0,
        20,
        0.0,
    )


def test_a_loop_of_a_controller_with_chance_is_not_fulfilled_by_a_timeout():
    result = target_of("thesis-3=loop", motion="stepped").look(
        read_world(CONFIGURATIONS / "config-05.grid")
    )
    assert result.verdict == "timeout" and result.distance > 1.0


def test_stuck_with_chance_is_further_off_the_more_seeds_arrive():
    world = read_world(CONFIGURATIONS / "config-09.grid")
    result = target_of("thesis-3=stuck", motion="stepped").look(world)
    assert result.share == 1.0 and result.distance == pytest.approx(1.9)


def test_to_go_through_a_wall_is_not_stuck(room):
    world, mine = room
    result = target_of(f"{mine}:Coin+motion=endpoint+time_step=0.33=stuck").look(world)
    assert result.verdict == "tunnel" and result.distance > 2.0


def test_a_python_controller_that_uses_chance_is_judged_by_twenty_seeds(room):
    world, mine = room
    result = target_of(f"{mine}:Coin+motion=endpoint+time_step=0.33=tunnel").look(world)
    assert (result.seeds, result.distance) == (20, 0.0)


def test_the_time_of_a_controller_with_chance_is_the_median_over_the_seeds():
    world = read_world(CONFIGURATIONS / "config-09.grid")
    one = target_of("thesis-3=reached@900..1700", motion="stepped")
    steps = sorted(int(arrival(world, seed)) for seed in range(20))
    assert one.look(world).steps == (steps[9] + steps[10]) / 2 and one.look(world).distance == 0.0


def arrival(world, seed):
    episode = simulate(world, "thesis-3", motion="stepped", seed=seed)
    return episode.steps if episode.verdict == "reached" else math.inf
