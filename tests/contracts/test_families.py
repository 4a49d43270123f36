"""What every registered family promises, for each of its shapes."""

import dataclasses
import re
import sys
import types
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES, family, stream_for
from worldgen.files.grid import world_digest
from worldgen.generation import MAX_ATTEMPTS, generate
from worldgen.reach import check_certificate
from worldgen.testing import CHECKS, FAMILY_CHECKS, check_family
from worldgen.world import JointWitness, Pose, Target, Witness, World

DOCUMENT = Path(__file__).parents[2] / "docs" / "reference" / "families.md"

# For seed 7: the world's id without and with its witness, 16 digits each. If the first changes,
# users' seeds give different worlds: raise the family's version. If only the second changes, the
# prover has changed.
GOLDEN: dict[str, tuple[str, str]] = {
    "corridor-bends": ("3bd80277f1f51c05", "e6bd0baa5ee889ce"),
    "corridor-dead-ends": ("a4d80f26bca01fd0", "d819f6439eac2661"),
    "corridor-junctions": ("ce111378dabb882b", "d08300ac58758481"),
    "corridor-S": ("8c1ff862ab245ce7", "e19401a9e410655e"),
    "corridor-T": ("f07773da2d8dc3f1", "6b9696ebec9b36ea"),
    "corridor-X": ("bd62c40f9c116194", "ebbdc1c5d862ce29"),
    "corridor-tunnel": ("b5c9124014708440", "6d605a97903a38b7"),
    "fire-maze": ("85e03006e606b231", "566baf5b204b7a2a"),
    "fire-corridor": ("4cf5a8823775096e", "5b89ade9729bfcca"),
    "fire-trap": ("129820e1065071e8", "6457001266bd1e04"),
    "fire-cave": ("499090a63c4d4c1a", "8ff159f8b09890f1"),
    "fire-forest": ("d425a77283698481", "69b24402439a999f"),
    "fire-rooms": ("51e3b280b8010b12", "cc03441678506149"),
    "fire-rubble": ("5f2bd71914beb4ff", "1a8005982a714f29"),
    "forest-even": ("c70196d7f84ea9f0", "e1a90d9e18d6b5e2"),
    "forest-thickets": ("599186ed5b01c2b7", "161290c94602ac7c"),
    "forest-rows": ("c6acf33ef2f10e3d", "a5ab2184ec65e553"),
    "rubble-quake": ("45a6f289f5f5eee3", "85eec538300bc086"),
    "rubble-blast": ("f934bdf68df1edf4", "41f3aa86d2cd93a3"),
    "rubble-wing": ("0937c99bbcf4b0b6", "8bfc8e4c11f92959"),
    "shift-trap": ("39ed03026e164eaf", "fd6b9d558fb0a3c0"),
    "shift-corridor": ("7445d72521d3620f", "609ee55b847d50eb"),
    "shift-maze": ("107737634b8ea486", "69386e8904c656fd"),
    "shift-cave": ("53c9a668427c98bb", "380d7336d133a129"),
    "shift-forest": ("bef57ce12a439ad4", "3889b2f18febb366"),
    "shift-rooms": ("78e64753b7201773", "ffcd86a6644cb4e1"),
    "shift-rubble": ("3871cec2a9977891", "78631769485783e2"),
    "maze-wilson": ("502bb80046a9f524", "42e68eb0644acdd0"),
    "maze-aldous-broder": ("62064b5a74649fcb", "58637f9e73f427cb"),
    "maze-backtracker": ("ec3f05760ade6dc3", "f647469fb0177a34"),
    "maze-hunt-and-kill": ("f157d07f2e0b00f8", "222f140dec2865d8"),
    "maze-kruskal": ("765c5f7669ad5701", "1acbcc372e7db108"),
    "maze-prim": ("0a86a151efe3dad3", "07db463f13cb0916"),
    "maze-growing-tree": ("ea8fc50bdb88d21d", "20aea6039bd14c11"),
    "maze-eller": ("96998c4830aa080e", "8c80f4cd272edb09"),
    "maze-sidewinder": ("fe756001036e2972", "eb086ad306bed3a8"),
    "maze-binary-tree": ("4ddb1073a594e9a1", "d530b65ee9f5a84c"),
    "maze-recursive-division": ("1ee75187a79fa906", "dfda06c84127c344"),
    "cave-caverns": ("39338154b9cb2014", "aa5612ae0bd31dac"),
    "cave-columns": ("f550a79dc1e65f4c", "efe3035942d2ddf2"),
    "cave-galleries": ("c6d4debb1d523eba", "11b67c0a097293b2"),
    "rooms-wings": ("3d677cf08fa49d19", "ad228ffb4c2f488e"),
    "rooms-spine": ("64169410f424361d", "6cf72e2028aeb66c"),
    "rooms-suite": ("7371724514ca12ec", "feaf34ccc81bcc74"),
    "trap-U": ("c3ffafa58ff3c38d", "0ecc0d2db4154a1d"),
    "trap-L": ("027e5f248f623688", "63e399d9d9349506"),
    "trap-spiral": ("462108bdc4369fb9", "5e8373e8687314c8"),
    "trap-V": ("5d0babe3a6c72fa6", "255c2234142df3f2"),
    "trap-comb": ("08b78546e80267d7", "99dd29ca6f453ad2"),
    "trap-nested": ("7293fe14426ef3c1", "18a946c53c61e155"),
    "trap-pair": ("ca9c1a0044b0abb0", "192329b46facb4dd"),
    "doorway": ("204803fda2b7fc76", "dc428ca8fa8cea50"),
    "junction-X": ("789056e7d5a3ab94", "87ecf0effaa26f69"),
    "junction-T": ("8bfe91da583fe3dc", "a4be0030a9cadd56"),
    "alley": ("d7ec662a348f565c", "9d08361ae3035a00"),
    "crossing": ("66d1c495f7924dfc", "ecd3ebf1e2eb8930"),
    "warehouse": ("9b9861de2e0e161c", "9f6e3e7580099ae5"),
    "fire-alley": ("e8c5ce59351eb022", "6267396ad0225fc0"),
    "fire-crossing": ("8de8a15af5b6cbba", "30af69a340eafa5e"),
    "fire-doorway": ("e0b021322809b251", "ef87d73f1961d1be"),
    "fire-junction": ("c6c828173e621fbb", "cd9ccbc57e59d87f"),
    "fire-warehouse": ("049741f41a6d5966", "32bf71992e92d89d"),
    "shift-alley": ("45849a57213baa29", "54eaa812cb5a0951"),
    "shift-crossing": ("d43dff43f610280e", "4348710898429719"),
    "shift-doorway": ("64997bf7b875c573", "ffcd8233d8bd4fac"),
    "shift-junction": ("e78bd7032b3b2b36", "e9ea56824f18d73e"),
    "shift-warehouse": ("ce80b53440cee23b", "5431146ce930dfd1"),
}


STILL = [name for name in FAMILIES if not FAMILIES.get(name).changes]


def _shapes():
    """Every family with every choice of its first enumerated parameter, such as algorithm or shape.

    Or on every ground.
    """
    for name in FAMILIES:
        parameters = FAMILIES.get(name).parameters
        choices = {known.name: known.choices for known in parameters if known.choices}
        if any(known.name == "over" for known in parameters):
            choices = {"over": STILL}
        if not choices:
            yield pytest.param(name, {}, id=name)
        for first, words in list(choices.items())[:1]:
            for number, word in enumerate(words):
                yield pytest.param(
                    name,
                    {first: word},
                    id=f"{name}-{word}",
                    marks=[pytest.mark.gate] if number else [],
                )


# By default one shape of each family represents the others, which run in the gate; some tests cover
# them all together.
an_example_of_every_family = pytest.mark.parametrize(("name", "shape"), list(_shapes()))
an_example_of_every_constructed_family = (
    pytest.mark.parametrize(  # shift's cells move onto the path as well
        ("name", "shape"), [shape for shape in _shapes() if shape.values[0] != "shift"]
    )
)
every_shape = pytest.mark.parametrize(
    ("name", "shape"), [pytest.param(*one.values, id=one.id) for one in _shapes()]
)
every_family = pytest.mark.parametrize("name", FAMILIES.names())


@pytest.mark.gate
@pytest.mark.parametrize("check", CHECKS, ids=str)
@an_example_of_every_family
def test_every_shape_keeps_what_every_family_promises(name, shape, check):
    check(FAMILIES.get(name), shape)


@pytest.mark.gate
@pytest.mark.parametrize("check", FAMILY_CHECKS, ids=str)
@every_family
def test_every_family_keeps_what_every_family_promises(name, check):
    check(FAMILIES.get(name))


LARGE = {
    "trap": ("V", "comb", "pair")
}  # shapes that report that the smallest squares have no room for them


def made(name, seed, size, shape):
    """A world, or the error for a shape that is known to need more room."""
    if size < 16 and set(shape.values()) & set(LARGE.get(name, ())):
        with raises(InvalidParameter, "no-room", size=10):
            generate(name, seed, size=10, **shape)
        size = 16
    return generate(name, seed, size=size, **shape)


@pytest.mark.gate
@an_example_of_every_family
@pytest.mark.parametrize("size", [10, 11, 37, 60])
def test_size_is_the_number_of_cells_a_side(name, shape, size):
    world = made(name, 5, size, shape)
    assert world.walls.shape == (world.provenance.params["size"],) * 2


@an_example_of_every_family
@pytest.mark.parametrize("size", [10, 37])
def test_the_border_is_solid_for_ever(name, shape, size):
    world = made(name, 6, size, shape)
    size = world.width
    rim = [world.walls[0], world.walls[-1], world.walls[:, 0], world.walls[:, -1]]
    line = world.timeline
    assert all(side.all() for side in rim)
    assert ((line.ix > 0) & (line.ix < size - 1) & (line.iy > 0) & (line.iy < size - 1)).all()


@pytest.mark.gate
@an_example_of_every_family
@pytest.mark.parametrize(
    ("cell_size", "robot_radius"), [(0.1, 0.07), (0.1, 0.1), (0.25, 0.1), (0.05, 0.074)]
)
def test_the_independent_checker_accepts_the_witness(name, shape, cell_size, robot_radius):
    for seed in range(3):
        world = generate(
            name, seed, size=25, cell_size=cell_size, robot_radius=robot_radius, **shape
        )
        report = check_certificate(world)
        held = isinstance(world.certificate, Witness | JointWitness) and report.valid
        assert held, report.reason


@pytest.mark.gate
@an_example_of_every_constructed_family
def test_layouts_are_solvable_by_construction(name, shape):
    for seed in range(20):
        family_of = FAMILIES.get(name)
        first = family_of.build(stream_for(seed, name, 0), **family_of.complete(shape))
        assert np.array_equal(generate(name, seed, **shape).walls, first.walls)


@every_shape
def test_a_seed_yields_the_layout_and_the_witness_it_always_yielded(name, shape):
    world = generate(name, 7, **shape)
    layout = dataclasses.replace(world, certificate=None)
    key = "-".join([name, *shape.values()])
    assert (world_digest(layout)[:16], world_digest(world)[:16]) == GOLDEN[key]
    assert check_certificate(world).valid


@an_example_of_every_family
def test_coordinates_are_short_decimals(name, shape):
    world = generate(name, 9, **shape)
    for value in (
        world.start.x,
        world.start.y,
        world.target.x,
        world.target.y,
        world.target.radius,
    ):
        assert len(repr(value)) <= 5, value


@every_family
def test_an_unknown_parameter_is_refused(name):
    with raises(InvalidParameter, "unknown-name", name="sise"):
        generate(name, sise=30)


@every_family
def test_a_value_of_another_type_is_refused(name):
    for known in FAMILIES.get(name).parameters:
        wrong = 1 if isinstance(known.default, str | bool) else "1"
        with raises(InvalidParameter, "wrong-type"):
            generate(name, **{known.name: wrong})


@every_family
@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"size": 9}, {"code": "out-of-range", "name": "size", "value": 9, "low": 10}),
        ({"size": 20_001}, {"code": "out-of-range", "name": "size", "value": 20001, "low": 10}),
        (
            {"size": -(2**63)},
            {"code": "out-of-range", "name": "size", "value": -9223372036854775808},
        ),
        ({"cell_size": 10**400}, {"code": "too-large", "name": "cell_size"}),
        ({"size": 2**63}, {"code": "too-large", "name": "size"}),
        ({"cell_size": 0.0}, {"code": "out-of-range", "name": "cell_size", "low": 0.001}),
        ({"cell_size": float("nan")}, {"code": "not-finite", "name": "cell_size"}),
        ({"robot_radius": 0.0}, {"code": "out-of-range", "name": "robot_radius"}),
        ({"robot_radius": float("inf")}, {"code": "not-finite", "name": "robot_radius"}),
        ({"robot_radius": 1.5}, {"code": "no-room", "robot_radius": 1.5, "size": 30}),
        ({"robot_speed": -1.0}, {"code": "out-of-range", "name": "robot_speed", "low": 0.001}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_numbers_out_of_range_are_refused(name, params, expected):
    with raises(InvalidParameter, **expected):
        generate(name, **params)


@pytest.mark.gate
def test_a_family_that_never_solves_gives_up_and_names_its_parameters():
    @family("walled-in", version=1)
    def walled_in(rng, *, size: int = 12) -> World:
        walls = np.ones((size, size), bool)
        walls[2:4, 2:4] = walls[7:9, 7:9] = False
        return World(walls, Pose(0.3, 0.3), Target(0.8, 0.8, 0.05))

    with raises(
        GenerationFailed, "no-layout-found", family="walled-in", layouts=MAX_ATTEMPTS, seed=4
    ):
        generate(walled_in, 4)


def test_a_family_is_tried_again_until_a_layout_is_solvable():
    @family("lucky", version=3)
    def lucky(rng, *, size: int = 12) -> World:
        walls = np.zeros((size, size), bool)
        walls[5] = rng.below(4) > 0
        return World(walls, Pose(0.3, 0.3), Target(0.8, 0.8, 0.05))

    assert not any(generate(lucky, seed).walls[5].any() for seed in range(10))


@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (lambda rng, size=1: None, {"code": "wrong-declaration", "name": "size"}),
        (lambda rng, *, seed=1: None, {"code": "wrong-declaration", "name": "seed"}),
        (lambda rng, *, size: None, {"code": "wrong-declaration", "name": "size"}),
        (lambda rng, *, size=None: None, {"code": "wrong-declaration", "name": "size"}),
    ],
    ids=["positional", "taken", "no-default", "no-type"],
)
def test_a_family_of_ones_own_is_told_what_is_wrong_with_it(build, expected):
    with raises(InvalidParameter, **expected):
        family("own", version=1)(build)


@every_family
def test_the_document_includes_the_table_of_every_family(name):
    assert f"\n```{{include}} generated/parts/family-{name}.md\n" in DOCUMENT.read_text()


@pytest.mark.gate
@an_example_of_every_family
def test_several_robots_have_a_joint_witness_in_every_family(name, shape):
    alone = generate(name, 3, **shape | {"robots": 1})
    world = generate(name, 3, **shape | {"robots": 3})
    assert len(world.robots) == 3
    assert check_certificate(world).valid
    assert generate(name, 3, **world.provenance.params) == world
    assert not alone.is_fleet


@every_family
def test_more_robots_than_there_is_room_for_are_refused(name):
    with raises(InvalidParameter, "too-many-robots", robots=900):
        generate(name, 3, size=16, robots=900)


def test_the_family_in_the_document_works(monkeypatch):
    code = next(
        block
        for block in re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
        if "@family" in block
    )
    module = types.ModuleType("documented")
    monkeypatch.setitem(
        sys.modules, "documented", module
    )  # annotations are looked up in a function's module
    exec(code, vars(module))
    check_family(module.pillars)
    worlds = [generate(module.pillars, seed, pillars=40) for seed in range(5)]
    assert all(check_certificate(world).valid for world in worlds)


def test_an_annotation_that_cannot_be_found_is_told():
    def build(rng, *, size: int = 12) -> "Wurld":  # noqa: F821 - the mistake
        raise NotImplementedError

    with raises(InvalidParameter, "wrong-declaration", owner="family 'own'"):
        generate(family("own", version=1)(build))
