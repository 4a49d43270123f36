"""A campaign on a user's own map draws windows around narrow places, and variations of the map."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from fuzz.boundary.axes import AXES, Subject
from fuzz.campaign.unit import run_unit
from fuzz.layouts.map_variations import MapVariations, variations_of
from fuzz.layouts.map_windows import Kind, Windows, describe_tried, kind_of
from fuzz.layouts.narrow_places import Ground, narrow_places
from fuzz.unit.config import CampaignConfig
from fuzz.unit.pace import Pace
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen.files.grid import dumps, read_world, write_world
from worldgen.generation import generate
from worldgen.interop.format.foreign_map import origin_of
from worldgen.random_streams import RandomStream
from worldgen.reach import REACHABLE, check_certificate, decide
from worldgen.render.caption import facts
from worldgen.world import Pose, Provenance, Target, World

CELL = 0.1
RADIUS = 0.2
# Two rooms of 8 x 6 m, with doors of 1 m at 2 m and 6 m, and a cupboard in the upper room.
DOORS = ((2.0, 3.0), (6.0, 7.0))


def office() -> World:
    walls = np.zeros((121, 80), bool)
    walls[60] = True
    for left, right in DOORS:
        walls[60, round(left / CELL) : round(right / CELL)] = False
    walls[90:95, 30:38] = True
    return World(
        walls,
        Pose(1.05, 1.05),
        Target(7.05, 11.05, 0.1),
        CELL,
        RADIUS,
        0.5,
        provenance=Provenance("import", 3, 0, {"format": "ros", "origin": [-4.0, 2.5]}),
    )


@pytest.fixture(scope="module")
def variations() -> MapVariations:
    return variations_of(office(), step=0.05)


def drawn(variations: MapVariations, kind: Kind, count: int = 20) -> list[World]:
    """Return worlds of a kind, without the plain windows that were drawn in their place."""
    worlds = [variations.draw(kind, RandomStream(seed)) for seed in range(count)]
    return [world for world in worlds if world and kind_of(world, office()) == kind]


def on_the_map(world: World) -> tuple[int, int]:
    """Return the first row and column of a window on the map, by its origin."""
    x, y = origin_of(world)
    return round((y - 2.5) / CELL), round((x + 4.0) / CELL)


def differing(world: World) -> np.ndarray:
    """Return the cells (row, column) of the map that a window has otherwise."""
    row, column = on_the_map(world)
    before = office().walls[row : row + world.height, column : column + world.width]
    return np.argwhere(before != world.walls) + np.array((row, column))


def test_doors_are_the_narrow_places_and_corners_are_not():
    ground = Ground.of(office().walls, Fraction(2))
    places = narrow_places(ground, 2.0)
    in_wall = [(one.column, one.clearance) for one in places if abs(one.row - 121) <= 1]
    assert sorted(in_wall) == [(50, 10.0), (130, 10.0)]
    # The others are between the cupboard and the walls around it.
    assert all(one.row >= 180 for one in places if abs(one.row - 121) > 1)


def test_a_gap_that_the_robot_does_not_fit_through_is_no_narrow_place():
    places = narrow_places(Ground.of(office().walls, Fraction(6)), 6.0)
    assert all(one.row > 180 for one in places)


def test_an_open_map_has_no_narrow_place_and_its_variations_are_still_drawn():
    empty = World(np.zeros((80, 80), bool), Pose(1.0, 1.0), Target(6.0, 6.0, 0.1), CELL, RADIUS)
    variations = MapVariations(Windows(empty, 0.05))
    assert variations.draw(Kind.WINDOW, RandomStream(1)) is None
    box = variations.draw(Kind.BOX, RandomStream(1))
    assert box is not None and kind_of(box, empty) == Kind.BOX


@pytest.mark.parametrize("kind", [kind for kind in Kind if kind is not Kind.POSE])
def test_each_kind_has_a_witness_and_the_robot_of_the_map(variations, kind):
    worlds = drawn(variations, kind)
    assert len(worlds) >= 8
    for world in worlds:
        assert check_certificate(world).valid
        assert (world.robot_radius, world.robot_speed) == (RADIUS, 0.5)
        assert world.target.radius == 0.1


def test_a_window_is_the_map_itself_with_the_ends_on_two_sides_of_a_door(variations):
    for world in drawn(variations, Kind.WINDOW):
        assert not len(differing(world))
        row, _ = on_the_map(world)
        ends = [row * CELL + y for y in (world.start.y, world.target.y)]
        assert min(ends) < 6.0 and max(ends) > 6.1
        assert 20 <= world.certificate.length / 0.05 <= 80


def test_a_closed_door_takes_the_robot_through_the_other_one(variations):
    for world in drawn(variations, Kind.DOOR):
        cells = differing(world)
        assert world.walls.sum() > 0 and set(cells[:, 0]) <= {59, 60, 61}
        assert len(set(cells[:, 1])) >= 10
        assert world.certificate.length > 4.0
        assert "door closed at (" in world.provenance.changed[0]


def test_a_box_and_a_person_are_as_large_as_they_are_said_to_be(variations):
    for world in drawn(variations, Kind.BOX):
        width, height = sides(world)
        cells = differing(world)
        assert len(cells) <= (width / CELL + 1) * (height / CELL + 1)
    for world in drawn(variations, Kind.PERSON):
        cells = differing(world)
        assert np.ptp(cells, axis=0).max() + 1 <= 2 * 0.3 / CELL + 1
        assert "person of radius 0." in world.provenance.changed[0]


def sides(world: World) -> tuple[float, float]:
    words = world.provenance.changed[0].split()
    return float(words[2]), float(words[4])


def test_a_moved_piece_keeps_its_shape(variations):
    for world in drawn(variations, Kind.PIECE):
        assert world.provenance.changed[0].startswith(
            "piece of the walls of 0.8 x 0.5 m at (3, 9) m moved by ("
        )
        row, column = on_the_map(world)
        if row <= 84 and column <= 24 and row + world.height >= 101 and column + world.width >= 44:
            assert world.walls[84 - row : 101 - row, 24 - column : 44 - column].sum() == 40


def test_a_map_without_pieces_yields_windows_in_their_place():
    walls = office().walls.copy()
    walls[90:95, 30:38] = False
    bare = replace(office(), walls=walls, provenance=office().provenance)
    world = MapVariations(Windows(bare, 0.05)).draw(Kind.PIECE, RandomStream(3))
    assert kind_of(world, bare) == Kind.WINDOW


def test_the_same_stream_draws_the_same_world(variations):
    again = MapVariations(Windows(office(), 0.05))
    for kind in Kind:
        first, second = (one.draw(kind, RandomStream(7).child(kind)) for one in (variations, again))
        assert dumps(first) == dumps(second)


def test_only_the_part_of_a_huge_map_around_its_start_is_examined(monkeypatch):
    monkeypatch.setattr("fuzz.layouts.map_windows._LONGEST_SIDE", 70)
    variations = MapVariations(Windows(office(), 0.05))
    for seed in range(20):
        world = variations.draw(Kind.BOX, RandomStream(seed))
        assert world is None or on_the_map(world)[0] < 70


def test_pictures_say_what_was_changed(variations):
    (box, *_) = drawn(variations, Kind.BOX)
    assert "import, seed 0; box of " in facts(box) and "; window of " in facts(box)


def test_a_variation_of_a_familys_world_names_the_family():
    world = generate("rooms", 3, size=60)
    window = variations_of(world, 0.03).draw(Kind.WINDOW, RandomStream(1))
    made = window.provenance
    assert (made.family, made.params["from"]) == ("map", "rooms")
    assert made.changed[0].startswith("window of ")


def test_a_failure_that_is_searched_again_keeps_what_was_changed_before(variations):
    (box, *_) = drawn(variations, Kind.BOX, 3)
    window = MapVariations(Windows(box, 0.05)).draw(Kind.BOX, RandomStream(2))
    assert window is not None
    assert window.provenance.changed[: len(box.provenance.changed)] == box.provenance.changed
    assert kind_of(box, box) == Kind.POSE


@pytest.mark.parametrize(("axis", "value"), [("radius", 0.15), ("speed", 0.4), ("heading", 10.0)])
def test_a_world_at_a_boundary_keeps_what_was_changed_on_the_map(variations, axis, value):
    (box, *_) = drawn(variations, Kind.BOX)
    moved = AXES[axis].at(Subject(box, Scenario("turn-left")), value).world
    assert moved != box and moved.provenance == box.provenance


def test_kinds_are_counted_in_words():
    assert (
        describe_tried({"box": 2, "pose": 1, "door": 1})
        == "1 pose, 1 door closed, 2 boxes put down"
    )


def config(**changes) -> CampaignConfig:
    return CampaignConfig(
        Scenario("turn-left").with_run(time_step=0.1), fixed_map=office(), examples=40, **changes
    )


def test_a_unit_counts_every_world_that_it_tried():
    result = run_unit(config(), 1)
    assert sum(result.tried.values()) == result.worlds
    assert set(result.tried) == set(Kind)
    assert result == run_unit(config(), 1)


def test_a_slow_controller_begins_with_windows_and_every_kind_of_variation():
    slow = config(measured=Pace(1e-3))
    first = run_unit(slow, 0)
    assert first.strategy == "small" and first == run_unit(slow, 0)
    tried = sum((run_unit(slow, unit).tried for unit in range(8)), Counter())
    assert set(tried) == set(Kind) - {"pose"}


def test_several_robots_only_get_other_poses():
    result = run_unit(replace(config(), robots=2, examples=10), 1)
    assert set(result.tried) == {"pose"}


@pytest.mark.gate
def test_failures_on_a_map_say_which_variation_they_come_from(tmp_path):
    write_world(office(), tmp_path / "office.grid")
    out = tmp_path / "f"
    result = worldgen(
        "fuzz", "--controller", "turn-left", "--world", tmp_path / "office.grid", "--units", 1,
        "--examples", 40, "--seed", 1, "--workers", 1, "--out", out,
    )  # fmt: skip
    assert result.code == 1 and "\ntried on the map: " in result.out
    changed = [read_world(file).provenance.changed for file in out.glob("*.grid")]
    assert any(changed)
    file = next(file for file in out.glob("*.grid") if read_world(file).provenance.changed)
    for command in ("show", "explain"):
        assert read_world(file).provenance.changed[0] in worldgen(command, file).out
    assert worldgen("replay", out).code == 0


@pytest.mark.gate
def test_a_shrunk_variation_keeps_the_robot_and_is_a_failure_still(tmp_path):
    write_world(office(), tmp_path / "office.grid")
    out = tmp_path / "f"
    worldgen(
        "fuzz", "--controller", "turn-left", "--world", tmp_path / "office.grid", "--units", 1,
        "--examples", 40, "--seed", 2, "--workers", 1, "--shrink", "--out", out,
    )  # fmt: skip
    worlds = [read_world(file) for file in out.glob("*.grid")]
    assert worlds and worldgen("replay", out).code == 0
    for world in worlds:
        assert decide(world).result == REACHABLE and world.robot_radius in (0.2, 0.15, 0.1)
        assert world.robot_speed == 0.5 and world.target.radius == 0.1
