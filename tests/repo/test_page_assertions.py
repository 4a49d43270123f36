"""Tests of pages wait for what they claim, because a page answers later than mouse and keyboard."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
FILES = sorted([*TESTS.glob("browser/*.py"), *TESTS.glob("helpers/*.py")])

# Methods of Playwright that read the page at one moment, and the expectations that wait.
WAITING = {
    "inner_text": "to_have_text or to_contain_text",
    "all_inner_texts": "to_have_text with a list",
    "text_content": "to_have_text or to_contain_text",
    "all_text_contents": "to_have_text with a list",
    "count": "to_have_count",
    "input_value": "to_have_value",
    "get_attribute": "to_have_attribute",
    "is_visible": "to_be_visible",
    "is_hidden": "to_be_hidden",
    "is_checked": "to_be_checked",
    "is_enabled": "to_be_enabled",
    "is_disabled": "to_be_disabled",
    "is_editable": "to_be_editable",
}
ARGUMENTS = {"get_attribute": 1}


def momentary(source: str) -> list[str]:
    """Return the assertions that read a page once, with what to write instead."""
    found = {}
    for statement in ast.walk(ast.parse(source)):
        if not isinstance(statement, ast.Assert):
            continue
        for call in ast.walk(statement.test):
            match call:
                case ast.Call(func=ast.Attribute(attr=name), args=args) if name in WAITING:
                    # A list's count() has an argument, a locator's has none.
                    if len(args) == ARGUMENTS.get(name, 0):
                        found[call.lineno, name] = WAITING[name]
    return [
        f"line {line}: {name}() is read once; use expect(...).{waiting}, which waits"
        for (line, name), waiting in sorted(found.items())
    ]


def test_no_assertion_reads_a_page_at_one_moment():
    found = {path.name: momentary(path.read_text("utf-8")) for path in FILES}
    assert {name: said for name, said in found.items() if said} == {}


@pytest.mark.parametrize(
    "source",
    [
        'assert "arrow keys" in page.locator("#said").inner_text()',
        'assert [one.is_visible() for one in page.locator("p").all()] == [True]',
        'assert page.locator("p").first.get_attribute("class") == "ran"',
        'def test():\n    assert not page.locator("p").count(), "a paragraph"',
    ],
)
def test_an_assertion_that_reads_a_page_at_one_moment_is_found(source):
    (said,) = momentary(source)
    assert "which waits" in said


def test_what_waits_and_what_reads_no_page_is_left_alone():
    source = 'expect(page.locator("p")).to_have_count(2)\nassert words.count("a") == 2\n'
    assert momentary(source) == []
