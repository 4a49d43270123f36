"""Every error that a user can cause is raised as a code, templates and facts.

Programs can read it.
"""

import ast
import re
import string
from collections.abc import Iterable, Iterator

import pytest

from tests.helpers.raised_messages import raised_messages

KEBAB = "[a-z0-9]+(-[a-z0-9]+)*"
IN_FILES = {"FormatError", "NotAGrid"}
OPTION = r"(?<![\w-])--(?!flag\b)[a-z][a-z-]*"  # --flag is an option of a user's program
COMMAND = r"`worldgen [a-z-]+|(?<![\w`./])worldgen (?:fuzz|run|replay|studio|verify|show|import)\b"
OF_A_TERMINAL = f"{OPTION}|{COMMAND}"
# A call that returns an error's line and file: ``**header.at("start")``.
PLACE = re.compile(r"(.*\.)?at(_the_end)?\(.*\)")
READ = {"needs"}  # options that the corrected command adds
PLACES = {"line", "source"}  # for an error in a file: keywords that are not facts


def _texts(node: ast.expr) -> list[str] | None:
    """Return every text that an expression can be, or None if that cannot be determined without
    running it.
    """
    if isinstance(node, ast.Constant):
        return [str(node.value)]
    if isinstance(node, ast.IfExp):
        one, other = _texts(node.body), _texts(node.orelse)
        return None if one is None or other is None else one + other
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _texts(node.left), _texts(node.right)
        return None if left is None or right is None else [a + b for a in left for b in right]
    return None


def _fields(template: str) -> set[str]:
    """Return the facts that a template has, those in its format specifications too."""
    found = set()
    for _, field, spec, _ in string.Formatter().parse(template):
        if field is not None:
            found.add(re.split(r"[.\[]", field)[0])
            found |= _fields(spec or "")
    return found


def _faults(messages: Iterable[tuple[str, ast.Call]]) -> Iterator[str]:
    for place, call in messages:
        if not 2 <= len(call.args) <= 3:
            yield f"{place}: give a code, a problem and perhaps a remedy"
            continue
        codes = _texts(call.args[0]) or []
        yield from (
            f"{place}: {code!r} is not a code" for code in codes if not re.fullmatch(KEBAB, code)
        )
        problems, remedies = (
            _texts(call.args[1]),
            [""] if len(call.args) == 2 else _texts(call.args[2]),
        )
        yield from (
            f"{place}: a problem names {option[0]}, an option of the command line; name it in the "
            f"remedy"
            for problem in problems or ()
            if (option := re.search(r"(?<![\w-])--[a-z][\w-]*", problem))
        )
        if not any(keyword.arg == "at_terminal" for keyword in call.keywords):
            yield from (
                f"{place}: a remedy names {named[0]!r}, so say at_terminal=True"
                for remedy in remedies or ()
                if (named := re.search(OF_A_TERMINAL, remedy))
            )
        more = [ast.unparse(keyword.value) for keyword in call.keywords if keyword.arg is None]
        if problems is None or remedies is None or not all(map(PLACE.fullmatch, more)):
            continue
        no_facts = {"at_terminal"} | (PLACES if ast.unparse(call.func) in IN_FILES else set())
        facts = {keyword.arg for keyword in call.keywords if keyword.arg is not None} - no_facts
        used = {field for template in problems + remedies for field in _fields(template)}
        yield from (f"{place}: no fact is called {name}" for name in sorted(used - facts))
        yield from (f"{place}: no template says {name}" for name in sorted(facts - used - READ))


def test_every_error_has_a_code_and_templates_that_say_its_facts():
    assert list(_faults(raised_messages())) == []


def test_the_packages_raise_errors_that_this_file_sees():
    assert len(raised_messages()) > 500


@pytest.mark.parametrize(
    "written",
    [
        'InvalidParameter(f"size={size} is below 10; give more")',
        'InvalidParameter("Too small", "size={size} is below 10", size=size)',
        'InvalidParameter("too-small", "size={size} is below {low}", size=size)',
        'InvalidParameter("too-small", "the size is too small", size=size)',
        'InvalidParameter("too-small", "--size is too small")',
        'InvalidParameter("too-small", "the size is too small", "give --size 10")',
    ],
)
def test_a_message_that_breaks_the_rules_is_seen(written):
    call = ast.parse(written, mode="eval").body
    assert list(_faults([("here:1", call)]))
