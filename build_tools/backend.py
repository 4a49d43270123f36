"""The build backend: setuptools, with a C compiler from a wheel if the machine has none.

pip reads ``get_requires_for_build_wheel`` before it builds, so the 90 MB of ``ziglang`` are fetched
only if needed.
"""

from __future__ import annotations

from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

from build_tools.cores import compiler

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]


def _compiler_wheel() -> list[str]:
    try:
        compiler()
    except RuntimeError:
        return ["ziglang>=0.15"]
    return []


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """Return what a build needs in addition to ``build-system.requires``."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), *_compiler_wheel()]


def get_requires_for_build_editable(config_settings: Any = None) -> list[str]:
    """Return what an editable build needs in addition to ``build-system.requires``."""
    return [*build_meta.get_requires_for_build_editable(config_settings), *_compiler_wheel()]
