"""The statements in docs/howto/compose.md are true."""

import re
from pathlib import Path

from worldgen.compose.cells import HOW
from worldgen.compose.recipe import family_from_recipe
from worldgen.compose.recipe_text import SOURCES, VERBS
from worldgen.generation import generate
from worldgen.reach import check_certificate

TEXT = Path("docs/howto/compose.md").read_text()


def test_the_python_in_the_document_makes_proved_worlds():
    for block in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        names = {}
        exec(block, names)
        assert check_certificate(names["world"]).valid


def test_the_recipe_in_the_document_is_the_example():
    text = re.search(r"```toml\n(.*?)```", TEXT, re.DOTALL)[1]
    assert text == Path("examples/recipes/trap-in-maze.toml").read_text()
    assert generate(family_from_recipe(text), 1).width == 60


def test_the_document_names_every_way_every_source_and_every_step():
    for word in (
        *HOW,
        *SOURCES,
        *VERBS,
        *(option for options in VERBS.values() for option in options),
    ):
        assert f"`{word}`" in TEXT or f"`{word} = " in TEXT, word
