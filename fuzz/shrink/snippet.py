"""Write a failure as a test that contains its world, ready to paste into a test suite."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from fuzz.failure import Failure
from sim.controllers.programs.process import is_process_name
from sim.controllers.shared.object_file import is_library_name, library_file
from worldgen.files.grid import dumps
from worldgen.support.plain_text import shown, shown_lines

_MODULE = '''"""{title}."""

from fuzz.regression.checks import fixed
from worldgen.files.grid import loads

{comment}GRID = """\\
{text}"""
FAILURE = loads(GRID.encode())


def test_{name}_gets_over_this():
    assert fixed(FAILURE).reason == ""
'''
_RELATIVE = "# {controller} is relative to the folder in which pytest is started.\n"
# Characters of a test's name that are taken from the controller's name.
_LONGEST = 40


def snippet(failure: Failure) -> str:
    """Return a module with a test that fails until the failure is fixed.

    Args:
        failure: The failure to test.
    """
    record = failure.record
    world = replace(failure.stored, provenance=None, failure=replace(record, details={}))
    name = (
        re.sub(r"\W+", "_", record.controller.rpartition(":")[2]).strip("_").lower()[:_LONGEST]
        or "controller"
    )
    title = f"{failure.who}: {record.outcome}"
    text = dumps(world).decode("utf-8")
    comment = (
        _RELATIVE.format(controller=shown(record.controller))
        if _is_relative(record.controller)
        else ""
    )
    parts = {
        "title": _quoted(shown(title)),
        "comment": comment,
        # Its escapes are Python's own, so the text is the same, and no editor hides a part of it.
        "text": shown_lines(_quoted(text)),
        "name": name,
    }
    return _MODULE.format(**parts)


def _is_relative(controller: str) -> bool:
    """Return True if a controller's name depends on the current folder."""
    if is_process_name(controller):
        return re.search(r"(?<![^\s:])\./", controller) is not None
    if is_library_name(controller):
        return not library_file(controller).is_absolute()
    place = controller.rpartition(":")[0]
    return place.endswith(".py") and not place.startswith("~") and not Path(place).is_absolute()


def _quoted(text: str) -> str:
    """Return text escaped for use between triple quotes."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
