"""Explain what to do if a package's compiled core is missing.

A source checkout has no cores until it is installed. Python finds it first if it is the current
folder, even if worldgen is installed elsewhere.
"""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn


def refuse(package: str, folder: str) -> NoReturn:
    """Raise the error for a package without its core.

    Args:
        package: The package: ``worldgen``, ``sim`` or ``fuzz``.
        folder: Where it was found.

    Raises:
        ModuleNotFoundError: Always.
    """
    is_checkout = Path(folder, "pyproject.toml").is_file()
    raise ModuleNotFoundError(
        f"{package} was found in {folder}, a source checkout without its compiled core: start "
        "Python in another folder, or install the checkout in place with pip install -e ."
        if is_checkout
        else f"{package} in {folder} has no compiled core for this Python: install worldgen again",
        name=f"{package}._core",
    )
