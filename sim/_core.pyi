"""The C core of the simulator, as cffi makes it from the headers in ``sim/core``."""

from typing import Any

ffi: Any
lib: Any
