"""Methods of `World` that need code which builds on worlds.

A world's id is the hash of its file, and a notebook shows its picture. Both import `World`, so
`World` cannot import them. The package registers them when it is imported, before any world exists.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

world_methods: dict[str, Callable[[Any], Any]] = {}
"""``digest`` and ``picture``, each a function of a world."""
