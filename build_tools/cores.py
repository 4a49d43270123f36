"""Compile the C cores of the packages into extension modules.

Each package owns its C: ``worldgen/core`` is the prover and the generators, ``sim/core`` the
    simulator, ``fuzz/core``
the search. ``worldgen/include/wg_types.h`` is all that prover and simulator have in common.

The declarations that Python sees are read from the headers themselves, so that they exist once.
cffi writes the binding, against Python's stable ABI: one build serves every Python from 3.11 on.

``python -m build_tools.cores`` compiles what has changed, in place.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from build_tools.targets import Target, import_library, zig

__all__ = ["CORES", "Core", "compile_core", "compiler", "main", "suffix"]

ROOT = Path(__file__).parent.parent

FLAGS = (
    "-std=c17",
    "-O3",
    "-fPIC",
    "-fvisibility=hidden",
    # A fused multiply-add rounds once where two operations round twice: results would depend on the
    # machine.
    "-ffp-contract=off",
    # Internal functions assert what their callers have made sure of; builds with sanitizers check
    # it.
    "-DNDEBUG",
    # sqrt() needs no errno; results are the same, and it becomes one instruction.
    "-fno-math-errno",
)
# For developers only: a compiler that we have not seen may warn of something new.
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
# The process that loads such a module must have loaded the sanitizer before; .ci/run shows how.
SANITIZE = (
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
    "-g",
    "-O1",
    "-UNDEBUG",
)
# What cffi generates keeps to no such rules. Its Python.h is ours, which declares the stable ABI.
_STABLE_ABI = "build_tools/stable_abi"
BINDING = ("-w", "-DPy_LIMITED_API=0x030B0000", f"-I{ROOT / _STABLE_ABI}")

_DIRECTIVE = re.compile(r"^\s*#(?:\\\n|[^\n])*", re.MULTILINE)
_CPLUSPLUS = re.compile(r"#ifdef __cplusplus.*?#endif", re.DOTALL)
_INLINE = re.compile(r"^static inline [^;{]*\{.*?^\}", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Core:
    """One package's C.

    Args:
        module: Dotted name of the extension module.
        sources: Folders of C files.
        headers: Files whose declarations Python sees, in order.
        includes: Folders on the compiler's include path.
    """

    module: str
    sources: tuple[str, ...]
    headers: tuple[str, ...]
    includes: tuple[str, ...]

    @property
    def exists(self) -> bool:
        """Whether its own header is there."""
        return (ROOT / self.headers[-1]).is_file()

    def c_files(self) -> list[Path]:
        """Return all C files, sorted."""
        return sorted(file for folder in self.sources for file in (ROOT / folder).rglob("*.c"))

    def declarations(self) -> str:
        """Return what the headers declare, without directives and inline functions.

        As cffi reads it.
        """
        texts = []
        for header in self.headers:
            text = (ROOT / header).read_text(encoding="utf-8")
            text = _CPLUSPLUS.sub("", text)
            text = _DIRECTIVE.sub("", text)
            texts.append(_INLINE.sub("", text))
        return "\n".join(texts)

    def preamble(self) -> str:
        """Return the includes of the binding."""
        return "".join(f'#include "{Path(header).name}"\n' for header in self.headers)


_TYPES = "worldgen/include/wg_types.h"
_CONTROLLER = "sim/include/worldgen_controller.h"
_SIM = (
    "sim/core/wg_sim.h",
    "sim/core/wg_episode.h",
    "sim/core/wg_guard.h",
    "sim/core/controllers/wg_controllers.h",
)

CORES = (
    Core(
        "worldgen._core",
        ("worldgen/core",),
        (_TYPES, "worldgen/core/wg_reach.h", "worldgen/core/wg_making.h"),
        ("worldgen/include", "worldgen/core"),
    ),
    Core(
        "sim._core",
        ("sim/core",),
        (
            _TYPES,
            _CONTROLLER,
            *_SIM,
            "sim/core/wg_python_act.h",
            "sim/core/wg_parts.h",
            "sim/core/wg_runs.h",
            "sim/core/wg_navigate.h",
            "sim/core/wg_thesis.h",
            "sim/core/fleet/wg_fleet.h",
        ),
        (
            "worldgen/include",
            "sim/include",
            "sim/core",
            "sim/core/controllers",
            "sim/core/fleet",
            _STABLE_ABI,
        ),
    ),
    # The search runs the simulator and the prover's flood inside its own loops, so both are
    # compiled into it.
    Core(
        "fuzz._core",
        ("fuzz/core", "sim/core"),
        (
            _TYPES,
            _CONTROLLER,
            *_SIM,
            "sim/core/wg_parts.h",
            "fuzz/core/wg_looks.h",
            "fuzz/core/wg_faults.h",
        ),
        (
            "worldgen/include",
            "sim/include",
            "sim/core",
            "sim/core/controllers",
            "sim/core/fleet",
            "fuzz/core",
            _STABLE_ABI,
        ),
    ),
)


def compiler(target: Target | None = None) -> list[str]:
    """Return the command of the C compiler.

    That is ``$CC``, else one on the path, else the one in the wheel ``ziglang``; for another system
    always the last.

    Raises:
        RuntimeError: If no compiler is found.
    """
    named = os.environ.get("CC")
    if target is None and named:
        return shlex.split(named)
    if target is None and sys.platform != "win32":
        for name in ("cc", "gcc", "clang"):
            if shutil.which(name):
                return [name]
    command = zig()
    if not command:
        raise RuntimeError("no C compiler found: install gcc or clang, or `pip install ziglang`")
    # Without -mcpu the result would run on processors like this one only.
    aim = [] if target is None else ["-target", target.triple]
    return [*command, "cc", *aim, "-mcpu=baseline"]


def suffix(target: Target | None = None) -> str:
    """Return how the file of an extension module for the stable ABI ends."""
    on_windows = sys.platform == "win32" if target is None else target.is_windows
    return ".pyd" if on_windows else ".abi3.so"


def compile_core(
    core: Core, made: Path, work: Path, *, target: Target | None = None, flags: Sequence[str] = ()
) -> None:
    """Compile one core.

    Args:
        core: Which.
        made: File of the extension module.
        work: Folder for object files; those whose sources are unchanged are used again.
        target: The system that it is for; None is this one.
        flags: Added to ours.

    Raises:
        subprocess.CalledProcessError: If the compiler refuses something; it has said what.
    """
    command = compiler(target)
    work.mkdir(parents=True, exist_ok=True)
    binding = work / "binding.c"
    _write_binding(core, binding)
    includes = [f"-I{ROOT / folder}" for folder in core.includes]
    headers = sorted(
        file for folder in (*core.includes, _STABLE_ABI) for file in (ROOT / folder).rglob("*.h")
    )
    objects = []
    jobs = []
    for source in [*core.c_files(), binding]:
        own = BINDING if source == binding else ()
        line = [*command, *FLAGS, *flags, *own, *includes]
        digest = hashlib.sha256(repr(line).encode())
        for file in [source, *headers]:
            digest.update(file.read_bytes())
        compiled = work / f"{source.stem}-{digest.hexdigest()[:16]}.o"
        objects.append(str(compiled))
        if not compiled.exists():
            jobs.append([*line, "-c", str(source), "-o", str(compiled)])
    _run_side_by_side(jobs)

    made.parent.mkdir(parents=True, exist_ok=True)
    fresh = work / f"linked{suffix(target)}"
    libraries = _libraries(target, work)
    subprocess.run(
        [*command, "-shared", *flags, *objects, *libraries, "-o", str(fresh)], check=True
    )
    # A running process may have the old module open; a rename leaves that one as it is.
    replacement = made.with_name(f".{made.name}.{os.getpid()}")
    shutil.copyfile(fresh, replacement)
    replacement.replace(made)


def _libraries(target: Target | None, work: Path) -> list[str]:
    """Return the linker's other inputs.

    Python's functions come from the program that loads the module.
    """
    if sys.platform == "win32" if target is None else target.is_windows:
        return [str(import_library(work))]
    if sys.platform == "darwin" if target is None else target.is_macos:
        return ["-undefined", "dynamic_lookup"]
    return ["-lm"]


def _write_binding(core: Core, file: Path) -> None:
    """Have cffi write the C file that makes a core a module; an unchanged one keeps its time."""
    from cffi import FFI  # noqa: PLC0415 - only the build needs it

    ffi = FFI()
    ffi.cdef(core.declarations())
    ffi.set_source(core.module, core.preamble())
    ffi.emit_c_code(str(file))


def _run_side_by_side(jobs: list[list[str]]) -> None:
    """Run commands, as many at once as there are processors."""
    running: list[tuple[list[str], subprocess.Popen[bytes]]] = []
    waiting = list(jobs)
    while waiting or running:
        while waiting and len(running) < (os.cpu_count() or 1):
            command = waiting.pop(0)
            running.append((command, subprocess.Popen(command)))
        command, process = running.pop(0)
        code = process.wait()
        if code:
            for _, other in running:
                other.kill()
            raise subprocess.CalledProcessError(code, command)


def main() -> None:
    """Compile all cores in place; a warning is an error."""
    parser = argparse.ArgumentParser(prog="python -m build_tools.cores", description=__doc__)
    parser.add_argument(
        "--sanitize",
        action="store_true",
        help="end the process at each fault of memory or arithmetic",
    )
    flags = (*STRICT, *(SANITIZE if parser.parse_args().sanitize else ()))
    for core in CORES:
        if core.exists:
            package, _, name = core.module.rpartition(".")
            made = ROOT / package.replace(".", "/") / (name + suffix())
            compile_core(core, made, ROOT / "build" / "cores" / core.module, flags=flags)
            print(made.relative_to(ROOT))  # noqa: T201 - a script of developers


if __name__ == "__main__":
    main()
