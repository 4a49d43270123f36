"""Wheels of other systems, and builds by other compilers."""

import os
import shutil
import subprocess
import sys
import zipfile

import pytest

from build_tools.cores import CORES, ROOT
from build_tools.targets import TARGETS
from build_tools.wasm import compile_module
from build_tools.wheels import build_wheel

pytestmark = pytest.mark.nightly

FROM_PYTHON = {
    line.split()[0]
    for line in (ROOT / "build_tools/stable_abi/python3.def")
    .read_text(encoding="utf-8")
    .splitlines()[2:]
}
# Symbols of the C library, with their ELF names.
FROM_C = {
    "_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable", "_exit", "bcmp", "bzero", "calloc", "ceil",
    "clock_getcpuclockid", "clock_gettime", "close", "dup2", "floor", "fmax", "fmin", "fmod", "fork", "free",
    "getpid", "getppid", "kill", "ldexp", "malloc", "memchr", "memcmp", "memcpy", "memmove", "memset",
    "memset_pattern16", "nanosleep", "open", "pipe", "poll", "prctl", "pthread_sigmask", "qsort", "read", "realloc",
    "round", "sched_yield", "setitimer", "setrlimit", "sigaction", "sigemptyset", "sigfillset", "signal",
    "sigprocmask", "snprintf", "sqrt", "strcmp", "strlen", "strncpy", "syscall", "waitpid", "write",
}  # fmt: skip
OLDEST_GLIBC = (2, 17)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_a_wheel_has_all_cores_and_needs_nothing_that_its_system_lacks(target, tmp_path):
    lief = pytest.importorskip("lief", reason="NOT CHECKED: pip install -e '.[dev]' brings lief")
    pytest.importorskip("ziglang", reason="NOT BUILT: pip install -e '.[dev]' brings ziglang")
    with zipfile.ZipFile(build_wheel(target, tmp_path)) as wheel:
        modules = [name for name in wheel.namelist() if name.endswith((".so", ".pyd"))]
        assert len(modules) == len(CORES)
        pages = [name for name in wheel.namelist() if name.endswith(".wasm")]
        assert len(pages) == sum(bool(core.in_pages) for core in CORES)
        for name in modules:
            module = lief.parse(wheel.read(name))
            assert "PyInit__core" in {symbol.name.lstrip("_") if target.is_macos else symbol.name
                                      for symbol in module.exported_functions}  # fmt: skip
            if target.is_windows:
                check_windows(module)
            else:
                check_unix(module, target)


def test_the_modules_for_pages_are_the_same_wherever_they_are_compiled(tmp_path):
    pytest.importorskip("ziglang", reason="NOT BUILT: pip install -e '.[dev]' brings ziglang")
    core = next(core for core in CORES if core.in_pages)
    made = [tmp_path / name / "_core.wasm" for name in ("one", "other")]
    for module in made:
        compile_module(core, module, module.parent / "work")
    assert made[0].read_bytes() == made[1].read_bytes()
    # A second time there is nothing to compile.
    objects = {file: file.stat().st_mtime_ns for file in (made[0].parent / "work").glob("*.o")}
    compile_module(core, made[0], made[0].parent / "work")
    assert objects == {file: file.stat().st_mtime_ns for file in objects}


def check_windows(module):
    """Everything comes from Python's stable library or from libraries that every Windows has."""
    for library in module.imports:
        name = library.name.lower()
        assert name == "python3.dll" or name.startswith(
            ("api-ms-win-crt-", "kernel32", "msvcrt", "ucrtbase")
        ), name


def check_unix(module, target):
    """Every symbol belongs to Python's stable ABI or to an old C library."""
    names = {symbol.name for symbol in module.imported_symbols if symbol.name}
    if target.is_macos:
        names = {name.removeprefix("_") for name in names}
        names -= {"dyld_stub_binder", "__stack_chk_guard"}
        names = {"_Py_NoneStruct" if name == "Py_NoneStruct" else name for name in names}
    strange = names - FROM_PYTHON - FROM_C
    assert not {name for name in strange if not name.startswith("__")}, strange
    if not target.is_macos:
        groups = module.symbols_version_requirement
        needed = [symbol.name for group in groups for symbol in group.get_auxiliary_symbols()]
        versions = [
            tuple(map(int, name.split("_")[1].split(".")))
            for name in needed
            if name.startswith("GLIBC_")
        ]
        assert max(versions) <= OLDEST_GLIBC


# The checks of a build: worlds of every family with their proofs, and runs of every controller in
# them.
DIGESTS = """
import hashlib
from sim import simulate
from sim.controllers import CONTROLLERS
from worldgen import generate
from worldgen.family import FAMILIES
from worldgen.files.grid import dumps

digest = hashlib.sha256()
for family in FAMILIES.names():
    for seed in (1, 2):
        world = generate(family, seed=seed)
        digest.update(dumps(world))
        for name in CONTROLLERS.names():
            digest.update(simulate(world, name, steps=500).trace_digest.encode())
print(digest.hexdigest())
"""


def digest_of_build(compiler, folder):
    """Compile a copy of the checkout with a compiler, and make worlds and runs with it."""
    skip = shutil.ignore_patterns(
        ".*", "build", "dist", "*.so", "*.pyd", "*.egg-info", "__pycache__", "docs", "corpora"
    )
    shutil.copytree(ROOT, folder, ignore=skip)
    environment = {**os.environ, "CC": compiler, "PYTHONPATH": str(folder)}
    for code in (["-m", "build_tools.cores"], ["-c", DIGESTS]):
        done = subprocess.run(
            [sys.executable, *code],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    return done.stdout.split()[-1]


def test_all_compilers_give_the_same_worlds_and_runs(tmp_path):
    pytest.importorskip("ziglang", reason="NOT BUILT: pip install -e '.[dev]' brings ziglang")
    commands = [name for name in ("gcc", "clang") if shutil.which(name)]
    commands.append(f"{sys.executable} -m ziglang cc -mcpu=baseline")
    commands.append(f"{sys.executable} -m ziglang cc -mcpu=native")
    found = {
        command: digest_of_build(command, tmp_path / str(k)) for k, command in enumerate(commands)
    }
    assert len(set(found.values())) == 1, found
