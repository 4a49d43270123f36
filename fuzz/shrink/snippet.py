"""A failure as a test that carries its world in its own text, ready to be pasted into a suite."""

from __future__ import annotations

import re
from dataclasses import replace

from fuzz.failure import scenario_of
from sim.run_options import RunOptions
from worldgen.grid_file import dumps
from worldgen.plain_text import shown
from worldgen.world import FailureRecord, Witness, World

__all__ = ["snippet"]

_MODULE = '''"""{title}."""
{imports}

FAILURE = loads(
    """\\
{text}""".encode()
)


def test_{name}_gets_over_this():
    assert fixed(FAILURE).reason == ""
'''
_IMPORTS = """
from fuzz.regression import fixed
from worldgen.grid_file import loads
"""
_EXAMPLE_IMPORTS = """
from hypothesis import example, given

from fuzz import worlds
from fuzz.regression import fixed
from sim import simulate
from worldgen.grid_file import loads
"""
_EXAMPLE = """

@given(world=worlds())
@example(world=FAILURE)
def test_{name}_arrives(world):
    assert simulate(world, {call}).verdict == "reached"
"""


def snippet(failure: World) -> str:
    """A module with a test that fails until the failure is fixed, and one for Hypothesis with the world as example.

    The second is left out where not to arrive is not the failure: where an oracle objects, and where the target is
    walled off.

    Args:
        failure: A world with a failure record.

    Raises:
        InvalidParameter: If it holds none.
    """
    record, options = scenario_of(failure)
    world = replace(failure, provenance=None, failure=replace(record, details={}))
    name = re.sub(r"\W+", "_", record.controller.rpartition(":")[2]).strip("_").lower() or "controller"
    title = f"{record.controller} under {record.motion}: {record.outcome}"
    text = dumps(world).decode("utf-8")
    has_example = "oracle" not in record.evidence and isinstance(failure.certificate, Witness)
    imports = (_EXAMPLE_IMPORTS if has_example else _IMPORTS).rstrip()
    made = _MODULE.format(title=_quoted(shown(title)), imports=imports, text=_quoted(text), name=name)
    return made + (_EXAMPLE.format(name=name, call=_call(record, options)) if has_example else "")


def _call(record: FailureRecord, options: RunOptions) -> str:
    """What ``simulate`` is called with, after the world."""
    settings = {"motion": record.motion, "seed": record.seed, **options.parameters()}
    del settings["steps"]  # each world has its own
    if settings["time_step"] == RunOptions.time_step:
        del settings["time_step"]
    return ", ".join([repr(record.controller), *(f"{name}={value!r}" for name, value in settings.items())])


def _quoted(text: str) -> str:
    """Text as it stands between three quotation marks."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
