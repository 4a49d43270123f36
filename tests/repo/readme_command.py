"""Prints a block of the README: ``python tests/repo/readme_command.py 1``.

1 and 2 are the set-up commands, and ``python`` is the example that uses worldgen from Python.
"""

import re
import sys
from pathlib import Path


def commands(readme: str) -> list[str]:
    """The fenced ``sh`` blocks that begin by making a virtual environment, in order."""
    blocks = re.findall(r"```sh\n(.*?)```", readme, flags=re.DOTALL)
    return [block.strip() for block in blocks if block.startswith("python3 -m venv")]


def python_example(readme: str) -> str:
    """The last fenced ``python`` block; the one before it is a file of the console commands."""
    return re.findall(r"```python\n(.*?)```", readme, flags=re.DOTALL)[-1]


if __name__ == "__main__":
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    which = sys.argv[1]
    block = python_example(text) if which == "python" else commands(text)[int(which) - 1]
    sys.stdout.write(block + "\n")
