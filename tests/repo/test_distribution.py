"""The source archive and the wheel are complete.

Everything that works from a checkout also works from them.
"""

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

from build_tools.cores import CORES, suffix
from build_tools.wasm import module_of

ROOT = Path(__file__).parents[2]
PACKAGES = ("worldgen", "sim", "fuzz", "corpora", "worldgen_plugins")

# As on a machine that only has Python and pip: the build fetches a compiler.
WITHOUT_COMPILER = {name: value for name, value in os.environ.items() if name != "CC"} | {
    "PATH": ""
}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A copy of the tracked files.

    This keeps untracked files out of the archives.
    """
    folder = tmp_path_factory.mktemp("source") / "worldgen"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=False)
    if listed.returncode:
        pytest.skip(
            "NOT BUILT: this is not a git checkout, so the files that belong to it are not known"
        )
    for name in filter(None, listed.stdout.decode().split("\0")):
        source = ROOT / name
        if source.is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(source.read_bytes())
    return folder


@pytest.fixture(scope="module")
def built(checkout, tmp_path_factory):
    """The source archive, and the wheel that is built from it."""
    pytest.importorskip(
        "build", reason="NOT BUILT: pip install -e '.[dev]' brings the build program"
    )
    out = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--outdir", out, checkout]
    done = subprocess.run(
        command, env=WITHOUT_COMPILER, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    [archive] = out.glob("*.tar.gz")
    [wheel] = out.glob("*.whl")
    return archive, wheel


def sources(checkout):
    """Every tracked file below a package, by name."""
    return {
        str(path.relative_to(checkout))
        for name in PACKAGES
        for path in (checkout / name).rglob("*")
        if path.is_file()
    }


def is_compiled(name):
    """Return whether a file goes into the compiled modules.

    That is C code, and the headers that users' controllers do not include.
    """
    return "/core/" in name or name.startswith("worldgen/include/")


def test_the_version_is_the_same_in_every_file_that_names_it():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    first = next(
        line
        for line in (ROOT / "CHANGELOG.md").read_text("utf-8").splitlines()
        if line[:3] == "## "
    )
    assert citation["version"] == version
    assert first.split()[1] == version


def test_every_file_that_is_not_python_is_declared_as_a_packages_data():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    declared = project["tool"]["setuptools"]["package-data"]
    data = [
        path
        for name in PACKAGES
        for package, patterns in declared.items()
        for pattern in patterns
        for path in (
            (ROOT / name).rglob(pattern)
            if package == "*"
            else (ROOT / package.replace(".", "/")).glob(pattern)
        )
    ]
    listed = subprocess.run(
        ["git", "ls-files", "-z", *PACKAGES], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("NOT CHECKED: this is not a git checkout")
    names = {
        name
        for name in listed.stdout.split("\0")
        if name and not is_compiled(name) and not name.endswith((".py", ".pyi"))
    }
    assert len(names) > 100
    assert names - {path.relative_to(ROOT).as_posix() for path in data} == set()


@pytest.mark.gate
def test_an_installation_has_every_file_of_the_packages_and_the_compiled_cores():
    if "WORLDGEN_INSTALLED" not in os.environ:
        pytest.skip("NOT CHECKED: .ci/run installs worldgen from a copy and says where")
    site = Path(os.environ["WORLDGEN_INSTALLED"])
    listed = subprocess.run(
        ["git", "ls-files", "-z", *PACKAGES], cwd=ROOT, capture_output=True, text=True, check=True
    )
    sources = {name for name in listed.stdout.split("\0") if name and not is_compiled(name)}
    cores = {core.module.replace(".", "/") + suffix() for core in CORES}
    assert {name for name in sources | cores if not (site / name).is_file()} == set()


@pytest.mark.nightly
def test_the_wheel_has_every_file_of_the_packages_and_the_compiled_cores(checkout, built):
    names = {name for name in zipfile.ZipFile(built[1]).namelist() if ".dist-info/" not in name}
    cores = {core.module.replace(".", "/") + suffix() for core in CORES}
    # The compiler that the build fetches makes those for pages, too.
    pages = {str(module_of(core).relative_to(ROOT)) for core in CORES if core.in_pages}
    assert names == {name for name in sources(checkout) if not is_compiled(name)} | cores | pages


@pytest.mark.nightly
def test_the_source_archive_has_what_the_wheel_is_built_from(checkout, built):
    with tarfile.open(built[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert (
        sources(checkout)
        | {"pyproject.toml", "setup.py", "README.md", "LICENSE", "build_tools/backend.py"}
        <= names
    )


@pytest.mark.nightly
def test_the_wheel_passes_the_check_of_package_indexes(built):
    pytest.importorskip("twine", reason="NOT CHECKED: pip install -e '.[dev]' brings twine")
    command = [sys.executable, "-m", "twine", "check", "--strict", *built]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.nightly
def test_the_installed_wheel_makes_and_proves_a_world_and_runs_a_robot(built, tmp_path):
    site = tmp_path / "site"
    install = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--target",
        site,
        built[1],
    ]
    subprocess.run(install, check=True, capture_output=True)
    # The folder comes first on the path, so that nothing of the checkout is imported.
    code = (
        f"import sys; sys.path.insert(0, {str(site)!r}); from worldgen.cli.main import main; main()"
    )
    for command in (
        "maze --size 12 --seed 7 --out w.grid",
        "verify w.grid",
        "run w.grid --controller bug2",
        "corpus list found",
    ):
        (tmp_path / "found").mkdir(exist_ok=True)
        done = subprocess.run(
            [sys.executable, "-P", "-c", code, *command.split()],
            cwd=tmp_path,
            env=WITHOUT_COMPILER,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
