"""Print ``worldgen --help`` and ``--version`` without importing a single command."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

COMMANDS: dict[str, dict[str, str]] = {
    "Make worlds": {
        "families": "List the families of worlds.",
        "regenerate": "Rebuild a set of worlds from its manifest, or check it.",
        "show": "Draw a world in the terminal, or as PNG, SVG or HTML.",
        "verify": "Check a world's proof, or decide whether a target can be reached.",
        "check-family": "Check that your own family keeps the promises that every family makes.",
    },
    "Run controllers": {
        "controllers": "List the controllers, and what each of them senses.",
        "behaviours": "List behaviours, or show how a controller chooses among its own.",
        "new-controller": "Write a working, commented controller to start from.",
        "train": "Train a learning controller in worlds, and store what it learned.",
        "run": "Run a controller in a world and report how it ends.",
        "compare": "Run several controllers in many worlds and print one table.",
        "studio": "Draw worlds and watch robots run in them, in your browser.",
    },
    "Find failures": {
        "demo": "Make a world, run a robot in it and find its failures, in one command.",
        "fuzz": "Search for worlds in which a controller fails.",
        "oracles": "List the oracles that fuzz --oracle adds to the verdict.",
        "find": "Search for a world with the outcomes that you name.",
        "boundary": "Find the radius, speed, heading or field at which failures begin.",
        "init": "Set up a project whose CI searches for failures.",
    },
    "Keep and understand failures": {
        "replay": "Run saved failures again and report what has changed.",
        "explain": "Report what a failure depends on, one change at a time.",
        "shrink": "Make the world of a failure as small as possible.",
        "report": "Show failures and their campaign in one HTML page.",
        "corpus": "List, compare, merge and prune folders of failures.",
        "help": "Explain verdicts, causes or proofs, or show a command's help.",
    },
    "Convert worlds": {
        "import": "Make a world from another program's map.",
        "export": "Write a world in another program's format.",
        "formats": "List the formats that import and export know.",
    },
    "Study worlds": {
        "measure": "Measure how hard worlds are.",
        "audit": "Check whether a trajectory from any simulator was possible, or a plan is.",
        "watchdog": "Measure how well watchdogs tell robots that never arrive.",
    },
}
"""Name and summary of each command by job; a test compares them with the commands' own."""

# The libraries whose version can change a command's results.
_LIBRARIES = ("numpy", "scipy", "shapely", "trimesh", "hypothesis", "click", "numba", "dask")


def describe_versions() -> str:
    """Return the versions that a bug report needs: the program, Python, the system, libraries."""
    libraries = []
    for name in _LIBRARIES:
        try:
            libraries.append(f"{name} {version(name)}")
        # It belongs to an extra that is not installed.
        except PackageNotFoundError:
            continue
    python = f"{platform.python_implementation()} {platform.python_version()}"
    return "\n".join(
        (
            f"worldgen, version {version('worldgen')}",
            f"{python} on {platform.system()} {platform.release()}, {platform.machine()}",
            ", ".join(libraries),
        )
    )
