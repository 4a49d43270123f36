"""The statements in docs/howto/compose.md are true."""

import re
from pathlib import Path

from worldgen.generation import generate
from worldgen.reach import check_certificate

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
