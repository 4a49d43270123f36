"""The Hypothesis plug-in.

``World`` is a type that Hypothesis can draw, at no cost if it is not used.
"""

import subprocess
import sys

import pytest

DRAWS = """
@hypothesis.settings(max_examples=5, database=None, deadline=None)
@hypothesis.given(...)
def holds(world: worldgen.World):
    assert isinstance(world, worldgen.World) and world.certificate is not None
holds()
"""


def python(code):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    return done.stdout + done.stderr


LOOKED_FOR = (
    "import hypothesis, importlib.util; importlib.util.find_spec('worldgen.world'); import worldgen"
)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "imports", ["import hypothesis, worldgen", "import worldgen.world, hypothesis", LOOKED_FOR]
)
def test_worlds_are_drawn_from_an_annotation_whichever_is_imported_first(imports):
    assert python(imports + DRAWS) == ""


def test_to_import_hypothesis_imports_nothing_of_ours():
    heavy = "{'numpy', 'worldgen', 'sim', 'fuzz'}"
    assert python(f"import hypothesis, sys; print(sorted({heavy} & set(sys.modules)))") == "[]\n"


def test_the_module_looks_as_if_nobody_had_waited_for_it():
    same = (
        "w.__loader__ is w.__spec__.loader and 'Awaited' not in repr(sys.meta_path) and "
        "inspect.getsource(w)[:3]"
    )
    code = (
        f"import hypothesis, inspect, sys, worldgen.world as w; "
        f"print(type(w.__loader__).__name__, {same})"
    )
    assert python(code) == 'SourceFileLoader """\n'
