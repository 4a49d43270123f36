"""Build the wheels of all systems on this one: ``python -m build_tools.wheels --out dist``.

Needs the packages ``build`` and ``ziglang``. Each wheel serves every Python from 3.11 on.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from build_tools.targets import TARGETS, VARIABLE, Target

ROOT = Path(__file__).parent.parent


def build_wheel(target: Target, out: Path) -> Path:
    """Build the wheel of one system.

    setuptools builds in the source tree, so a copy is built: files left by one system are not
    packed for another.

    Args:
        target: The system.
        out: Folder for the wheel.

    Returns:
        The wheel.

    Raises:
        subprocess.CalledProcessError: If something does not compile; the compiler has printed the
            reason.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "source"
        leave = shutil.ignore_patterns(
            ".*", "build", "dist", "*.so", "*.pyd", "*.egg-info", "__pycache__", "demo"
        )
        shutil.copytree(ROOT, copy, ignore=leave)
        made = Path(folder) / "made"
        environment = {**os.environ, VARIABLE: target.name}
        command = [
            sys.executable,
            "-m",
            "build",
            "--wheel",
            "--no-isolation",
            "--outdir",
            str(made),
            str(copy),
        ]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            sys.stderr.write(done.stdout + done.stderr)
            done.check_returncode()
        (wheel,) = made.glob("*.whl")
        out.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(wheel, out / wheel.name))


def main() -> None:
    """Build the wheels that the command line asks for."""
    names = [target.name for target in TARGETS]
    parser = argparse.ArgumentParser(prog="python -m build_tools.wheels", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder for the wheels")
    parser.add_argument(
        "--target", action="append", choices=names, help="only this system; may be repeated"
    )
    chosen = parser.parse_args()
    for target in TARGETS:
        if target.name in (chosen.target or names):
            print(build_wheel(target, chosen.out))  # noqa: T201 - a script of developers


if __name__ == "__main__":
    main()
