"""Has setuptools compile the C cores; all else is in pyproject.toml."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

sys.path.insert(0, str(Path(__file__).parent))  # setuptools may run this file from elsewhere

from build_tools.cores import CORES, ROOT, compile_core, replace_module, suffix
from build_tools.targets import chosen_target, zig
from build_tools.wasm import NAME, compile_module, module_of

TARGET = chosen_target()


class BuildCores(build_ext):
    """Compiles a core with our own flags rather than with those that Python was built with."""

    def get_ext_filename(self, ext_name: str) -> str:
        """Return the file of a core, for the system that it is compiled for."""
        return ext_name.replace(".", "/") + suffix(TARGET)

    def build_extension(self, ext: Any) -> None:
        """Compile the core of that name."""
        core = next(core for core in CORES if core.module == ext.name)
        made = Path(self.get_ext_fullpath(ext.name))
        compile_core(core, made, Path(self.build_temp) / ext.name, target=TARGET)
        # Python that starts in the checkout finds the packages there before the installed ones, so
        # they need the core as well, not only in an editable installation.
        in_place = ROOT / self.get_ext_filename(ext.name)
        if TARGET is None and made.resolve() != in_place:
            replace_module(made, in_place)
        # The modules for pages take as long again and a compiler of 90 MB, so they are made where
        # that compiler is anyway: for wheels, and on machines without another one.
        if core.in_pages and zig():
            module = made.with_name(NAME)
            compile_module(core, module, Path(self.build_temp) / f"{ext.name}.wasm")
            if TARGET is None and module.resolve() != module_of(core):
                replace_module(module, module_of(core))


wheel = {"py_limited_api": "cp311"} | ({} if TARGET is None else {"plat_name": TARGET.platform})
setup(
    ext_modules=[Extension(core.module, [], py_limited_api=True) for core in CORES if core.exists],
    cmdclass={"build_ext": BuildCores},
    options={"bdist_wheel": wheel},
)
