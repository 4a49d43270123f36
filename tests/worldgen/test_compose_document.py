"""The statements in docs/howto/compose.md are true."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.files.grid import dumps, loads
from worldgen.generation import generate
from worldgen.reach import check_certificate
from worldgen.world import Provenance

TEXT = Path("docs/howto/compose.md").read_text()
EXAMPLE = "examples/compose/trap_in_maze.py"
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


def test_the_python_in_the_document_makes_proved_worlds():
    names = {}
    exec(BLOCKS[0], names)
    assert check_certificate(names["world"]).valid


def test_the_family_in_the_document_is_the_example():
    assert BLOCKS[1] == Path(EXAMPLE).read_text()
    world = generate(f"./{EXAMPLE}:trap_in_maze", 1)
    assert world.width == 60 and check_certificate(world).valid
    assert world.provenance.family == "trap-in-maze"


@pytest.mark.parametrize("name", ["recipe:gauntlet", "./gauntlet.toml"])
def test_a_recipe_makes_no_world_and_its_remedy_is_a_function(name):
    with raises(InvalidParameter, "recipe", name=name):
        generate(name, 1)
    done = worldgen("fire", "--over", name, "--seed", 1)
    assert done.code == 2 and "./file.py:name" in done.err


def test_a_set_of_a_recipe_is_refused_by_regenerate_in_one_sentence(tmp_path):
    assert worldgen("trap", "--seed", 1, "--count", 2, "--out", tmp_path / "s").code == 0
    manifest = tmp_path / "s" / "manifest.jsonl"
    manifest.write_text(manifest.read_text().replace('"family": "trap"', '"family": "recipe:old"'))
    done = worldgen("regenerate", manifest, "--out", tmp_path / "again")
    assert done.code == 2 and done.error_code == "recipe" and len(done.err.splitlines()) == 1


def test_a_world_that_a_recipe_made_is_read():
    made = generate("trap", 1, size=14)
    params = {"recipe": 'recipe = "old"\n', "made_with": {"trap": 3}, "files": {"a.grid": "x"}}
    world = replace(made, provenance=Provenance("recipe:old", 1, 3, params))
    assert loads(dumps(world)) == world
