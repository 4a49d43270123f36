"""Native search: the core's results for a layout match the rest of the product's for the decoded
world.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.campaign.unit import run_unit
from fuzz.facts.proofs import certified
from fuzz.layouts.features import decode_scene, decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES, SCENE_BYTES
from fuzz.layouts.variation import with_robot
from fuzz.screening import evaluate
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim import CompiledController
from sim.controllers import CONTROLLERS
from sim.episode import prepare
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.raising import raises
from tests.reference.sim import layout
from worldgen.errors import InvalidParameter
from worldgen.files.grid import dumps
from worldgen.lattice import UNIT
from worldgen.random_streams import RandomStream

SCENE = st.binary(min_size=SCENE_BYTES, max_size=SCENE_BYTES)
RUNS = (
    "turn-left",
    "turn-right+motion=endpoint",
    "turn-random+slip=0.2",
    "bug1+sensor_noise=0.1",
    "vfh",
    "turn-left+acceleration=3",
)


def scenes(count, seed=1, width=SCENE_BYTES):
    return (
        RandomStream(seed)
        .bits(8 * count)
        .astype("<u8")
        .view(np.uint8)
        .reshape(count, 64)[:, :width]
    )


def look(scenario, data, seed=0, time_step=0.015, budget=800):
    return evaluate(
        np.frombuffer(data, np.uint8)[None, :],
        scenario,
        np.array([seed], np.uint64),
        time_step,
        budget,
    )


def run_of(looks, n):
    scenario, world = looks.scenario_of(n), looks.world(n)
    budget = int(looks.budget[n])
    return prepare(world, scenario.controller, scenario.options(world, budget)).run(
        budget, find_loop=True, record=False
    )


@given(
    SCENE, st.sampled_from(RUNS), st.integers(0, 2**64 - 1), st.sampled_from((0.015, 0.05, 0.15))
)
def test_a_look_is_the_run_in_the_decoded_world_bit_for_bit(data, name, seed, time_step):
    looks = look(Scenario.parse(name), data, seed, time_step)
    if looks.ran[0]:
        run = run_of(looks, 0)
        metres = UNIT / looks.world(0).cell_size
        assert looks.verdict[0] in (run.ending, "undecided", "overlap")
        assert (looks.steps[0], looks.period[0], looks.collisions[0]) == (
            run.steps,
            run.period,
            run.collisions,
        )
        assert looks.path[0] / metres == pytest.approx(run.path_length, rel=1e-12)
        assert looks.raw["last_new_cell"][0] == run.last_new_cell
        assert (looks.raw["overlap_step"][0], looks.raw["hit_step"][0]) == (
            run.overlap_step,
            run.hit_step,
        )


BODIES = {
    "rectangle": {"robot_footprint": "0.62x0.9"},
    "long": {"robot_footprint": "3x0.3"},
    "off its axle": {"robot_footprint": "0.5,0 -0.2,0.3 -0.2,-0.1"},
    "round car": {"robot_drive": "car", "robot_turning_radius": 0.5},
    "car": {
        "robot_footprint": "1.2x0.4@0.3",
        "robot_drive": "car",
        "robot_turning_radius": 0.5,
        "robot_reverse": True,
    },
    "goal": {"robot_arrival": "stop", "robot_target_heading": "1:0.1", "robot_contact": "stop"},
    "large target": {"robot_target_radius": 0.2},
    "no contact": {"robot_footprint": "1.2x0.4", "robot_contact": "fail"},
}


@pytest.mark.parametrize("robot", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("name", ["bug2", "turn-right+motion=endpoint"])
def test_looks_at_bodies_and_goals_are_runs_of_these(name, robot):
    scenario = Scenario.parse(name)
    seeds = np.zeros(40, np.uint64)
    looks = evaluate(scenes(40), scenario, seeds, 0.015, 400, **robot)
    assert looks.ran.sum() > 10
    for n in np.flatnonzero(looks.ran).tolist():
        run = run_of(looks, n)
        assert looks.world(n).robots[0] == with_robot(looks.world(n), robot).robots[0]
        assert looks.verdict[n] in (run.ending, "undecided")
        assert (looks.steps[n], looks.collisions[n], looks.period[n]) == (
            run.steps,
            run.collisions,
            run.period,
        )


def test_many_looks_at_once_are_those_one_by_one():
    data, scenario = scenes(60), Scenario.parse("turn-random+motion=endpoint")
    seeds, steps = np.arange(60, dtype=np.uint64), np.resize([0.015, 0.06, 0.1], 60)
    together = evaluate(data, scenario, seeds, steps)
    for n in range(60):
        alone = evaluate(data[n : n + 1], scenario, seeds[n : n + 1], steps[n])
        assert alone.raw.tolist() == together.raw[n : n + 1].tolist()


@given(SCENE, st.sampled_from((0.02, 0.06, 0.1, 0.12, 0.15)), st.sampled_from((0.5, 3.0)))
def test_looks_at_robots_of_another_size_and_speed_are_runs_of_these(data, radius, speed):
    layouts = np.frombuffer(data, np.uint8)[None, :]
    looks = evaluate(
        layouts, Scenario("turn-left"), 0, 0.015, 400, robot_radius=radius, robot_speed=speed
    )
    if looks.ran[0]:
        run, world = run_of(looks, 0), looks.world(0)
        assert (world.robot_radius, world.robot_speed) == (radius, speed)
        assert (looks.steps[0], looks.collisions[0], looks.period[0]) == (
            run.steps,
            run.collisions,
            run.period,
        )


@given(SCENE, st.sampled_from(({}, {"robot_radius": 0.12}, {"robot_radius": 0.15})))
def test_where_a_look_runs_the_target_can_be_reached_by_no_longer_a_way(data, robot):
    layouts = np.frombuffer(data, np.uint8)[None, :]
    looks = evaluate(layouts, Scenario("turn-left"), 0, 0.015, 1, **robot)
    if looks.ran[0]:
        proved = certified(looks.world(0))
        assert proved is not None
        assert proved.certificate.duration * proved.robot_speed <= looks.way[0] * proved.cell_size


@pytest.mark.gate
@pytest.mark.parametrize("robot", [{}, {"robot_radius": 0.12}], ids=str)
def test_most_layouts_with_a_witness_are_looked_at(robot):
    drawn = scenes(200), Scenario("turn-left"), np.zeros(200, np.uint64)
    looks = evaluate(*drawn, 0.015, 1, **robot)
    reachable = [certified(looks.world(n)) is not None for n in range(200)]
    assert not (looks.ran & ~np.array(reachable)).any()
    assert looks.ran.sum() > 0.95 * sum(reachable)


def test_what_is_said_of_a_world_is_so():
    looks = evaluate(scenes(100), Scenario("turn-left"), np.zeros(100, np.uint64), 0.015, 50)
    for n in np.flatnonzero(looks.ran):
        world = looks.world(n)
        inner = world.walls[1:-1, 1:-1]
        assert looks.solid[n] == world.solid_cells
        assert looks.density[n] == pytest.approx(inner.mean())
        apart = (
            np.hypot(world.start.x - world.target.x, world.start.y - world.target.y)
            / world.cell_size
        )
        assert looks.straight[n] == pytest.approx(apart)


@pytest.mark.gate
@pytest.mark.parametrize("controller", ["turn-right", "wall-left"])
def test_loops_of_one_key_reach_as_far_and_come_as_near(controller):
    looks = evaluate(scenes(400), Scenario(controller), np.zeros(400, np.uint64), 0.015)
    shapes = {}
    for n in np.flatnonzero(looks.verdict == "loop")[:30]:
        failure = failure_of(certified(looks.world(n)), looks.scenario_of(n), fewest_steps=20_000)
        shapes.setdefault(looks.key[n], set()).add("-".join(failure.signature.split("-")[-2:]))
    assert len(shapes) > 2 and all(len(names) == 1 for names in shapes.values())


def test_the_budget_follows_the_way_unless_it_is_given():
    own = evaluate(scenes(100), Scenario("turn-left"), np.zeros(100, np.uint64), 0.005)
    long, short = own.ran & (own.way > 17), own.ran & (own.way < 8)
    assert (
        (own.budget[long] == 8000).all()
        and (own.budget[short] == 4000).all()
        and long.any()
        and short.any()
    )
    given_ = evaluate(scenes(9), Scenario("turn-left"), np.zeros(9, np.uint64), 0.015, 70)
    assert set(given_.budget.tolist()) <= {0, 70}


def _fragile(observation, memory, command):
    if observation[layout.OBS_BUMP] != 0.0:
        memory[int(observation[layout.OBS_X]) + 5] = 1.0
    command[layout.CMD_SPEED] = 2.0


def test_a_controller_that_raises_ends_only_its_own_run(monkeypatch):
    fragile = CompiledController("fragile", _fragile, senses=("bump", "x"))
    monkeypatch.setattr(CONTROLLERS, "get", lambda _: fragile)
    looks = evaluate(scenes(200), Scenario("fragile"), np.zeros(200, np.uint64), 0.015, 300)
    assert {"crash", "reached"} <= set(looks.verdict.tolist())
    n = int(np.flatnonzero(looks.verdict == "crash")[0])
    assert looks.steps[n] == run_of(looks, n).steps


def test_a_layout_is_a_scene_with_nothing_added():
    data = scenes(1)[0, :LAYOUT_BYTES].tobytes()
    assert (
        dumps(decode_scene(data))
        == dumps(decode_world(data))
        == dumps(decode_scene(data + bytes(3)))
    )


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"layouts": np.zeros((2, 5), np.uint8)}, {"code": "wrong-shape"}),
        ({"layouts": np.zeros((2, LAYOUT_BYTES))}, {"code": "wrong-shape"}),
        ({"seeds": np.zeros(3, np.uint64)}, {"code": "wrong-shape", "name": "seeds"}),
        ({"robot_radius": 0.16}, {"code": "robot-too-wide"}),
        ({"budget": 0}, {"code": "out-of-range"}),
        ({"scenario": Scenario("turn-left", RunOptions("stepped"))}, {"code": "not-native"}),
    ],
)
def test_what_cannot_be_looked_at_is_refused(changed, expected):
    given_ = {
        "layouts": scenes(2),
        "scenario": Scenario("turn-left"),
        "seeds": 0,
        "time_steps": 0.015,
        **changed,
    }
    with raises(InvalidParameter, **expected):
        evaluate(**given_)


def test_oracles_that_are_asked_for_judge_winding_runs():
    config = CampaignConfig(
        Scenario("turn-right"), seed=3, examples=20, families=("native",), oracles=("detour=3",)
    )
    result = run_unit(config, 0)
    by_oracle = [world for kind, world in result.failures.items() if "detour" in kind]
    assert by_oracle and all(replay(world).confirmed for world in by_oracle)
