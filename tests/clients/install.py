"""``python -m tests.clients.install [NAME ...]``.

Makes the environments of all clients, or of the named ones. With ``--gate`` it makes only those
that the gate uses; with ``--programs`` it prints the Debian packages that contain the others. An
existing environment is reused, unless its requirements have changed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
FOLDER = Path(os.environ.get("WORLDGEN_CLIENTS") or REPOSITORY / "build" / "clients")


def _third_party() -> list[str]:
    """The requirements of the adapters in examples/third-party, and of worldgen itself.

    It runs there.
    """
    lines = (REPOSITORY / "examples" / "third-party" / "requirements.txt").read_text().splitlines()
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    return [*(line for line in lines if not line.startswith("#")), *project["dependencies"]]


# name: what pip installs; packages for one client are installed together, and clients never share
# an environment
PACKAGES = {
    "irsim": ["ir-sim>=2.12"],
    "minigrid": ["minigrid>=3.0"],
    "mujoco": ["mujoco>=3.2"],
    "ompl": ["ompl>=2.0"],
    "pogema": ["pogema==1.4.0"],
    "pointmaze": ["gymnasium-robotics>=1.4", "mujoco>=3.2"],
    "pybullet": ["numpy>=1.26", "pybullet>=3.2.7"],
    "ros2": [
        "ros-rclpy>=9.1",
        "ros-rmw-fastrtps-cpp>=9.3",
        "ros-geometry-msgs>=5.5",
        "ros-nav-msgs>=5.5",
        "ros-rosgraph-msgs>=2.3",
        "ros-sensor-msgs>=5.5",
        "ros-std-srvs>=5.5",
    ],
    "third-party": _third_party(),
    "trimesh": ["trimesh>=4.5", "rtree>=1.0"],
    "usd": ["usd-core>=25.5"],
}
# name: packages to install without dependencies, because their requirements conflict
BARE_PACKAGES = {"pogema-toolbox": ["pogema-toolbox"]}
# name: build tools missing from the requirements of that client's packages; they are installed for
# the build
BUILD_TOOLS = {"third-party": ["cython>=3.0", "numpy>=2.0", "setuptools>=77"]}
GATE = (
    "irsim",
    "mujoco",
    "trimesh",
)  # installed in seconds; a robot simulator, a physics engine, a mesh reader
# program: its Debian package
PROGRAMS = {
    "admesh": "admesh",
    "assimp": "assimp-utils",
    "chromium-headless-shell": "chromium-headless-shell",
    "g++": "g++ pkg-config libignition-physics-dev libignition-physics5-dartsim-plugin5 "
    "libignition-transport-dev",
    "ign-transport-service": "ignition-transport-cli",
    "ign": "ignition-tools sdformat-sdf",
    "gdal_rasterize": "gdal-bin",
    "ogrinfo": "gdal-bin",
    "rsvg-convert": "librsvg2-bin",
    "tmxrasterizer": "tiled",
}
_PROBLEM = "could not be installed; its tests will be skipped"


def install(name: str) -> bool:
    """Make an environment unless it exists; return whether it exists now."""
    folder = FOLDER / name
    done = folder / "installed"
    packages = PACKAGES.get(name) or BARE_PACKAGES[name]
    holds = "\n".join([sys.version, *packages])
    if done.is_file() and done.read_text(encoding="utf-8") == holds:
        return True
    shutil.rmtree(folder, ignore_errors=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    extra = (
        ["--no-deps"]
        if name in BARE_PACKAGES
        else ["--no-build-isolation"]
        if name in BUILD_TOOLS
        else []
    )
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    pip = (
        python,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--prefer-binary",
    )
    made = _ran(sys.executable, "-m", "venv", folder)
    made = (
        made
        and (name not in BUILD_TOOLS or _ran(*pip, *BUILD_TOOLS[name]))
        and _ran(*pip, *extra, *packages)
    )
    if made:
        done.write_text(holds, encoding="utf-8")
    else:
        shutil.rmtree(folder, ignore_errors=True)
    return made


def _ran(*words: str | Path) -> bool:
    return subprocess.run([str(word) for word in words], check=False, timeout=900).returncode == 0


def main(names: list[str]) -> int:
    """Install them in turn; return 1 if one is still missing."""
    if names == ["--programs"]:
        print(*sorted(set(" ".join(PROGRAMS.values()).split())))
        return 0
    known = [*PACKAGES, *BARE_PACKAGES]
    if names == ["--gate"]:
        names = list(GATE)
    strange = sorted(set(names) - set(known))
    if strange:
        print(
            f"no client is called {', '.join(strange)}; there are {', '.join(known)}",
            file=sys.stderr,
        )
        return 2
    missing = [name for name in names or known if not install(name)]
    for name in missing:
        print(f"{name} {_PROBLEM}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
