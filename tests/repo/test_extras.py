"""Each extra alone brings what its feature needs, in an environment that has nothing else."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
BUILD_THE_SITE = re.search(
    r"python (-m sphinx [^`]+)`", (ROOT / "README.md").read_text(encoding="utf-8")
)[1]

# What uses the extra: shell commands in the fresh clone; the environment is first on the path.
# Files go to $OUT, ports are free ones; what still runs when the shell ends is killed.
USES = {
    "bags": "python -c 'import sys; from pathlib import Path; from tests.helpers.bags import drive, write_bag; "
    "write_bag(Path(sys.argv[1]), drive())' $OUT/run && worldgen import $OUT/run --out $OUT/w.grid && "
    "worldgen audit $OUT/w.grid $OUT/run",
    "parquet": "worldgen corpus export corpora/failures --out $OUT/failures.parquet",
    "dask": "dask scheduler --port 0 --no-dashboard "
    "--scheduler-file $OUT/scheduler.json & dask worker --scheduler-file $OUT/scheduler.json & "
    "until test -s $OUT/scheduler.json; do sleep 0.2; done; "
    "worldgen fuzz --controller turn-right --units 1 --examples 5 --seed 1 --out $OUT/found "
    '--scheduler $(grep -o "tcp://[^\\"]*" $OUT/scheduler.json) || test $? = 1',
    "collada": "cd $OUT && python -c 'import trimesh; trimesh.creation.box().export(\"a.dae\")' && "
    'echo "<sdf><model><link><collision><geometry><mesh><uri>a.dae</uri></mesh></geometry>'
    '</collision></link></model></sdf>" > m.sdf && python -c "from pathlib import Path; '
    "from worldgen.interop import read_map; assert not read_map(Path('m.sdf')).unread\"",
    "dxf": "cd $OUT && python -c 'import ezdxf; d = ezdxf.new(); "
    'd.modelspace().add_line((0, 0), (4, 3)); d.saveas("a.dxf")\' && '
    "worldgen import a.dxf --unit m --radius 0.1 --out w.grid",
    "numba": "cd $OUT && worldgen new-controller mine --kind compiled && "
    "worldgen maze --size 12 --seed 1 --out w.grid && "
    "worldgen run w.grid --controller ./mine.py:mine || test $? = 1",
    "pettingzoo": "python -c 'from worldgen_plugins.for_pettingzoo import FleetEnv; "
    "from worldgen.families import doorway; FleetEnv(world=doorway(1)).reset(seed=1)'",
    "gym": "python -c 'import gymnasium, worldgen.gym; "
    'gymnasium.make("worldgen/Navigate-v0").reset(seed=1)\'',
    "studio": "worldgen studio $OUT --port 0 --no-browser >$OUT/said 2>&1 & "
    "until grep -o 'http://[^ ]*' $OUT/said; do kill -0 $! && sleep 0.2; done; "
    "python -c 'import sys, urllib.request; urllib.request.urlopen(sys.argv[1]).read()' "
    "$(grep -o 'http://[^ ]*' $OUT/said)",
    "docs": f"python {BUILD_THE_SITE}",
    "test": "python -m pytest -q tests/worldgen/test_grid_file.py tests/plugins",
    "dev": "ruff check . && lint-imports && python -m pytest -q tests/repo/test_readme.py",
}


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A fresh clone, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("extras") / "worldgen"
    subprocess.run(["git", "clone", "--quiet", ROOT, folder], check=True)
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", "build", "."]
    subprocess.run(build, cwd=folder, check=True)
    return folder


def test_every_extra_is_used():
    assert set(USES) == set(EXTRAS)


@pytest.mark.nightly
@pytest.mark.parametrize("extra", EXTRAS)
def test_what_an_extra_is_for_works_with_that_extra_alone(extra, clone, tmp_path):
    [wheel] = (clone / "build").glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "alone"], check=True)
    programs = tmp_path / "alone" / "bin"
    install = [programs / "python", "-m", "pip", "install", "--quiet"]
    subprocess.run([*install, f"worldgen[{extra}] @ {wheel.as_uri()}"], check=True)
    said, out = tmp_path / "said", tmp_path / "out"
    out.mkdir()
    with said.open("w") as output:
        use = subprocess.Popen(
            ["sh", "-ec", f"export PATH={programs}:$PATH OUT={out}; {USES[extra]}"],
            cwd=clone,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            code = use.wait()
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(use.pid, signal.SIGKILL)
    assert code == 0, said.read_text()
