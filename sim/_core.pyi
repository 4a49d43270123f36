"""The C core, which cffi makes; its functions are in ``sim/core/wg_*.h``."""

from typing import Any

ffi: Any
lib: Any
