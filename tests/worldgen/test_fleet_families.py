"""Worlds of several robots on the command line: made, measured, shown, composed, regenerated."""

import hashlib
import json
from dataclasses import replace

import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.compose import of_family
from worldgen.difficulty import measure
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import CROWD_PLANNER_VERSION, FAMILIES, PLANNER_VERSION, family
from worldgen.files.grid import dumps, read_world
from worldgen.generation import generate
from worldgen.random_streams import RandomStream
from worldgen.reach import UNDECIDED, check_certificate, decide
from worldgen.reach.joint import placing, plan, question
from worldgen.render import draw_svg
from worldgen.support.progress import Work, display_on_stderr
from worldgen.world import World


def test_a_world_of_one_robot_has_the_bytes_that_it_always_had():
    assert dumps(generate("maze", 7, robots=1)) == dumps(generate("maze", 7))
    assert "robots" not in generate("maze", 7).provenance.params


def test_robots_are_in_provenance_and_make_the_world_again():
    world = generate("rooms", 7, robots=4)
    assert world.provenance.params["robots"] == 4
    assert generate("rooms", 7, **world.provenance.params) == world


@pytest.mark.parametrize("name", ["rooms", "doorway"])
def test_a_world_of_several_robots_names_the_planner_that_made_it(name):
    world = generate(name, 7, robots=2)
    params = world.provenance.params
    assert params["planner"] == PLANNER_VERSION and generate(name, 7, **params) == world
    with raises(InvalidParameter, code="other-version"):
        generate(name, 7, **{**params, "planner": PLANNER_VERSION + 1})
    alone = generate(name, 7, robots=1).provenance.params
    assert "planner" not in alone
    with raises(InvalidParameter, code="unknown-name"):
        generate(name, 7, **{**alone, "planner": PLANNER_VERSION})


# By planner version, the digest of some worlds with their witnesses. If it changes on purpose,
# raise PLANNER_VERSION and add the new digest.
PLANNED = {1: "30c224c69c5498fb"}


# By version of the planner for crowds, the digest of some worlds with their witnesses. If it
# changes on purpose, raise CROWD_PLANNER_VERSION and add the new digest.
CROWDS = {2: "12d8e7280407ed75"}


def test_what_places_crowds_has_a_version():
    digest = hashlib.sha256()
    for name in ("rooms", "cave", "warehouse"):
        digest.update(dumps(generate(name, 0, robots=16)))
    assert digest.hexdigest()[:16] == CROWDS[CROWD_PLANNER_VERSION]


@pytest.mark.gate
@pytest.mark.parametrize("name", ["maze", "rooms", "fire", "crossing"])
def test_a_crowd_is_placed_with_a_path_for_each_robot_and_made_again(name):
    world = generate(name, 3, robots=24, size=60)
    params = world.provenance.params
    assert params["planner"] == CROWD_PLANNER_VERSION and generate(name, 3, **params) == world
    assert len(world.certificate.paths) == 24 and check_certificate(world).valid


@pytest.mark.gate
def test_too_many_robots_are_told_how_many_have_paths():
    with raises(InvalidParameter, code="no-joint-paths") as caught:
        generate("maze", 3, robots=60, size=30)
    assert 10 < caught.value.facts["placed"] < 60


def test_a_search_of_a_crowd_that_could_rearrange_it_endlessly_gives_up(monkeypatch):
    monkeypatch.setattr(placing, "FEW_ROBOTS", 1000)
    monkeypatch.setattr(plan, "_QUICK_ORDERS", 1)
    alone = replace(generate("cave", 0, size=60), certificate=None)
    crowd = placing.place_robots(alone, RandomStream(0), 100, "cave")
    assert decide(crowd, cut=False).result == UNDECIDED


def test_a_crowd_that_leaves_no_room_is_placed_again(monkeypatch):
    monkeypatch.setattr(placing, "MOST_TOGETHER", 0)
    tried = []

    def one_by_one(*args):
        tried.append(args)
        if len(tried) == 1:
            raise placing._too_many("rooms", 5, 16)
        return really(*args)

    really = placing._one_by_one
    monkeypatch.setattr(placing, "_one_by_one", one_by_one)
    world = generate("rooms", 0, robots=16)
    assert len(tried) == 2 and check_certificate(world).valid
    # It is the first layout.
    assert (world.walls == generate("rooms", 0).walls).all()


def test_a_crowd_whose_last_legs_conflict_is_decided_by_the_joint_search(monkeypatch):
    monkeypatch.setattr(placing.Crowd, "witness", lambda *_: None)
    world = generate("rooms", 3, robots=12, size=60)
    assert len(world.certificate.paths) == 12 and check_certificate(world).valid


@pytest.mark.parametrize("name", ["cave", "crossing"])
def test_a_world_that_is_too_large_for_a_crowd_is_not_called_too_small(name, monkeypatch):
    monkeypatch.setattr(question, "_MOST_NODES", 1000)
    monkeypatch.setattr(placing, "_places", None)
    with raises(InvalidParameter, code="too-large", few=10, width=30):
        generate(name, 0, robots=11)


@pytest.mark.parametrize("name", ["cave", "warehouse"])
def test_placing_a_crowd_says_which_robot_it_places(name, monkeypatch):
    monkeypatch.setattr(placing, "MOST_TOGETHER", 16)
    shown = []
    with display_on_stderr() as display:
        monkeypatch.setattr(
            Work, "say", lambda work, detail: work in display._works and shown.append(detail)
        )
        generate(name, 0, robots=16)
    assert {f"robot {number}" for number in range(2, 17)} <= set(shown)


def walled_up(rng: RandomStream, size: int) -> World:
    """Return a maze with the witness that it had before a wall divided it."""
    maze = FAMILIES.get("maze")(rng.below(100), size=size)
    walls = maze.walls.copy()
    walls[:, size // 2] = True
    return replace(maze, walls=walls)


def test_a_witness_of_another_world_does_not_count():
    @family("fenced", version=1)
    def fenced(rng: RandomStream, *, size: int = 16) -> World:
        """Build a maze and wall it up."""
        return walled_up(rng, size)

    with raises(GenerationFailed, code="no-layout-found"):
        fenced(3)


def test_a_world_with_a_proof_that_it_is_blocked_is_not_reachable():
    @family("cut", version=1)
    def cut(rng: RandomStream, *, size: int = 16) -> World:
        """Build a maze that is walled up."""
        blocked = replace(walled_up(rng, size), certificate=None)
        return replace(blocked, certificate=decide(blocked).certificate)

    with raises(GenerationFailed, code="no-layout-found"):
        cut(3)


def test_a_family_of_ones_own_may_say_that_it_has_no_room_in_its_own_way():
    @family("full", version=1)
    def full(rng: RandomStream, *, robots: int = 2) -> World:
        """Build nothing."""
        raise InvalidParameter("too-many-robots", "no room for {robots}", robots=robots)

    with raises(InvalidParameter, code="too-many-robots", robots=20):
        full(3, robots=20)


@pytest.mark.gate
def test_what_places_robots_and_plans_for_them_has_a_version():
    digest = hashlib.sha256()
    for name in ("rooms", "cave", "maze", "corridor", "doorway", "warehouse"):
        for seed in range(3):
            digest.update(dumps(generate(name, seed, robots=3, size=20)))
    assert digest.hexdigest()[:16] == PLANNED[PLANNER_VERSION]


def test_a_set_says_that_another_planner_made_it(tmp_path, monkeypatch):
    made = worldgen(
        "rooms", "--count", "2", "--seed", "3", "--robots", "2", "--size", "16",
        "--out", str(tmp_path / "set"),
    )  # fmt: skip
    assert made.code == 0
    monkeypatch.setattr("worldgen.family.PLANNER_VERSION", PLANNER_VERSION + 1)
    again = worldgen("regenerate", str(tmp_path / "set"), "--out", str(tmp_path / "again"))
    assert again.code == 2 and "planner is '1', but here it is '2'" in again.err


def test_the_first_robot_is_placed_as_ever():
    alone = generate("cave", 7)
    world = generate("cave", 7, robots=3)
    assert (world.start, world.target) == (alone.start, alone.target)
    assert (world.walls == alone.walls).all()


def test_a_narrow_corridor_is_made_wide_enough_for_two():
    world = generate("corridor", 7, robots=2)
    assert check_certificate(world).valid
    assert world.provenance.params["width"] == -1


def test_every_family_has_the_option(tmp_path):
    for name in FAMILIES:
        assert "--robots" in worldgen(name, "--help").out


def test_a_set_of_fleets_is_made_again(tmp_path):
    made = worldgen(
        "doorway", "--count", "2", "--seed", "3", "--robots", "3", "--size", "16",
        "--out", str(tmp_path / "set"),
    )  # fmt: skip
    assert made.code == 0
    assert worldgen("regenerate", str(tmp_path / "set"), "--check").code == 0
    again = worldgen("regenerate", str(tmp_path / "set"), "--out", str(tmp_path / "again"))
    assert again.code == 0


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--robots", "0"], "1 to 1000"),
        (["--robots", "300", "--size", "12"], "robots fit, not robots="),
        (["--robots", "1001"], "1 to 1000"),
    ],
)
def test_a_wrong_number_of_robots_is_a_line_and_a_corrected_command(options, word):
    done = worldgen("maze", "--seed", "1", *options)
    assert done.code == 2
    rule, *suggested = done.err.splitlines()
    assert word in rule and all(line.startswith("  worldgen maze") for line in suggested)


def test_verify_says_how_many_robots_it_decided(tmp_path):
    file = str(tmp_path / "w.grid")
    assert worldgen("junction", "--seed", "2", "--out", file).code == 0
    answer = json.loads(worldgen("verify", file, "--json").out)
    assert (answer["result"], answer["certificate_valid"], answer["robots"]) == (
        "reachable",
        True,
        2,
    )
    larger = json.loads(worldgen("verify", file, "--radius", "0.09", "--json").out)
    assert (larger["result"], larger["decided"]) == ("reachable", True)
    assert worldgen("verify", file, "--widest").code == 2


def test_show_tells_of_all_robots(tmp_path):
    file = str(tmp_path / "w.grid")
    worldgen("alley", "--seed", "2", "--out", file)
    facts = json.loads(worldgen("show", file, "--json").out)
    assert len(facts["robots"]) == 2 and facts["certificate"] == "witness"
    drawing = worldgen("show", file).out
    assert "1-2 starts  A-B their targets" in drawing
    assert "robot 2" in draw_svg(read_world(file))


def test_metrics_are_those_of_the_robot_that_has_it_hardest():
    world = generate("alley", 2)
    found = measure(world)
    paths = world.certificate.paths
    assert found.robots == 2
    assert any(found.length == pytest.approx(path.length, rel=1e-5) for path in paths)
    assert measure(generate("alley", 2, robots=1)).robots is None


def test_a_piece_of_a_world_is_a_map_without_other_robots():
    assert of_family("doorway", RandomStream(1)).solid.shape == (30, 30)
    assert of_family("maze", RandomStream(1), robots=3).solid.shape == (30, 30)
    with raises(InvalidParameter, "unknown-name"):
        generate("maze", 1, over="doorway")


@pytest.mark.parametrize("name", ["doorway", "junction", "alley", "crossing", "warehouse"])
@pytest.mark.parametrize("size", [10, 60])
def test_families_of_fleets_work_at_all_sizes(name, size):
    for seed in range(4):
        assert check_certificate(generate(name, seed, size=size)).valid
