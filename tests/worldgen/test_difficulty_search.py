"""Worlds with requested metrics are found by a search, not just drawn, and are ordinary worlds."""

import json

import pytest

from tests.helpers.command_line import worldgen as run
from tests.helpers.raising import raises
from worldgen.difficulty import measure, search_world
from worldgen.difficulty.model import INPUTS, WEIGHTS, difficulty
from worldgen.difficulty.search import Search, constraint_for
from worldgen.difficulty.space import KEPT, drawn, free_parameters, varied
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, read_world
from worldgen.generation import generate
from worldgen.random_streams import RandomStream
from worldgen.support.plain_text import alternatives
from worldgen.world import Cut


def test_the_world_found_is_as_constrained_and_generate_makes_it_again():
    world = search_world("maze", "detour > 2.5 and turns <= 40", seed=1, algorithm="backtracker")
    found = measure(world)
    assert found.detour > 2.5 and found.turns <= 40
    made = world.provenance
    assert made.params["algorithm"] == "backtracker"
    assert dumps(generate(made.family, made.seed, **made.params)) == dumps(world)


def test_equal_searches_find_equal_worlds():
    assert search_world("cave", "detour > 1.3", seed=5) == search_world(
        "cave", "detour > 1.3", seed=5
    )


def test_a_world_of_a_given_difficulty():
    assert measure(search_world("trap", difficulty=0.6, seed=2)).difficulty == pytest.approx(
        0.6, abs=0.025
    )


def test_guided_search_finds_what_drawing_does_not():
    constraint, maze = constraint_for("detour > 3 and bottleneck < 1.2r"), FAMILIES.get("maze")
    guided = Search(maze, constraint, 2, {})
    while guided.tried < 200 and not (guided.nearest and guided.nearest.violation == 0.0):
        guided.step()
    assert guided.nearest.violation == 0.0
    for seed in range(guided.tried):
        world = generate("maze", seed)
        found = measure(world, only=constraint.names).as_dict()
        assert constraint.violation(found, world.robot_radius) > 0.0


def test_what_is_given_stays_and_the_robot_stays():
    maze, rng = FAMILIES.get("maze"), RandomStream(1)
    free = free_parameters(maze, {"size", "braid"})
    assert {known.name for known in free}.isdisjoint({"size", "braid"} | KEPT)
    values = drawn(free, rng, 1.0)
    for _ in range(50):
        values = varied(free, values, rng)
        assert set(values) <= {known.name for known in free}


@pytest.mark.parametrize("family", ["fire", "shift"])
def test_a_difficulty_of_worlds_that_change_is_refused_at_once(family):
    with raises(InvalidParameter, "world-changes"):
        search_world(family, difficulty=0.5)


@pytest.mark.parametrize(
    ("constraint", "given", "code"),
    [
        ({"difficulty": 0.5}, {"blocked": 1.0}, "metric-of-paths"),
        ({"where": "solid > 0.1 and detour > 1"}, {"blocked": 0.3}, "metric-of-paths"),
        ({"difficulty": 0.5}, {"footprint": "0.3x0.2"}, "metric-of-discs"),
        ({"where": "bottleneck > 0"}, {"drive": "car", "turning_radius": 0.3}, "metric-of-discs"),
    ],
)
def test_a_metric_that_no_world_has_is_refused_at_once(constraint, given, code):
    with raises(InvalidParameter, code):
        search_world("maze", **constraint, **given, size=12)


CAR = {"drive": "car", "turning_radius": 0.3}
BODY = {"footprint": "0.3x0.2"}


@pytest.mark.parametrize(
    ("metric", "given", "others"),
    [
        ("concavity", CAR, ["detour"]),
        ("concavity", BODY, ["detour", "slack"]),
        ("concavity", BODY | CAR, ["detour", "slack"]),
        ("concavity", CAR | {"blocked": 1.0}, ["solid"]),
        ("detour", BODY | {"blocked": 1.0}, ["solid"]),
        ("detour", {"blocked": 1.0}, ["bottleneck", "bottleneck_radii", "solid"]),
    ],
)
def test_the_metrics_suggested_instead_are_those_that_the_robot_has(metric, given, others):
    with pytest.raises(InvalidParameter) as caught:
        search_world("maze", f"{metric} > 0", size=12, **given)
    assert caught.value.facts["others"] == alternatives(others)
    measured = measure(generate("maze", 1, size=14, cell_size=0.3, **given))
    assert set(others) <= measured.as_dict().keys()


def test_a_metric_of_the_map_finds_blocked_worlds():
    found = search_world("maze", "solid > 0.05 and bottleneck >= 0", blocked=1.0, size=12)
    assert isinstance(found.certificate, Cut)


def test_the_share_of_changing_cells_is_a_metric_of_blocked_worlds_too():
    Search(FAMILIES.get("shift"), constraint_for("changing > 0.01"), 1, {"blocked": 1.0})
    assert measure(generate("shift", 2, blocked=1.0)).changing > 0


def test_one_of_two_conditions_is_enough_where_the_other_has_no_metric():
    found = search_world("maze", "solid > 0.05 or detour > 99", blocked=1.0, size=12)
    assert isinstance(found.certificate, Cut)


def test_when_nothing_fits_the_nearest_is_told():
    with raises(GenerationFailed, "no-world-found", tries=5, constraint="detour > 900"):
        search_world("trap", "detour > 900", tries=5)


@pytest.mark.parametrize(
    ("constraint", "code"), [({}, "missing"), ({"difficulty": 2.0}, "out-of-range")]
)
def test_a_constraint_that_is_none_is_refused(constraint, code):
    with raises(InvalidParameter, code):
        search_world("trap", **constraint)


def test_a_parameter_that_the_family_never_takes_is_refused_at_once():
    with raises(InvalidParameter, "unknown-name", name="braid"):
        search_world("trap", "detour > 1", braid=1.0)


def test_the_command_writes_what_it_finds_and_says_how_to_make_it_again(tmp_path):
    path = tmp_path / "w.grid"
    result = run("trap", "--where", "concavity > 1m", "--seed", 4, "--out", path, "--json")
    assert result.code == 0
    found = json.loads(result.out)
    assert read_world(path).provenance.metrics["concavity"] > 1 and found["file"] == str(path)
    again = result.err.split("to make it again: worldgen ")[1].split()
    assert run(*again).out.encode() == path.read_bytes()


def test_the_command_ends_with_1_when_nothing_fits(tmp_path, monkeypatch):
    monkeypatch.setattr("worldgen.difficulty.search.TRIES", 3)
    result = run("trap", "--where", "detour > 900", "--seed", 4, "--out", tmp_path / "w.grid")
    assert result.code == 1 and "the nearest has detour" in result.err
    assert not (tmp_path / "w.grid").exists()


def test_count_gives_different_worlds_that_all_fit(tmp_path):
    run("corridor", "--where", "detour > 1.5", "--seed", 4, "--count", 3, "--out", tmp_path / "set")
    worlds = [read_world(file) for file in sorted((tmp_path / "set").glob("*.grid"))]
    assert len({dumps(world) for world in worlds}) == 3
    assert all(world.provenance.metrics["detour"] > 1.5 for world in worlds)


def test_a_constraint_with_a_fault_is_marked_and_corrected():
    result = run("maze", "--where", "detuor > 3", "--seed", 1)
    assert result.code == 2 and result.error_code == "unknown-name"
    _, came, mark, suggested = result.err.splitlines()
    assert (came, mark) == ("  detuor > 3", "  ^")
    assert suggested == "  worldgen maze --where 'detour > 3' --seed 1"


@pytest.mark.parametrize("name", INPUTS)
def test_what_should_make_a_world_harder_makes_it_more_difficult(name):
    assert WEIGHTS[name][1] > 0
    tables = [{**dict.fromkeys(INPUTS, 2.0), name: value} for value in (1.0, 1.5, 3.0, 50.0)]
    scores = [difficulty(table, 0.07) for table in tables]
    assert scores == sorted(scores) and 0.0 <= scores[0] < scores[-1] <= 1.0


@pytest.mark.parametrize(
    ("concavity", "detour", "radius", "number"),
    [
        (0.0, 1.0, 0.1, 0.15974440894568692),
        (1.0, 1.5, 0.1, 0.7560708216850298),
        (5.0, 9.0, 0.07, 0.8776638904276601),
    ],
)
def test_the_difficulty_of_known_metrics_is_the_published_number(concavity, detour, radius, number):
    assert difficulty({"concavity": concavity, "detour": detour}, radius) == number
