"""Limits that keep the sources easy to live in; ruff holds those on lines, statements and
parameters.
"""

import ast
import functools
from collections import Counter, defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("worldgen", "sim", "fuzz", "worldgen_plugins")

#: Limit on files and folders in one folder.
MOST_SIBLINGS = 22
MORE_SIBLINGS = {
    # There is one module per format, so this folder grows with the formats.
    "worldgen/interop/formats": 30,
    # The table of contents of a package: the nouns of ARCHITECTURE.md, and a folder for each part.
    **dict.fromkeys(("worldgen", "sim"), 25),
    "fuzz": 27,
}
#: `worldgen init` copies each of these files, so each contains a user's whole controller.
TEMPLATES = ("sim/controllers/examples/",)

_sources = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


@functools.cache
def _trees() -> dict[str, ast.AST]:
    """Return the syntax tree of each source, by the file's name."""
    return {
        path.relative_to(ROOT).as_posix(): ast.parse(path.read_text("utf-8")) for path in _sources
    }


def _names(node: ast.AST) -> set[str]:
    return {ast.unparse(part) for part in ast.walk(node) if isinstance(part, ast.Name)}


def packed_assignments(tree: ast.AST) -> list[int]:
    """Return the lines of tuple assignments such as ``a, b = 1, 2``, which do two things at once.

    One that reads what it assigns, such as ``a, b = b, a``, needs to be one statement.
    """
    return [
        node.lineno
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Tuple)
        and isinstance(node.value, ast.Tuple)
        and not _names(node.targets[0]) & _names(node.value)
    ]


def test_a_statement_makes_one_assignment():
    packed = [f"{name}:{line}" for name in _trees() for line in packed_assignments(_trees()[name])]
    assert packed == []


@pytest.mark.parametrize(
    ("source", "lines"),
    [("a, b = 1, 2", [1]), ("a, b = b, a", []), ("a, b = pair", []), ("a.x, a.y = a.y, a.x", [])],
)
def test_packed_assignments_are_found_and_swaps_are_not(source, lines):
    assert packed_assignments(ast.parse(source)) == lines


def test_a_class_name_has_one_meaning():
    places = defaultdict(list)
    for name, tree in _trees().items():
        if not name.startswith(TEMPLATES):
            for node in ast.walk(tree):
                if isinstance(node, ast.ClassDef):
                    places[node.name].append(f"{name}:{node.lineno}")
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_an_alias_of_a_type_has_no_class_s_name():
    classes = {
        node.name
        for name, tree in _trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and not name.startswith(TEMPLATES)
    }
    aliases = {
        f"{name}:{node.lineno}: {target.id}"
        for name, tree in _trees().items()
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name) and target.id in classes and not target.id.startswith("_")
    }
    assert aliases == set()


def test_a_folder_can_be_looked_over():
    # Sources in C and JavaScript count like Python's; every package has an __init__.py.
    kinds = ("*.py", "*.[ch]", "*.js")
    files = [
        file.relative_to(ROOT)
        for package in PACKAGES
        for kind in kinds
        for file in (ROOT / package).rglob(kind)
        if not file.name.startswith("__") and file.name != "_core.py"  # replaces compiled code
    ]
    folders = {folder for file in files for folder in file.parents}
    siblings = Counter(path.parent.as_posix() for path in (*files, *folders))
    crowded = {
        folder: count
        for folder, count in siblings.items()
        if count > MORE_SIBLINGS.get(folder, MOST_SIBLINGS)
    }
    assert crowded == {}
