"""Compile the C cores of the packages into extension modules.

Each package owns its C: ``worldgen/core`` is the prover and the generators, ``sim/core`` the simulator, ``fuzz/core``
the search. ``worldgen/include/wg_types.h`` is all that prover and simulator have in common.

The declarations that Python sees are read from the headers themselves, so that they exist once. cffi writes the
binding, against Python's stable ABI: one build serves every Python from 3.11 on.

``python -m build_tools.cores`` compiles all cores in place, those that changed.
"""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

__all__ = ["CORES", "Core", "compile_core", "compiler", "main"]

ROOT = Path(__file__).parent.parent
PYTHON_ABI = 0x030B0000  # the oldest Python whose stable ABI is used

FLAGS = (
    "-std=c17",
    "-O3",
    "-fPIC",
    "-fvisibility=hidden",
    # A fused multiply-add rounds once where two operations round twice: results would depend on the machine.
    "-ffp-contract=off",
    # sqrt() needs no errno; results are the same, and it becomes one instruction.
    "-fno-math-errno",
)
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Werror")
# What cffi generates keeps to no such rules.
BINDING = ("-Wno-unused-function", "-DPy_LIMITED_API=0x030B0000")

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
        """Return what the headers declare, without directives and inline functions, as cffi reads it."""
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
_SIM = ("sim/core/wg_sim.h", "sim/core/wg_episode.h")

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
        (_TYPES, _CONTROLLER, *_SIM, "sim/core/wg_parts.h", "sim/core/wg_thesis.h"),
        ("worldgen/include", "sim/include", "sim/core"),
    ),
    # The search runs the simulator and the prover's flood inside its own loops, so both are compiled into it.
    Core(
        "fuzz._core",
        ("fuzz/core", "sim/core"),
        (_TYPES, _CONTROLLER, *_SIM, "fuzz/core/wg_fuzz.h"),
        ("worldgen/include", "sim/include", "sim/core", "fuzz/core"),
    ),
)


def compiler() -> list[str]:
    """Return the command of the C compiler: ``$CC``, else one on the path, else the one of the wheel ``ziglang``.

    Raises:
        RuntimeError: If there is none.
    """
    named = os.environ.get("CC")
    if named:
        return shlex.split(named)
    if sys.platform != "win32":
        for name in ("cc", "gcc", "clang"):
            if shutil.which(name):
                return [name]
    try:
        import ziglang  # noqa: F401, PLC0415 - only where there is nothing else
    except ImportError:
        raise RuntimeError("no C compiler found: install gcc or clang, or `pip install ziglang`") from None
    return [sys.executable, "-m", "ziglang", "cc"]


def _python_headers() -> list[str]:
    """Return the folder of Python.h; of ours, which declares the stable ABI, where Python came without it."""
    folder = Path(sysconfig.get_path("include"))
    return [str(folder if (folder / "Python.h").is_file() else ROOT / "build_tools" / "stable_abi")]


def suffix() -> str:
    """Return how the file of an extension module for the stable ABI ends."""
    return ".pyd" if sys.platform == "win32" else ".abi3.so"


def compile_core(core: Core, target: Path, work: Path, *, flags: tuple[str, ...] = ()) -> Path:
    """Compile one core.

    Args:
        core: Which.
        target: File of the extension module.
        work: Folder for object files; those whose sources are unchanged are used again.
        flags: Added to ours.

    Returns:
        ``target``.

    Raises:
        subprocess.CalledProcessError: If the compiler refuses something; it has said what.
    """
    command = compiler()
    work.mkdir(parents=True, exist_ok=True)
    binding = work / f"{core.module.rpartition('.')[2]}_binding.c"
    _write_binding(core, binding)
    includes = [f"-I{ROOT / folder}" for folder in core.includes]
    python = [f"-I{folder}" for folder in _python_headers()]
    headers = sorted(file for folder in core.includes for file in (ROOT / folder).rglob("*.h"))
    objects = []
    jobs = []
    for source in [*core.c_files(), binding]:
        own = [*BINDING, *python] if source == binding else list(STRICT)
        line = [*command, *FLAGS, *own, *flags, *includes]
        digest = hashlib.sha256(repr(line).encode())
        for file in [source, *headers]:
            digest.update(file.read_bytes())
        made = work / f"{source.stem}-{digest.hexdigest()[:16]}.o"
        objects.append(str(made))
        if not made.exists():
            jobs.append([*line, "-c", str(source), "-o", str(made)])
    _run_side_by_side(jobs)
    target.parent.mkdir(parents=True, exist_ok=True)
    fresh = target.with_name(f".{target.name}.{os.getpid()}")  # a process may have the old one open
    dynamic = ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []
    subprocess.run([*command, "-shared", *flags, *dynamic, *objects, "-lm", "-o", str(fresh)], check=True)
    fresh.replace(target)
    return target


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
    """Compile all cores in place."""
    for core in CORES:
        if not core.exists:
            continue
        package, _, name = core.module.rpartition(".")
        target = ROOT / package.replace(".", "/") / (name + suffix())
        compile_core(core, target, ROOT / "build" / "cores" / core.module)
        print(target.relative_to(ROOT))  # noqa: T201 - a script of developers


if __name__ == "__main__":
    main()
