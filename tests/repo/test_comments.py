"""Functions explain their phases and reasons in comments on separate lines."""

import ast
import io
import re
import tokenize
from collections import defaultdict
from pathlib import Path

import pytest

from tests.repo.plain_english import readable_files

ROOT = Path(__file__).parents[2]
FOLDERS = ("worldgen", "sim", "fuzz", "worldgen_plugins", "build_tools", "benchmarks", "examples")

#: A function with more statements has phases, each with a comment above it.
MOST_STATEMENTS = 20
LEAST_COMMENTS = 2
#: Functions with more statements count as non-trivial code.
TRIVIAL_STATEMENTS = 8
#: Comment lines per 1,000 lines of such functions.
LEAST_DENSITY = 40
#: Packages with fewer lines of such code are too small for a meaningful rate.
LEAST_LINES = 500

_DIRECTIVE = re.compile(r"#\s*(type:|noqa|fmt:|pragma)")


def _statements(function: ast.AST) -> int:
    return sum(isinstance(node, ast.stmt) for node in ast.walk(function)) - 1


def _comment_lines(source: str) -> set[int]:
    lines = source.split("\n")
    return {
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
        and lines[token.start[0] - 1].lstrip().startswith("#")
        and not _DIRECTIVE.match(token.string)
    }


def _functions(source: str) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    return [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def uncommented(source: str) -> list[str]:
    """Return the long functions with too few comments, with their lines."""
    comments = _comment_lines(source)
    found = []
    for function in _functions(source):
        own = [line for line in comments if function.lineno <= line <= (function.end_lineno or 0)]
        if _statements(function) > MOST_STATEMENTS and len(own) < LEAST_COMMENTS:
            found.append(f"{function.lineno}: {function.name}")
    return found


def _lines_that_matter(source: str) -> tuple[set[int], set[int]]:
    """Return the lines of code and of comments in functions that are not trivial."""
    inside = set[int]()
    docstrings = set[int]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.update(range(node.lineno, (node.end_lineno or 0) + 1))
    for function in _functions(source):
        if _statements(function) > TRIVIAL_STATEMENTS:
            inside.update(range(function.body[0].lineno, (function.end_lineno or 0) + 1))
    comments = _comment_lines(source)
    full = {number for number, line in enumerate(source.split("\n"), 1) if line.strip()}
    return (full & inside) - comments - docstrings, comments & inside


def _package(name: str) -> str:
    parts = name.split("/")[:-1]
    return "/".join(parts[:2]) if parts[0] in ("worldgen", "sim", "fuzz") else parts[0]


_sources = [path for path in readable_files([*FOLDERS]) if path.suffix == ".py"]


def test_a_long_function_has_comments_above_its_phases():
    found = [
        f"{path.relative_to(ROOT)}:{place}"
        for path in _sources
        for place in uncommented(path.read_text("utf-8"))
    ]
    assert not found, "\n".join(found)


def test_a_package_explains_its_code():
    code = defaultdict[str, int](int)
    comments = defaultdict[str, int](int)
    bare = defaultdict[str, list[str]](list)
    for path in _sources:
        name = path.relative_to(ROOT).as_posix()
        lines, own = _lines_that_matter(path.read_text("utf-8"))
        code[_package(name)] += len(lines)
        comments[_package(name)] += len(own)
        if len(lines) > 10 and not own:
            bare[_package(name)].append(f"{name}:{min(lines)}")
    thin = [
        f"{package}: {1000 * comments[package] / lines:.0f} per 1,000; none in {bare[package]}"
        for package, lines in code.items()
        if lines >= LEAST_LINES and 1000 * comments[package] < LEAST_DENSITY * lines
    ]
    assert not thin, "\n".join(thin)


@pytest.mark.parametrize(("comments", "found"), [(0, ["1: f"]), (1, ["1: f"]), (2, [])])
def test_long_functions_without_comments_are_found(comments, found):
    lines = ["    x = 1"] * (MOST_STATEMENTS + 1)
    for number in range(comments):
        lines.insert(10 * number, "    # Next.")
    assert uncommented("def f():\n" + "\n".join(lines)) == found
