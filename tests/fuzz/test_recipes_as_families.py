"""A recipe is a campaign strategy like any family."""

from hypothesis import given

from fuzz.strategies import worlds
from worldgen.reach import check_certificate

RECIPE = "examples/recipes/trap-in-maze.toml"


@given(worlds(RECIPE, size=30, trap=12))
def test_worlds_of_a_recipe_are_drawn_with_their_witness(world):
    assert world.provenance.family == "recipe:trap-in-maze" and check_certificate(world).valid
