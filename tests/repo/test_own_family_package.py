"""The example of a user's own family, installed as a user would, in its own environment."""

import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

EXAMPLE = Path("examples/own-family")
UNREACHABLE = (
    "No module named pip",
    "No matching distribution found for setuptools",
    "onnection",
    "Could not fetch",
)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The Python of an environment that has the example and the packages installed here."""
    folder = tmp_path_factory.mktemp("own")
    venv.create(folder / "env", with_pip=False)
    python = folder / "env" / "bin" / "python"
    package = shutil.copytree(
        EXAMPLE, folder / "package", ignore=shutil.ignore_patterns("build", "*.egg-info")
    )
    [site] = (folder / "env" / "lib").glob("python*/site-packages")
    (site / "outer.pth").write_text(
        f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n"
    )
    install = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(python),
        "install",
        "-q",
        "--no-deps",
        str(package),
    ]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    if done.returncode and any(sign in done.stderr for sign in UNREACHABLE):
        pytest.skip(f"NOT TESTED, for want of pip or network: {done.stderr.strip()[-200:]}")
    assert done.returncode == 0, done.stderr
    return python, package


def run(installed, *args):
    python, package = installed
    return subprocess.run(
        [python, *args], cwd=package.parent, capture_output=True, text=True, check=False
    )


@pytest.mark.nightly
def test_an_installed_family_is_a_command_like_any_other(installed):
    made = run(
        installed,
        "-m",
        "worldgen",
        "depot",
        "--layout",
        "fishbone",
        "--seed",
        "7",
        "--out",
        "w.grid",
    )
    assert made.returncode == 0, made.stderr
    checked = run(installed, "-m", "worldgen", "verify", "w.grid")
    assert checked.returncode == 0 and "witness checked" in checked.stdout
    assert "depot" in run(installed, "-m", "worldgen", "--help").stdout


@pytest.mark.nightly
def test_the_packages_own_test_passes(installed):
    _, package = installed
    done = run(installed, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(package / "tests"))
    assert done.returncode == 0, done.stdout
