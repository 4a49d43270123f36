"""Name the lines of a controller's file that never ran in any world of a campaign."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import groupby

from sim.controllers import CONTROLLERS
from sim.controllers.lines_run import watch_lines
from worldgen.plugins.counted_code import CodeFunction, LineWatch
from worldgen.support.plain_text import shown


def unrun_lines(controller: str, ran: Collection[int]) -> list[str]:
    """Return the lines of a controller's file that never ran: ``41-44 (recover)``.

    A function is listed only if code that ran mentions its name. Others in the file may belong to
    another controller, or are not used in the simulator.

    Args:
        controller: Name of the controller.
        ran: First lines of the statements that ran; empty if that is not known.
    """
    code = watch_lines(CONTROLLERS.get(controller), frozenset(ran)) if ran else None
    if code is None:
        return []
    own = _by_function(code)
    has_run = {one for one, lines in own.items() if any(line in ran for line in lines)}
    named = {name for one in has_run for name in one.names}
    return [
        f"{lines} ({shown(function.name)})"
        for function, starts in own.items()
        if function in has_run or function.name in named
        for lines in _without(code, starts, ran)
    ]


def _by_function(code: LineWatch) -> dict[CodeFunction, list[int]]:
    """Return the first lines of the statements of each function, without those inside it."""
    found: dict[CodeFunction, list[int]] = {}
    for line in sorted(code.statements):
        around = [one for one in code.functions if one.first <= line <= one.last]
        # Functions are in order, so the innermost comes last.
        if around:
            found.setdefault(around[-1], []).append(line)
    return found


def _without(code: LineWatch, starts: list[int], ran: Collection[int]) -> Iterator[str]:
    """Yield the ranges of lines whose statements never ran."""
    for has_run, group in groupby(starts, key=lambda line: line in ran):
        if not has_run:
            lines = [*group]
            last = max(code.statements[lines[-1]])
            yield str(lines[0]) if last == lines[0] else f"{lines[0]}-{last}"
