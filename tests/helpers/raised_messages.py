"""The errors and messages that the packages raise, read from their sources."""

import ast
import functools
from pathlib import Path

PACKAGES = ("worldgen", "worldgen_plugins", "sim", "fuzz")
ROOT = Path(__file__).parents[2]
BASE = "WorldgenError"


def _nodes() -> list[tuple[Path, ast.ClassDef | ast.Call]]:
    """Return all classes and calls of the packages, and their files."""
    paths = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
    return [
        (path.relative_to(ROOT), node)
        for path in paths
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ClassDef)
        or (isinstance(node, ast.Call) and isinstance(node.func, ast.Name))
    ]


@functools.cache
def raised_messages() -> list[tuple[str, ast.Call]]:
    """Return the calls that make errors or messages of codes and templates, and their places."""
    nodes = _nodes()
    bases = {
        node.name: {ast.unparse(base) for base in node.bases}
        for _, node in nodes
        if isinstance(node, ast.ClassDef)
    }
    made = {"Message", "Note", BASE}
    while more := {name for name, above in bases.items() if above & made} - made:
        made |= more
    return [
        (f"{path}:{node.lineno}", node)
        for path, node in nodes
        if isinstance(node, ast.Call)
        and ast.unparse(node.func) in made
        and path != Path("worldgen/errors.py")
    ]
