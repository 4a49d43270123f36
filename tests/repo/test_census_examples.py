"""The generators of the census, and the script that makes the table of docs/notes/census.md."""

import importlib.util
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.census import CELLS, ROWS, main
from benchmarks.census_questions import CensusOptions, take_census
from benchmarks.foreign_maps import generated_maps

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "benchmarks" / "generators"
MODULES = {
    "irsim_maps": "irsim", "labmaze_maps": "labmaze", "maze_dataset_maps": "maze_dataset", "mazelib_maps": "mazelib",
    "minigrid_maps": "minigrid", "navix_maps": "navix", "pogema_maps": "pogema", "tcod_maps": "tcod",
}  # fmt: skip
POST = """<model name='post'><static>1</static><pose frame=''>{x} {y} 0 0 0 0</pose><link name='link'>
<collision name='c'><geometry><cylinder><radius>{radius}</radius><length>1</length></cylinder></geometry></collision>
</link></model>"""
PLANE = (
    "<model name='ground'><link name='l'><collision "
    "name='c'><geometry><plane/></geometry></collision></link></model>"
)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_an_adapter_gives_judgeable_maps_and_the_same_for_the_same_seed(name):
    if importlib.util.find_spec(MODULES[name]) is None:
        pytest.skip(
            f"{MODULES[name]} is not installed, so {name}.py is not tested; its docstring says "
            f"what to install"
        )
    first, second = (
        take_census(generated_maps(name, count=3, seed=5), CensusOptions(CELLS)) for _ in range(2)
    )
    assert first.maps == 3 and not first.refused and first.questions == second.questions


def test_every_generators_adapter_is_tested_here():
    assert {path.stem for path in FOLDER.glob("*.py")} == {*MODULES}
    assert {row.adapter for row in ROWS if row.adapter} == {*MODULES}


@pytest.fixture
def barn(tmp_path):
    """Two worlds with posts 0.15 m apart in a row across the path.

    One with a gap of 0.6 m, one without.
    """
    for number, gap in enumerate((range(13, 17), range(0))):
        posts = [
            POST.format(x=-4.425 + 0.15 * index, y=7.425, radius=0.075)
            for index in range(30)
            if index not in gap
        ]
        text = f"<sdf version='1.6'><world name='w'>{PLANE}{''.join(posts)}</world></sdf>"
        (tmp_path / f"world_{number}.world").write_text(text)
    return tmp_path


def test_the_table_says_loudly_what_it_skips(barn):
    result = CliRunner().invoke(
        main, ["--count", "2", "--only", "BARN", "--only", "Arena", "--barn", str(barn)]
    )
    assert (
        "| BARN, posts as squares | 2 | 100 | 0.35 m | 2 | 0, 0.0 % (0.0 to 84.2) | 0 | 1 (1) | 1 "
        "(1) |" in result.stdout
    )
    assert "SKIPPED: Arena-Rosnav maps: --arena is not given" in result.stderr
