"""Composed worlds: proved like every world, or refused in one sentence."""

from hypothesis import given, reject
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.compose import drawn, first_solvable, of_family, rectangle
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.reach import check_certificate
from worldgen.world import Witness

HOSTS, PARTS = ("trap", "rooms", "forest"), ("cave", "fire", "maze", "trap")


@given(st.sampled_from(HOSTS), st.sampled_from(PARTS), st.integers(0, 50), st.integers(0, 3))
def test_the_independent_checker_accepts_the_witness_of_a_composed_world(
    host, piece, seed, quarters
):
    def build(rng):
        part = of_family(piece, rng.child("piece"), size=14).rotate(quarters)
        return of_family(host, rng.child("host"), size=32).place(
            part.inside(), at="way", seed=rng.child("place")
        )

    try:
        world = first_solvable(build, seed)
    except (GenerationFailed, InvalidWorld):  # the piece may close the path in every layout
        reject()
    report = check_certificate(world)
    assert isinstance(world.certificate, Witness) and report.valid, report.reason


def test_a_trap_goes_into_a_maze_in_one_line():
    maze, trap = of_family("maze", seed=7, size=60), of_family("trap", seed=3, size=20).inside()
    world = maze.place(trap, at="way", seed=5).world()
    assert check_certificate(world).valid and (world.width, world.height) == (60, 60)


def test_fire_burns_in_its_part_of_the_world_alone():
    host, fire = of_family("rooms", 1, size=40), of_family("fire", 2, size=16)
    line = host.place(fire.inside(), at="upper-right").layout().timeline
    assert len(line) and line.ix.min() >= 25 and line.iy.min() >= 25


def test_a_world_that_cannot_be_solved_is_said_to_be_blocked_and_why():
    room = rectangle(9, 9).border().with_start(2, 2).with_target(9, 9)
    with raises(GenerationFailed, "not-reachable", result="blocked"):
        room.place(rectangle(11, 1, solid=True), at=(0, 5)).world()


def test_no_way_to_put_a_piece_on_is_said():
    walled = drawn("#######\n#..#..#\n#S.#.G#\n#..#..#\n#######")
    with raises(InvalidWorld, "not-reachable"):
        walled.place(rectangle(1, 1), at="way", seed=1)


def test_where_no_start_is_given_it_is_placed_far_from_the_target():
    world = rectangle(30, 6).border().with_target(3.5, 3.5).world()
    assert world.start.x > 2.5 and check_certificate(world).valid


def test_drawn_compositions_are_tried_until_one_can_be_solved():
    def build(rng):
        gate = rectangle(1, 3 + rng.below(2), solid=True)
        room = rectangle(12, 4).border().with_start(2, 3).with_target(12, 3)
        return room.place(gate.pad(0, 0, 0, 4 - gate.height, fill="free"), at=(6, 1)).for_robot(
            radius=0.04
        )

    assert not any(first_solvable(build, seed).walls[4, 6] for seed in range(6))


def test_a_composition_of_too_many_cells_is_not_drawn_again():
    drawings = []

    def build(rng):
        drawings.append(rng)
        return rectangle(5000, 5000)

    with raises(InvalidParameter, "too-large", what="a rectangle", width=5000, height=5000):
        first_solvable(build)
    assert len(drawings) == 1
