"""Write a failure as a test that contains its world, ready to paste into a test suite."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from fuzz.failure import Failure
from sim.controllers.programs.process import is_process_name
from sim.controllers.shared.object_file import is_library_name, library_file
from sim.options.run import RunOptions
from worldgen.files.grid import dumps
from worldgen.support.plain_text import shown
from worldgen.world import FailureRecord, Witness

__all__ = ["snippet"]

_MODULE = '''"""{title}."""
{imports}

{comment}GRID = """\\
{text}"""
FAILURE = loads(GRID.encode())


def test_{name}_gets_over_this():
    assert fixed(FAILURE).reason == ""
'''
_IMPORTS = """
from fuzz.replay.regression import fixed
from worldgen.files.grid import loads
"""
_EXAMPLE_IMPORTS = """
from hypothesis import example, given

from fuzz import worlds
from fuzz.replay.regression import fixed
from sim import simulate
from worldgen.files.grid import loads
"""
_EXAMPLE = """

@given(world=worlds())
@example(world=FAILURE)
def test_{name}_arrives(world):
    episode = {call}
    assert episode.verdict == "reached"
"""
_RELATIVE = "# {controller} is relative to the folder in which pytest is started.\n"
_WIDTH = 88  # columns; the default of formatters, which leave lines of this width unchanged
_LONGEST = 40  # characters of a test's name that are taken from the controller's name


def snippet(failure: Failure) -> str:
    """Return a module with a test that fails until the failure is fixed.

    A second test, for Hypothesis, uses the world as an example. It is omitted if arriving is not
    what matters: if an oracle found the failure, or if the target is walled off.

    Args:
        failure: The failure to test.
    """
    record = failure.record
    options = failure.options
    world = replace(failure.stored, provenance=None, failure=replace(record, details={}))
    name = (
        re.sub(r"\W+", "_", record.controller.rpartition(":")[2]).strip("_").lower()[:_LONGEST]
        or "controller"
    )
    title = f"{record.controller} under {record.motion}: {record.outcome}"
    text = dumps(world).decode("utf-8")
    # A property "the robot arrives" only makes sense if arriving is what failed.
    has_example = failure.oracle is None and isinstance(failure.world.certificate, Witness)
    imports = (_EXAMPLE_IMPORTS if has_example else _IMPORTS).rstrip()
    comment = (
        _RELATIVE.format(controller=shown(record.controller))
        if _is_relative(record.controller)
        else ""
    )
    parts = {
        "title": _quoted(shown(title)),
        "imports": imports,
        "comment": comment,
        "text": _quoted(text),
        "name": name,
    }
    return _MODULE.format(**parts) + (
        _EXAMPLE.format(name=name, call=_call(record, options)) if has_example else ""
    )


def _is_relative(controller: str) -> bool:
    """Return True if a controller's name depends on the current folder."""
    if is_process_name(controller):
        return re.search(r"(?<![^\s:])\./", controller) is not None
    if is_library_name(controller):
        return not library_file(controller).is_absolute()
    place = controller.rpartition(":")[0]
    return place.endswith(".py") and not place.startswith("~") and not Path(place).is_absolute()


def _call(record: FailureRecord, options: RunOptions) -> str:
    """Return the call of ``simulate`` as formatters write it.

    It takes one line, or one line per argument.
    """
    settings = {"motion": record.motion, "seed": record.seed, **options.parameters()}
    del settings["steps"]  # each world has its own budget
    if settings["time_step"] == RunOptions.time_step:
        del settings["time_step"]
    arguments = [
        "world",
        _literal(record.controller),
        *(f"{name}={_literal(value)}" for name, value in settings.items()),
    ]
    line = f"simulate({', '.join(arguments)})"
    if len(f"    episode = {line}") <= _WIDTH:
        return line
    return "\n".join(["simulate(", *(f"        {one}," for one in arguments), "    )"])


def _literal(value: object) -> str:
    """Return a value as a Python literal, with double quotes unless the text contains them."""
    text = repr(value)
    if not isinstance(value, str) or text.startswith('"') or '"' in value:
        return text
    return f'"{text[1:-1]}"'


def _quoted(text: str) -> str:
    """Return text escaped for use between triple quotes."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
