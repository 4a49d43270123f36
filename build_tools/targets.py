"""The systems that wheels are built for, and how to compile for each of them from any other."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

VARIABLE = "WORLDGEN_TARGET"
_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Target:
    """A system.

    Args:
        name: Value of ``WORLDGEN_TARGET``.
        triple: Zig's name for it, with the oldest supported version of the system's library.
        platform: Platform tag of its wheels.
    """

    name: str
    triple: str
    platform: str

    @property
    def is_windows(self) -> bool:
        """True if modules end in ``.pyd`` and name the library that they import from."""
        return "windows" in self.triple

    @property
    def is_macos(self) -> bool:
        """Return True if the linker must be told that loading resolves Python's symbols."""
        return "macos" in self.triple


TARGETS = (
    Target("linux-x86_64", "x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64"),
    Target("linux-aarch64", "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64"),
    Target("macos-arm64", "aarch64-macos.11.0", "macosx_11_0_arm64"),
    Target("macos-x86_64", "x86_64-macos.11.0", "macosx_11_0_x86_64"),
    Target("windows-x86_64", "x86_64-windows-gnu", "win_amd64"),
)


def chosen_target() -> Target | None:
    """Return the system that ``WORLDGEN_TARGET`` names; None is this machine.

    Raises:
        ValueError: If the name is unknown.
    """
    name = os.environ.get(VARIABLE)
    if not name:
        return None
    for target in TARGETS:
        if target.name == name:
            return target
    known = ", ".join(target.name for target in TARGETS)
    raise ValueError(f"{VARIABLE}={name}: there is no such target; choose from {known}")


def zig() -> list[str]:
    """Return the command of the compiler in the wheel ``ziglang``; empty if it isn't installed."""
    try:
        import ziglang  # noqa: F401, PLC0415 - only where there is nothing else
    except ImportError:
        return []
    return [sys.executable, "-m", "ziglang"]


def import_library(folder: Path) -> Path:
    """Make the library that tells Windows' linker what ``python3.dll`` offers.

    Raises:
        subprocess.CalledProcessError: If zig cannot make it.
    """
    made = folder / "libpython3.a"
    definitions = _HERE / "stable_abi" / "python3.def"
    command = [*zig(), "dlltool", "-m", "i386:x86-64", "-d", str(definitions), "-l", str(made)]
    subprocess.run(command, check=True)
    return made
