"""The stored failures of other people's controllers, without their packages.

tests/clients runs the controllers themselves.
"""

import ast
from pathlib import Path

import pytest

from worldgen import read_world
from worldgen.reach import check_certificate

FOLDER = Path(__file__).parents[2] / "examples" / "third-party"
FAILURES = sorted(FOLDER.glob("failures/*/*.grid"))


def classes(path: Path) -> set[str]:
    return {
        node.name
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
    }


@pytest.mark.parametrize("path", FAILURES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_stored_failure_can_be_reached_and_names_an_adapter_that_is_there(path):
    world = read_world(path)
    file, _, name = world.failure.controller.partition(":")
    assert name in classes(FOLDER.parents[1] / file)
    assert check_certificate(world, world.certificate).valid


def test_every_adapter_has_a_line_in_the_readme_and_all_but_the_planned_one_a_failure():
    readme = (FOLDER / "README.md").read_text()
    stored = {read_world(path).failure.controller.rpartition("/")[2] for path in FAILURES}
    adapters = {
        f"{path.name}:{name}"
        for path in FOLDER.glob("*.py")
        for name in classes(path)
        if not name.startswith("_")
    }
    assert adapters - stored == {"dynamic_window.py:PlannedWindow"} and not stored - adapters
    assert all(f"| `{name}` |" in readme for name in adapters)


def test_the_readmes_count_of_failures_is_theirs():
    assert f"`{len(FAILURES)} of {len(FAILURES)} confirmed`" in (FOLDER / "README.md").read_text()
