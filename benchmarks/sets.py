"""Measure how fast sets are made, on one core.

``python -m benchmarks.sets``; ``--json`` prints one object. For each family it measures worlds per
second: made and discarded (``stream``), written as a folder and as a zip file, and measured as well.
The ratio is to ``stream`` in the same run; it shows what writing and measuring cost. ``--count`` is
the number of worlds of each case (default 2,000). Times are processor times, so other work on the
machine matters little; kernels are loaded before the clock starts.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

from worldgen import stream
from worldgen.sets import check_set, make_set, manifest_of, plan_set

# The words of a round that takes seconds; the gate runs it.
TINY = ("--count", "20")

FAMILIES = ("maze", "trap")
CASES: dict[str, dict[str, Any]] = {
    "folder": {"name": "set", "metrics": False},
    "zip": {"name": "set.zip", "metrics": False},
    "folder, metrics": {"name": "set", "metrics": True},
}
# Worlds made first: after them compiled code is loaded.
WARM = 1_000


def measure(count: int) -> Iterator[dict[str, Any]]:
    """Time every case.

    Args:
        count: Worlds of each case.

    Returns:
        ``family``, ``case``, ``worlds``, ``rate`` (worlds a second) and ``ratio`` (to ``stream``).
    """
    for family in FAMILIES:
        # The first worlds load code and fill caches, so they are not timed.
        deque(stream(family, count=WARM), maxlen=0)
        bare = _seconds(lambda family=family: deque(stream(family, count=count), maxlen=0))
        yield {
            "family": family,
            "case": "stream",
            "worlds": count,
            "rate": count / bare,
            "ratio": 1.0,
        }
        for case, how in CASES.items():
            with tempfile.TemporaryDirectory() as folder:
                # Sets record metrics only in some cases, because measuring can take longer than
                # making.
                out = Path(folder) / how["name"]
                plan = plan_set(family, 0, count, {}, metrics=how["metrics"])
                taken = _seconds(lambda plan=plan, out=out: make_set(plan, out))
                yield {
                    "family": family,
                    "case": case,
                    "worlds": count,
                    "rate": count / taken,
                    "ratio": bare / taken,
                }
                # Checking reads every file again, so only the folder's case is timed.
                if case == "folder":
                    taken = _seconds(lambda out=out: check_set(out, manifest_of(out)))
                    yield {
                        "family": family,
                        "case": "check",
                        "worlds": count,
                        "rate": count / taken,
                    }


def _seconds(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2_000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = []
    for result in measure(options.count):
        found.append(result)
        if not options.json:
            ratio = f"{result['ratio']:6.2f} of stream" if "ratio" in result else ""
            click.echo(
                f"{result['family']:6} {result['case']:16} {result['rate']:9,.0f} worlds/s {ratio}"
            )
    if options.json:
        click.echo(json.dumps({"cases": found}))


if __name__ == "__main__":
    main()
