"""The pytest plug-in, in real runs of pytest, each in its own process."""

import importlib
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from fuzz.failure import Failure
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.scenario import Scenario
from worldgen.generation import generate

pytest_plugins = ["pytester"]

DOCUMENT = (Path(__file__).parents[2] / "docs/howto/pytest.md").read_text()


@pytest.fixture
def project(pytester, monkeypatch):
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    return pytester


@pytest.fixture(scope="module")
def failure():
    return failure_of(generate("trap", 0, shape="U"), Scenario("turn-right"))


@pytest.fixture
def corpus(project, failure):
    folder = project.mkdir("failures")
    failure.write(folder / "loop.grid")
    return folder


def pytest_run(project, *args):
    return project.runpytest_subprocess("-W", "error", *args)


@pytest.mark.gate
def test_a_stored_failure_fails_until_it_is_fixed_and_shows_its_world(project, corpus):
    done = pytest_run(project, "--worldgen-corpus", "failures")
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines([
        "worldgen: *failures, expected: fixed",
        "turn-right under swept: loop forever (*), but the target can be reached",
        "*- worldgen -*",
        "##############*",
        "S start  G target*",
        "world:  .pytest_cache/d/worldgen/loop-fixed-*.grid",
        "replay: worldgen replay .pytest_cache/d/worldgen/loop-fixed-*.grid",
        "FAILED failures/loop.grid::fixed - turn-right*",
    ])  # fmt: skip
    done.stdout.no_fnmatch_line("*Traceback*")
    [kept] = (project.path / ".pytest_cache/d/worldgen").iterdir()
    assert replay(Failure.read(kept)).confirmed


@pytest.mark.nightly
def test_ini_settings_collect_a_corpus_and_name_a_controller_when_no_path_is_named(project, corpus):
    project.makeini(
        "[pytest]\nworldgen_corpus = failures\nworldgen_controller = bug2\ntestpaths = tests"
    )
    test = project.mkdir("tests") / "test_own.py"
    test.write_text("def test_own(): pass")
    pytest_run(project).assert_outcomes(passed=2)
    pytest_run(project, "tests").assert_outcomes(passed=1)


MARKED = """
    import pytest

    @pytest.mark.worldgen(family="trap", controller="turn-right", count=2, seed=3, shape="U")
    def test_arrives(worldgen_episode):
        assert worldgen_episode.verdict == "reached"

    @pytest.mark.worldgen(family=["trap", "corridor"], count=1)
    def test_is_small(worldgen_world):
        assert worldgen_world.width < 100
"""


@pytest.mark.nightly
def test_marked_tests_and_corpora_run_and_show_what_fails_also_under_xdist(project, corpus):
    project.makepyfile(test_it=MARKED)
    project.makeini(
        "[pytest]\nworldgen_corpus = failures\nworldgen_artifacts = kept\naddopts = "
        "--strict-markers"
    )
    done = pytest_run(project, "-n", "2", "--worldgen-expect", "confirmed", "--junitxml", "out.xml")
    done.assert_outcomes(passed=3, failed=2)
    done.stdout.fnmatch_lines(
        ["*- worldgen -*", "turn-right under swept: loop*", "replay: worldgen replay kept/*"]
    )
    assert len(list((project.path / "kept").iterdir())) == 2
    report = (project.path / "out.xml").read_text()
    assert (
        'name="worldgen.replay" value="worldgen replay kept/test-it-test-arrives-trap-3-' in report
    )


WRONG = {
    'mark.worldgen(family="trap")\ndef test_it(): pass': "add the argument worldgen_world",
    "mark.filterwarnings('error')\ndef test_it(worldgen_world): "
    "pass": 'add @pytest.mark.worldgen(family="trap")',
    "mark.worldgen('trap')\ndef test_it(worldgen_world): "
    "pass": "takes keyword arguments only, not 'trap'; write family='trap'",
    "mark.worldgen(count=3)\ndef test_it(worldgen_world): "
    "pass": 'family=None does not name a family; write family="trap"',
    "mark.worldgen(family='trap', count=0)\ndef test_it(worldgen_world): "
    "pass": "count=0 is not a whole number from 1",
    "mark.worldgen(family='trap', controller=3)\ndef test_it(worldgen_world): pass": "controller=3",
    "mark.worldgen(family='trapp', count=1)\ndef test_it(worldgen_world): "
    "pass": "did you mean 'trap'?",
    "mark.worldgen(family='trap', count=1)\ndef test_it(worldgen_episode): pass": "add controller=",
}


@pytest.mark.gate
def test_a_wrong_mark_is_answered_by_one_sentence(project):
    for number, test in enumerate(WRONG):
        Path(f"test_{number}.py").write_text(f"import pytest\n@pytest.{test}\n")
    done = pytest_run(project, "--continue-on-collection-errors")
    assert [sentence for sentence in WRONG.values() if sentence not in done.stdout.str()] == []
    done.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.gate
def test_wrong_settings_are_usage_errors(project):
    done = pytest_run(project, "--worldgen-corpus", "nowhere")
    assert done.ret == pytest.ExitCode.USAGE_ERROR
    done.stderr.fnmatch_lines(
        ["ERROR: the corpus *nowhere is not a folder; create it, or use another --worldgen-corpus"]
    )
    project.makeini("[pytest]\nworldgen_expect = maybe")
    assert "'maybe' is not valid; write fixed or confirmed" in pytest_run(project).stderr.str()


@pytest.mark.gate
def test_a_broken_file_in_a_corpus_fails_as_a_test_with_one_sentence(project):
    (project.mkdir("failures") / "broken.grid").write_text("no world\n")
    done = pytest_run(project, "failures/broken.grid")
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*broken.grid:1: *"])
    done.stdout.no_fnmatch_line("*Traceback*")


@pytest.mark.nightly
def test_words_of_a_stranger_cannot_steer_the_terminal(project, failure):
    strange = failure.driven_by("\x1b[2J\0|<b>")
    strange.write(project.mkdir("failures") / "strange.grid")
    project.makepyfile(
        loud="class Loud:\n    act = print\n    def reset(self): raise "
        "ValueError('\x1b[2J\ufffe')\n"
    )
    for more in ((), ("--worldgen-controller", "./loud.py:Loud")):
        done = pytest_run(project, "failures/strange.grid", "--junitxml=out.xml", *more)
        done.assert_outcomes(failed=1)
        assert "\x1b" not in done.stdout.str()
        ElementTree.parse(project.path / "out.xml")


@pytest.mark.gate
def test_where_the_plugin_is_not_used_it_imports_and_writes_nothing(project):
    project.makepyfile("""
        import sys

        def test_light():
            assert "worldgen_plugins.for_pytest" in sys.modules
            assert not {"numpy", "numba", "worldgen", "sim", "fuzz", "hypothesis"} & set(sys.modules)
    """)
    pytest_run(project).assert_outcomes(passed=1)
    assert not (project.path / ".pytest_cache/d").exists()


@pytest.mark.gate
def test_a_project_with_a_folder_of_a_name_of_ours_still_runs(project):
    project.makepyfile(test_it="def test_it(): pass", **{"fuzz/__init__": "", "sim/__init__": ""})
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "test_it.py"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert "1 passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.gate
def test_the_plugin_can_be_left_out(project, corpus):
    assert (
        pytest_run(project, "-p", "no:worldgen", "--co").ret == pytest.ExitCode.NO_TESTS_COLLECTED
    )


@pytest.mark.gate
def test_the_document_names_every_setting(project):
    named = set(
        re.findall(
            r"--worldgen-[a-z]+|worldgen_(?!world|episode)[a-z]+",
            pytest_run(project, "--help").stdout.str(),
        )
    )
    assert len(named) == 8 and [name for name in named if name not in DOCUMENT] == []


@pytest.mark.parametrize("package", ["worldgen", "sim", "fuzz", "corpora", "worldgen_plugins"])
def test_pytest_does_not_warn_that_a_package_was_imported_before_it_could_rewrite_it(package):
    assert "PYTEST_DONT_REWRITE" in importlib.import_module(package).__doc__


@pytest.mark.gate
def test_code_outside_the_rootdir_needs_a_reason(project, failure, tmp_path, monkeypatch):
    """The rootdir is trusted, as its conftest.py is; a record elsewhere names code as any other."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    code = "open('mark', 'a').write('ran')\nclass X:\n    reset = act = None\n"
    inside = project.makepyfile(robot=code)
    outside = tmp_path / "elsewhere" / "w.grid"
    outside.parent.mkdir()
    failure.driven_by(f"{outside.parent}/robot.py:X").write(outside)
    (outside.parent / "robot.py").write_text(code)
    done = pytest_run(project, "--rootdir", project.path, outside)
    done.stdout.fnmatch_lines(["*robot.py:X', which is not run*"])
    assert not (project.path / "mark").exists()
    failure.driven_by("./robot.py:X").write(project.path / "w.grid")
    pytest_run(project, "w.grid")
    assert inside.exists() and (project.path / "mark").exists()
