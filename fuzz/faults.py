"""The name of the seeded faults, wherever a controller can be named.

They are not part of the product: a checkout has them in ``benchmarks/faults``, and files that name
one replay there.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

from worldgen.errors import InvalidParameter

_FOLDER = Path(__file__).parents[1] / "benchmarks" / "faults"


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if not _FOLDER.is_dir():
        raise InvalidParameter(
            "no-checkout",
            "the seeded fault {name!r} is not part of an installation",
            "use a checkout, whose benchmarks/faults has it",
            name=name,
        )
    module = sys.modules.get("benchmarks.faults") or sys.modules.get("seeded_faults")
    # By its path: where Python was started, another folder may be called benchmarks.
    if module is None or module.__file__ != str(_FOLDER / "__init__.py"):
        spec = importlib.util.spec_from_file_location("seeded_faults", _FOLDER / "__init__.py")
        assert spec is not None and spec.loader is not None, "a .py file has a loader"
        module = importlib.util.module_from_spec(spec)
        sys.modules["seeded_faults"] = module
        spec.loader.exec_module(module)
    return getattr(module, name)
