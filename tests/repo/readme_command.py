"""Prints one of the README's two set-up commands: ``python tests/repo/readme_command.py 1``."""

import re
import sys
from pathlib import Path


def commands(readme: str) -> list[str]:
    """The fenced ``sh`` blocks that begin by making a virtual environment, in order."""
    blocks = re.findall(r"```sh\n(.*?)```", readme, flags=re.DOTALL)
    return [block.strip() for block in blocks if block.startswith("python3 -m venv")]


if __name__ == "__main__":
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    sys.stdout.write(commands(text)[int(sys.argv[1]) - 1] + "\n")
