"""The cores in WebAssembly answer as the native ones do: paths, cuts, verdicts, digests, in Node."""

import json
import math
import random
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from fuzz.player.live import live_core, live_question, worker_script
from fuzz.triage.judging import repeatable
from sim import simulate
from sim._core import ffi
from sim.controllers.catalogue import CONTROLLERS, controller_of
from sim.controllers.core_act import CoreAct
from sim.evidence import LoopEvidence, evidence_table
from sim.options.run import options_from
from tests.helpers.page_scripts import FOLDER, missing_node
from worldgen import generate
from worldgen.errors import WorldgenError
from worldgen.lattice import lattice_to_metres
from worldgen.reach import check_certificate, decide
from worldgen.robot import Drive
from worldgen.world import Witness

pytestmark = pytest.mark.skipif(bool(missing_node()), reason=missing_node() or "-")

FAMILIES = ("corridor", "trap", "maze", "rooms", "cave", "forest", "rubble")
THESIS = ("turn-right", "turn-left", "turn-random")
IN_CORE = [
    name for name in CONTROLLERS if type(getattr(controller_of(name), "act", None)) is CoreAct
]
# A step of these takes up to a millisecond, natively, too.
SLOW = ("dynamic-window", "scan-mapper", "signal-mapper", "signal-three-layer")
ON_LATTICE = (
    {},
    {},
    {"slip": 0.1},
    {"odometry_noise": 0.05},
    {"sensor_noise": 0.2},
    {"drift": 0.05, "drift_heading": 1.0},
    {"beam_noise": 0.1, "beam_dropout": 0.05},
    {"turn_limit": 2.0, "acceleration": 1.0, "friction": 0.5},
    {"pushes": (1.5, 0.2, 0.0, 0.3)},
    {"push_places": (1.05, 1.05, 0.2, 0.0, 1.0)},
    {"signal": "weakened", "sensor_range": 1.0},
    {"decoys": (0.5, 0.5, 2.0)},
    {"wall_friction": 0.5},
)
STEPPED = (
    {},
    {},
    {"noise": True},
    {"slip": 0.2},
    {"arbiter": "A3"},
    {"keep_going": True},
    {"sensor_range": 66},
    {"acceleration": 2.0, "friction": 1.0},
    {"repair_slide": True},
    {"map_scale": 3},
    {"signal": "blocked", "sensor_noise": 0.1},
    {"draws": (0.5, 0.25)},
)


@pytest.fixture(autouse=True)
def cores():
    """The modules, which a checkout compiles when they are first wanted."""
    if live_core() is None:
        pytest.skip("no cores for pages: pip install ziglang")


def edited(rng, *, everything=True, families=FAMILIES):
    """A small world of some family, with cells flipped, and perhaps its ends moved."""
    while True:
        world = generate(rng.choice(families), rng.randrange(6))
        walls = world.walls.copy()
        for _ in range(rng.choice((0, 0, 3, 12, 40))):
            walls[rng.randrange(world.height), rng.randrange(world.width)] ^= True
        changes = {"walls": walls, "certificate": None}
        if everything or rng.random() < 0.3:
            changes["robot_radius"] = world.robot_radius * rng.choice((1, 1, 0.5, 1.3, 2, 0.37123))
        start = world.start
        target = world.target
        if rng.random() < 0.4:
            x, y = (on_lattice(rng, side, world) for side in (world.width, world.height))
            start = replace(start, x=x, y=y, heading=rng.uniform(-9, 9))
        if rng.random() < 0.2:
            start = replace(start, x=start.x + 0.00123)
        if rng.random() < 0.3:
            x, y = (on_lattice(rng, side, world) for side in (world.width, world.height))
            target = replace(target, x=x, y=y, radius=target.radius * rng.choice((1, 0.1, 3)))
        try:
            return world, replace(world, start=start, target=target, **changes)
        except WorldgenError:
            continue


def on_lattice(rng, cells, world):
    return lattice_to_metres(round(rng.random() * cells * 1024), world.cell_size)


def judged(questions):
    lines = "\n".join(json.dumps(question) for question in questions)
    command = ["node", FOLDER / "judge.mjs"]
    done = subprocess.run(
        command, input=lines, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return [json.loads(line) for line in done.stdout.splitlines()]


def proof_of(world):
    """Python's decision in the form of a page's."""
    decision = decide(world)
    reachable = {"reachable": True, "blocked": False}.get(decision.result)
    proof = {"reachable": reachable, "reason": decision.reason, "witness": None, "cut": None}
    found = decision.certificate
    if reachable:
        columns = {"t": found.times, "x": found.x, "y": found.y}
        proof["witness"] = {name: column.tolist() for name, column in columns.items()}
        proof["witness"]["clearance"] = found.clearance
        if found.headings is not None:
            proof["witness"]["heading"] = found.headings.tolist()
    elif reachable is False:
        proof["cut"] = {"cells": found.cells.tolist(), "clearance": found.clearance}
        if found.boxes is not None:
            proof["cut"]["boxes"] = found.boxes.tolist()
        if found.waypoint:
            proof["cut"]["waypoint"] = found.waypoint
    return proof


def with_a_body(rng, world):
    """The world with a footprint, or with waypoints, or both."""
    side = world.cell_size
    (robot,) = world.robots
    changes = {}
    if rng.random() < 0.7:
        ahead, behind, aside = (side * rng.choice((0.2, 0.45, 0.83, 1.4)) for _ in range(3))
        changes["footprint"] = ((ahead, aside), (-behind, aside), (-behind, -aside), (ahead, 0.0))
        if rng.random() < 0.4:
            heading, tolerance = rng.uniform(-4, 4), rng.choice((0.3, 1.0))
            changes["target"] = replace(robot.target, heading=heading, heading_tolerance=tolerance)
    if rng.random() < 0.6:
        changes["waypoints"] = tuple(
            replace(
                robot.target,
                x=rng.random() * world.width * side,
                y=rng.random() * world.height * side,
            )
            for _ in range(rng.choice((1, 2, 3)))
        )
    return replace(world, robots=[replace(robot, **changes)])


def with_a_car(rng, world):
    """The world with a car, which may have a footprint, reverse, or take time to steer."""
    side = world.cell_size
    (robot,) = world.robots
    drive = Drive(side * rng.choice((0.8, 1.5, 3)), rng.random() < 0.6, rng.choice((0.0, 0.0, 2.0)))
    changes = {"drive": drive}
    if rng.random() < 0.5:
        ahead, behind, aside = (side * rng.choice((0.2, 0.45, 0.83)) for _ in range(3))
        changes["footprint"] = (
            (ahead, aside),
            (-behind, aside),
            (-behind, -aside),
            (ahead, -aside),
        )
    if rng.random() < 0.3:
        changes["target"] = replace(robot.target, heading=rng.uniform(-4, 4), heading_tolerance=0.3)
    return replace(world, robots=[replace(robot, **changes)])


def answers_hold(seed, count, change=lambda rng, world: world, *, families=FAMILIES):
    """What a page says of worlds that it does not always decide.

    Each of its paths is one to the checker, which shares no code, and Python finds none where the
    page says that there is none.
    """
    worlds, found = proofs_in_pages(seed, count, change, families=families)
    for world, proof in zip(worlds, found, strict=True):
        if proof["reachable"]:
            assert check_certificate(replace(world, certificate=witness_in(proof))).valid
        elif proof["reachable"] is False:
            assert decide(world).result == "blocked"
    return [proof["reachable"] for proof in found]


def proofs_in_pages(seed, count, change, **how):
    """Edited worlds, each changed, and what a page proves of them."""
    rng = random.Random(seed)
    worlds = []
    while len(worlds) < count:
        try:
            worlds.append(change(rng, edited(rng, **how)[1]))
        except WorldgenError:
            continue
    answers = judged(
        {"world": live_question(world, None, None)["world"], "run": None, "edited": True}
        for world in worlds
    )
    return worlds, [answer["proof"] for answer in answers]


def proofs_agree(seed, count, change=lambda rng, world: world, *, all_equal=True):
    worlds, found = proofs_in_pages(seed, count, change)
    others = []
    for world, proof in zip(worlds, found, strict=True):
        expected = proof_of(world)
        if proof != expected:
            others.append(proof)
            assert proof["reachable"] == expected["reachable"]
            assert check_certificate(replace(world, certificate=witness_in(proof))).valid
    # Where a disc just fits at a waypoint off the lattice, a page may return to the start first.
    assert len(others) <= (0 if all_equal else count // 50)
    return [proof["reachable"] for proof in found]


def witness_in(proof):
    path = proof["witness"]
    columns = (np.array(path[name]) for name in ("t", "x", "y"))
    headings = np.array(path["heading"]) if "heading" in path else None
    return Witness(*columns, path["clearance"], headings)


def run_of(rng, *, record):
    """A question about an edited world with the recipe of the world before, and Python's episode."""
    while True:
        before, world = edited(rng, everything=False)
        decision = decide(world)
        if decision.result != "undecided":
            world = replace(world, certificate=decision.certificate)
        motion = rng.choice(("swept", "endpoint", "stepped"))
        name = rng.choice(THESIS if motion == "stepped" else IN_CORE)
        own = rng.choice(STEPPED if motion == "stepped" else ON_LATTICE)
        settings = {"motion": motion, "seed": rng.choice((0, 7, 2**63 + 5)), **own}
        if name in SLOW:
            settings["steps"] = 500
        try:
            options = options_from(world, None, settings)
            recipe = live_question(
                before, controller_of(name), options_from(before, None, settings)
            )
            episode = simulate(world, name, options, record=record)
        except WorldgenError:
            continue
        question = live_question(world, None, None)
        return (
            {"world": question["world"], "run": recipe["run"], "edited": name not in SLOW},
            episode,
            {"name": name, **settings, "budget": options.steps},
        )


def runs_agree(seed, count):
    rng = random.Random(seed)
    # Recording takes longer than the run, so one in five is enough to compare the paths.
    asked = [run_of(rng, record=k % 5 == 0) for k in range(count)]
    verdicts = set()
    for (question, episode, settings), answer in zip(
        asked, judged(question for question, _, _ in asked), strict=True
    ):
        run = answer["run"]
        assert run is not None, (settings, answer["live"])
        loops = isinstance(episode.evidence, LoopEvidence)
        expected = {
            "verdict": str(episode.verdict),
            "steps": episode.steps,
            "time": episode.time,
            "budget": settings["budget"],
            "entry": episode.evidence.entry if loops else -1,
            "period": episode.evidence.period if loops else 0,
            "digest": episode.trace_digest,
            "path_length": episode.path_length,
            "collisions": episode.collisions,
        }
        assert {name: run[name] for name in expected} == expected, settings
        evidence = json.loads(json.dumps(evidence_table(episode.evidence)))
        assert run["evidence"] == repeatable(evidence), settings
        if episode.trace is not None:
            trail_agrees(run["drawn"], episode, question["world"]["cell_size"])
        verdicts.add(expected["verdict"])
    return verdicts


def trail_agrees(drawn, episode, cell_size):
    """Every state that the page draws is a state of the run."""
    columns = {name: np.array(column) for name, column in drawn["open"].items() if column}
    whole = columns["at"] == np.floor(columns["at"])
    steps = columns["at"][whole].astype(int)
    assert steps[0] == 0 and steps[-1] == drawn["steps"] == episode.trace.steps
    trace = episode.trace
    assert columns["x"][whole] * cell_size == pytest.approx(trace.x[steps], abs=1e-9)
    assert columns["y"][whole] * cell_size == pytest.approx(trace.y[steps], abs=1e-9)
    turned = (columns["heading"][whole] - trace.heading[steps]) / (2 * math.pi)
    assert turned == pytest.approx(np.round(turned), abs=1e-9)
    assert (columns["bump"][whole] != 0).tolist() == trace.bump[steps].tolist()


def test_a_few_proofs_are_the_same():
    assert {True, False} <= set(proofs_agree(1, 12))


def test_a_few_proofs_for_bodies_and_waypoints_are_the_same():
    assert {True, False} <= set(proofs_agree(1, 16, with_a_body))


def test_a_few_runs_are_the_same():
    assert "loop" in runs_agree(1, 12)


@pytest.mark.gate
def test_300_proofs_are_the_same():
    found = proofs_agree(2, 300)
    # None is left to Python.
    assert min(found.count(True), found.count(False)) > 100 and found.count(None) == 0


@pytest.mark.gate
def test_300_proofs_for_bodies_and_waypoints_are_the_same():
    found = proofs_agree(2, 300, with_a_body, all_equal=False)
    # Few bodies fit so closely that Python leaves them undecided, too.
    assert min(found.count(True), found.count(False)) > 80 and found.count(None) < 4


@pytest.mark.gate
def test_paths_of_30_cars_hold():
    found = answers_hold(1, 30, with_a_car)
    # A page gives up earlier than Python, and it has no proof that a car cannot arrive though its
    # body can.
    assert found.count(True) >= 9 and found.count(False) >= 6 and found.count(None) <= 11


@pytest.mark.gate
def test_proofs_of_40_worlds_that_change_hold():
    found = answers_hold(1, 40, families=("fire", "shift"))
    # The rest depends on the times of the changes.
    assert found.count(True) >= 8 and found.count(False) >= 4 and found.count(None) <= 24


@pytest.mark.gate
def test_300_runs_are_the_same():
    assert {"reached", "loop", "stalled", "timeout", "tunnel"} <= runs_agree(2, 300)


def test_structs_without_pointers_are_laid_out_as_native_ones():
    """Only a pointer's size differs; the compiler itself has put the offsets into the modules."""
    script = """
        import { readFileSync } from "node:fs";
        import { openCore } from "#player/live/core.js";
        const core = await openCore(readFileSync("sim/_core.wasm"));
        const wanted = JSON.parse(readFileSync(0, "utf8"));
        const found = Object.entries(wanted).map(([struct, fields]) =>
          [struct, [core.size(struct), ...fields.map((field) => core.offset(struct, field))]]);
        console.log(JSON.stringify(Object.fromEntries(found)));
    """
    native = {}
    for struct in (
        "WgState",
        "WgEvent",
        "WgPush",
        "WgPathPoint",
        "WgThesisSettings",
        "WgThesisRow",
    ):
        fields = dict(ffi.typeof(struct).fields)
        native[struct] = [ffi.sizeof(struct), *(field.offset for field in fields.values())]
    wanted = {struct: [name for name, _ in ffi.typeof(struct).fields] for struct in native}
    done = subprocess.run(
        ["node", "--input-type=module", "-e", script],
        input=json.dumps(wanted),
        cwd=FOLDER.parents[1],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert json.loads(done.stdout) == native, done.stderr


def test_the_worker_is_one_script_that_node_can_read(tmp_path):
    script = tmp_path / "worker.js"
    script.write_text(worker_script(), encoding="utf-8")
    done = subprocess.run(["node", "--check", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "import" not in script.read_text("utf-8").split("WebAssembly")[0]
