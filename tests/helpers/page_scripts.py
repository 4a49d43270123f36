"""The pages' scripts in Node: their own tests, and functions called with the server's data."""

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "page"
_OLDEST = (18, 19)  # the first version in which a script can set where modules are


@cache
def missing_node():
    """Return what this machine lacks for the tests of the pages' scripts.

    Empty if it has everything.
    """
    node = shutil.which("node")
    if node is None:
        return "no Node: the pages' scripts are not tested (apt-get install nodejs)"
    said = subprocess.run(
        [node, "--version"], capture_output=True, text=True, timeout=120, check=False
    ).stdout
    found = tuple(int(part) for part in re.findall(r"\d+", said)[:2])
    return (
        ""
        if found >= _OLDEST
        else f"Node {said.strip()} is older than 18.19: the pages' scripts are not tested"
    )


def run_tests(*names):
    """Run the tests in some files, or all of them; return the finished process."""
    files = [FOLDER / name for name in names] or sorted(FOLDER.glob("*.test.mjs"))
    command = ["node", "--test", "--test-reporter=tap", *files]
    return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)


def called(*calls):
    """Call functions of the pages, each as ``(module, function, arguments)``.

    Return their results, in order. Modules are named like ``player/decode``; arguments and results
    are JSON, and typed arrays come back as lists.
    """
    asked = json.dumps(calls)
    done = subprocess.run(
        ["node", FOLDER / "call.mjs"],
        input=asked,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
