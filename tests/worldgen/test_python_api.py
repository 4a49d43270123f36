"""What a programmer sees in a Python session:

listed names, callable families, and representations of worlds.
"""

from __future__ import annotations

import importlib
import inspect
import pydoc
from importlib.metadata import version

import numpy as np
import pytest

import worldgen
from tests.helpers.raising import raises
from worldgen import Cut, Provenance, World, families, generate, stream, world_digest
from worldgen.errors import InvalidParameter
from worldgen.families import maze, trap
from worldgen.family import FAMILIES, Bounds, Family, family
from worldgen.random_streams import seed_of

PACKAGES = (
    "worldgen",
    "worldgen.difficulty",
    "worldgen.families",
    "worldgen.reach",
    "worldgen.render",
    "sim",
    "fuzz",
)


@pytest.fixture(scope="module")
def small():
    return maze(seed=7, size=12)


@pytest.mark.parametrize("name", PACKAGES)
def test_dir_lists_the_public_names_and_nothing_else(name):
    package = importlib.import_module(name)
    # Modules of worldgen that need no separate import.
    modules = ["compose", "families", "interop", "render", "testing"] if name == "worldgen" else []
    public = [word for word in dir(package) if not word.startswith("__")]
    assert public == sorted([*package.__all__, *modules])
    assert all(getattr(package, word).__name__ == f"worldgen.{word}" for word in modules)


@pytest.mark.parametrize("name", PACKAGES)
def test_every_public_name_can_be_had(name):
    package = importlib.import_module(name)
    assert all(getattr(package, word) is not None for word in package.__all__)


@pytest.mark.parametrize("name", PACKAGES)
def test_the_docstring_lists_every_public_name(name):
    package = importlib.import_module(name)
    assert [word for word in package.__all__ if word not in package.__doc__] == []


def test_a_name_that_a_package_lacks_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'sim' has no attribute 'simulat'"):
        _ = importlib.import_module("sim").simulat


def test_the_version_is_that_of_the_installation():
    assert worldgen.__version__ == version("worldgen")


def test_a_family_that_is_called_gives_the_world_of_generate(small):
    assert small == generate("maze", 7, size=12)


@pytest.mark.parametrize("name", FAMILIES.names())
def test_every_registered_family_is_in_the_package(name):
    assert getattr(families, name.replace("-", "_")) is FAMILIES.get(name)


def test_a_family_of_another_package_is_there_under_a_name_that_python_takes(monkeypatch):
    monkeypatch.setattr(FAMILIES, "names", lambda: ["my-maze"])
    monkeypatch.setattr(FAMILIES, "get", lambda name: {"my-maze": trap}[name])
    assert families.my_maze is trap and "my_maze" in dir(families)


def test_a_signature_shows_types_bounds_and_units():
    shown = str(inspect.signature(maze))
    assert "size: typing.Annotated[int, '10 to 20000 cells'] = 30" in shown
    assert "passage: typing.Annotated[int | None, 'at least 1 cell'] = None" in shown
    assert shown.startswith("(seed: int = 0, *, ")


def test_help_explains_the_parameters_that_a_caller_gives():
    text = pydoc.plain(pydoc.render_doc(maze))
    assert "Cells per side, including the solid border.  [10 to 20000 cells]" in text
    assert "seed: " in text and "rng" not in text


def test_help_on_a_family_whose_function_says_nothing_lists_its_parameters():
    @family("mute", version=1)
    def mute(rng, *, width: int = 3) -> World:
        raise NotImplementedError

    assert mute.__doc__.startswith("Args:\n") and "\n    width:" in mute.__doc__


def test_the_class_of_families_has_a_signature_of_its_own():
    assert list(inspect.signature(Family).parameters)[:3] == ["name", "version", "build"]


@pytest.mark.parametrize("seed", [np.int64(7), np.uint64(7), np.int16(7)])
def test_numpy_integers_are_seeds(seed, small):
    assert maze(seed, size=12) == small


def test_numpy_numbers_are_parameters(small):
    assert maze(7, size=np.int32(12), braid=np.float32(0)) == small


def test_a_numpy_generator_is_a_seed_by_the_bits_that_numpy_promises():
    assert seed_of(np.random.default_rng(7)) == 0xAF266A95F1E54A8B


def test_a_numpy_generator_moves_on():
    rng = np.random.default_rng(7)
    assert seed_of(rng) != seed_of(rng)


def test_provenance_has_the_number_that_a_generator_gave():
    number = seed_of(np.random.Generator(np.random.MT19937(3)))
    world = maze(np.random.Generator(np.random.MT19937(3)), size=12)
    assert world.provenance.seed == number and world == maze(number, size=12)


def test_a_stream_begins_with_the_seed_of_a_generator():
    first = next(stream("maze", np.random.default_rng(1), size=12))
    assert first == maze(np.random.default_rng(1), size=12)


@pytest.mark.parametrize("seed", ["7", 7.0, None, True])
def test_what_is_no_seed_is_refused(seed):
    with raises(InvalidParameter, "wrong-type", seed=seed):
        maze(seed)


def test_none_has_the_family_choose_and_files_hold_their_own_number(small):
    world = maze(7, size=12, passage=None, newest=None)
    assert world == small
    assert (
        world.provenance.params["passage"] == -1
        and repr(world.provenance.params["newest"]) == "-1.0"
    )


def test_none_is_refused_where_the_family_has_nothing_to_choose():
    with raises(InvalidParameter, "wrong-type", name="size"):
        maze(7, size=None)


def test_parameters_as_a_file_holds_them_make_the_same_world(small):
    assert maze(small.provenance.seed, **small.provenance.params) == small


def test_a_number_out_of_bounds_is_told_to_be_left_out():
    with raises(InvalidParameter, "below-minimum", name="passage") as caught:
        Bounds(1, chosen=-1).check("passage", 0)
    assert "-1" not in str(caught.value)


def test_a_world_is_one_line(small):
    assert repr(small) == (
        "<World maze seed 7: 12 x 12 cells of 0.1 m, start (0.95, 0.25), target (0.25, 0.95), "
        "witness of 1.673 m>"
    )


def test_a_world_says_in_its_line_what_its_certificate_is(small):
    from dataclasses import replace

    assert "no certificate" in repr(replace(small, certificate=None))
    cut = Cut(np.array([[0, 0], [1, 0]]), 0.0)
    assert "cut of 2 cells" in repr(
        replace(small, certificate=cut, provenance=Provenance("mine", 1, 3))
    )


def test_a_world_knows_its_digest(small):
    assert small.digest == world_digest(small)


def test_a_notebook_shows_a_world_as_a_picture(small):
    assert small._repr_png_().startswith(b"\x89PNG")
