"""Worlds of families whose target cannot be reached, with a proof, and sets with a share of them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import label

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps, world_digest
from worldgen.generation import generate
from worldgen.reach import BLOCKED, REACHABLE, check_certificate, decide
from worldgen.shutting import is_shut
from worldgen.world import Cut

SINGLE = [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
GOLDEN = {
    "cave": "bc6d5bdc5677",
    "corridor": "11bd1f16d238",
    "fire": "3818543e745b",
    "forest": "de292c7f0fc0",
    "maze": "db667cd8aae7",
    "rooms": "76d0f8fc395e",
    "rubble": "6cc3278fb4f3",
    "shift": "851e6e462a42",
    "trap": "2dae98c7e1b6",
}
CAR = {"drive": "car", "turning_radius": 0.2, "footprint": "0.2x0.12"}


def region(world, place):
    """The number of free cells that are joined to a place."""
    labels = label(~world.walls)[0]
    number = labels[int(place.y / world.cell_size), int(place.x / world.cell_size)]
    return np.count_nonzero(labels == number)


@pytest.mark.parametrize(
    "params",
    [
        pytest.param({}, id="disc"),
        pytest.param({"footprint": "0.2x0.1", "size": 40}, id="box", marks=pytest.mark.gate),
    ],
)
@pytest.mark.parametrize("family", SINGLE)
def test_a_blocked_world_has_a_cut_that_the_checker_accepts_and_needs_each_new_cell(family, params):
    # Where a layout has no room for a cut, another one is drawn, which the twin then lacks.
    seed = 1 if family == "fire" else 3
    params = params | ({"chance": 1.0} if family == "shift" else {})
    world = generate(family, seed, blocked=1.0, **params)
    assert isinstance(world.certificate, Cut) and check_certificate(world).valid
    assert min(region(world, world.start), region(world, world.target)) > 12
    twin = generate(family, seed, **params)
    assert (twin.start, twin.target) == (world.start, world.target)
    new = np.argwhere(world.walls & ~twin.walls)
    assert len(new) and not (twin.walls & ~world.walls).any()
    assert world.timeline == twin.timeline
    assert world.is_dynamic == FAMILIES.get(family).changes
    for row, column in new:
        assert not world.changing_cells[row, column]
        walls = world.walls.copy()
        walls[row, column] = False
        opened = replace(world, walls=walls, certificate=None)
        assert decide(opened, certificate=False).result == REACHABLE


@pytest.mark.gate
@pytest.mark.parametrize("family", SINGLE)
def test_many_blocked_worlds_have_valid_cuts(family):
    for seed in range(12):
        world = generate(family, seed, blocked=1.0)
        assert isinstance(world.certificate, Cut) and check_certificate(world).valid


@pytest.mark.gate
@pytest.mark.parametrize(
    "family",
    # A car's paths through a fire take seconds to find.
    [pytest.param(name, marks=[pytest.mark.nightly] if name == "fire" else []) for name in SINGLE],
)
def test_many_blocked_worlds_of_a_car_have_valid_cuts(family):
    for seed in range(12):
        world = generate(family, seed, blocked=1.0, **CAR)
        assert isinstance(world.certificate, Cut) and check_certificate(world).valid


def test_a_seed_gives_the_same_blocked_world_on_every_machine():
    digests = {name: world_digest(generate(name, 7, blocked=1.0))[:12] for name in GOLDEN}
    assert digests == GOLDEN


def test_a_share_blocks_seeds_evenly_and_leaves_the_others_as_they_were():
    for share in (0.1, 0.2, 0.5):
        for first in (0, 7, 10**9):
            count = sum(is_shut(seed, share) for seed in range(first, first + 40))
            assert abs(count - 40 * share) <= 1.5
    for seed in range(12):
        world = generate("maze", seed, blocked=0.3)
        assert isinstance(world.certificate, Cut) == is_shut(seed, 0.3)
        if not is_shut(seed, 0.3):
            same = generate("maze", seed)
            assert world_digest(world) == world_digest(same)
    assert dumps(generate("maze", 1, blocked=0.0)) == dumps(generate("maze", 1))


@pytest.mark.parametrize(
    ("family", "params", "code"),
    [
        ("maze", {"blocked": 1.5}, "out-of-range"),
        ("maze", {"blocked": 1.0, "robots": 2}, "not-for-fleets"),
        ("fire", {"blocked": 1.0, "robots": 2}, "not-for-fleets"),
        ("doorway", {"blocked": 1.0}, "unknown-name"),
    ],
)
def test_other_families_and_shares_are_refused(family, params, code):
    with raises(InvalidParameter, code):
        generate(family, 1, **params)


def test_a_world_too_small_for_a_cut_is_refused():
    with raises(GenerationFailed, "no-layout-found") as caught:
        generate("maze", 1, size=10, robot_radius=0.14, blocked=1.0)
    assert "room for a cut" in str(caught.value)


@pytest.mark.gate
def test_a_target_that_covers_every_layout_is_named_as_a_way_out():
    with raises(GenerationFailed, "no-layout-found") as caught:
        generate("maze", 1, size=12, blocked=1.0, target_radius=9.0)
    assert "a smaller target_radius" in str(caught.value)


def test_the_command_makes_one_or_a_share_of_a_set_which_can_be_made_again(tmp_path):
    done = worldgen("maze", "--blocked", "--seed", 7, "--json", "--out", tmp_path / "w.grid")
    assert json.loads(done.out)["result"] == BLOCKED
    folder = tmp_path / "set"
    worldgen("maze", "--blocked", "0.3", "--count", 10, "--seed", 1, "--out", folder)
    summary = worldgen("verify", folder).out
    assert "10 worlds: 7 reachable" in summary and "3 blocked" in summary
    assert worldgen("regenerate", folder, "--check").code == 0


def test_a_wrong_command_with_the_option_alone_is_corrected(tmp_path):
    done = worldgen("maze", "--blocked", "--robots", 2, "--seed", 1, "--out", tmp_path / "w.grid")
    assert (done.code, done.error_code) == (2, "not-for-fleets")
