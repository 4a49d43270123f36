"""The example of a project's CI.

Its workflow and our action run here step for step, as GitHub would run them.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.ci_reports import read_junit, read_markdown, read_sarif
from tests.helpers.command_line import worldgen
from tests.helpers.workflow import Job, load

pytestmark = pytest.mark.gate

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "ci"
WORKFLOW = ".github/workflows/worldgen.yml"
QUICK = {
    "controller": "./robot.py:Robot",
    "families": "rooms",
    "units": "1",
    "seed": "1",
    "install": "false",
}


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A copy of the example, as checked out on GitHub."""
    return checked_out(tmp_path, monkeypatch)


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """The job of a pull request after which the robot turns back to walls in too wide a curve."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        project = checked_out(tmp_path_factory.mktemp("broken"), monkeypatch)
        source = (project / "robot.py").read_text(encoding="utf-8")
        assert "BACK = 0.5" in source
        (project / "robot.py").write_text(
            source.replace("BACK = 0.5", "BACK = 0.1"), encoding="utf-8"
        )
        return job(project, "pull-request", **QUICK)


def checked_out(folder, monkeypatch):
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.delenv("GITHUB_WORKSPACE", raising=False)
    shutil.copytree(
        EXAMPLE, folder / "project", ignore=shutil.ignore_patterns("__pycache__", ".*_cache")
    )
    monkeypatch.chdir(folder / "project")
    return folder / "project"


def job(project, name, **inputs):
    """Run a job of the workflow, optionally with other inputs for our action."""
    event = "pull_request" if name == "pull-request" else "schedule"
    plan = load(project / WORKFLOW)["jobs"][name]
    for step in plan["steps"]:
        if step.get("uses") == "./.worldgen":
            step["with"] |= inputs
    known = {"github.event_name": event, "github.workspace": str(project), "runner.os": "Linux"}
    done = Job(project, load(ROOT / "action.yml"), known, {})
    assert done.value(plan["if"])
    return done.run(plan["steps"])


def action(project, **inputs):
    """Run only our action."""
    done = Job(project, load(ROOT / "action.yml"), {}, {})
    return done.run([{"uses": "./.worldgen", "id": "worldgen", "with": QUICK | inputs}])


def outputs(done, *names):
    return [done.known[f"steps.worldgen.outputs.{name}"] for name in names]


@pytest.mark.gate
def test_a_good_robot_passes(project):
    done = job(project, "pull-request", **QUICK)
    assert not done.failed, done.log
    assert "worldgen fuzz: no new failure" in done.summary and outputs(done, "failures") == ["0"]
    assert read_sarif(Path("worldgen-failures/worldgen.sarif").read_bytes())["results"] == []


@pytest.mark.gate
def test_a_pull_request_that_breaks_the_robot_shows_the_world_that_breaks_it(broken, monkeypatch):
    monkeypatch.chdir(broken.folder)
    rows, folds = read_markdown(broken.summary)
    assert broken.failed and "Keep the worlds, to replay them at home" in broken.ran, broken.log
    assert rows[0][0] == "new" and "S start  G target" in folds[0]
    assert (
        worldgen(*re.search("^replay: worldgen (.*)$", folds[0], re.MULTILINE)[1].split()).code == 0
    )


@pytest.mark.gate
def test_its_reports_lead_to_the_class_that_broke(broken):
    failures = broken.folder / "worldgen-failures"
    [new, *_] = read_sarif((failures / "worldgen.sarif").read_bytes())["results"]
    line = new["locations"][0]["physicalLocation"]["region"]["startLine"]
    assert (broken.folder / "robot.py").read_text(encoding="utf-8").splitlines()[
        line - 1
    ] == "class Robot:"
    assert (
        read_junit((failures / "worldgen.xml").read_bytes()).attrib["failures"]
        == outputs(broken, "failures")[0]
    )
    assert (failures / "report.html").stat().st_size > 10_000


def test_a_fixed_failure_that_comes_back_fails_as_a_test(broken):
    assert re.search(r"FAILED worldgen-corpus/fixed/.*\.grid::fixed", broken.log)


@pytest.mark.nightly
def test_classes_of_a_baseline_do_not_fail_the_job(broken, monkeypatch):
    monkeypatch.chdir(broken.folder)
    done = action(
        broken.folder,
        baseline="worldgen-corpus/known\nworldgen-failures",
        out="again",
        corpus="found",
    )
    assert not done.failed and outputs(done, "failures", "corpus-path") == ["0", "found"], done.log
    assert int(outputs(done, "known")[0]) > 0 and not list(
        (broken.folder / "found").rglob("*.grid")
    )


@pytest.mark.nightly
def test_the_nightly_search_ends_well_and_replays_what_is_known(project):
    done = job(project, "nightly", **QUICK)
    assert not done.failed, done.log
    assert "3 of 3 confirmed" in done.summary and outputs(done, "corpus-path") == ["worldgen-found"]


HOSTILE = "x'\"; touch pwned; $(touch pwned) `touch pwned` \\"


@pytest.mark.parametrize(
    "name", ["controller", "motion", "families", "units", "seed", "fail-on", "baseline"]
)
def test_no_input_is_run_as_a_command(name, project):
    done = action(project, **{name: HOSTILE})
    assert done.failed and not list(project.rglob("pwned")) and "Traceback" not in done.log


def test_a_folder_of_any_name_is_taken_as_it_is(project):
    done = action(project, out=HOSTILE.replace("/", ""), units="1", families="trap")
    assert (
        not done.failed
        and (project / HOSTILE / "summary.md").exists()
        and not list(project.rglob("pwned"))
    )


def test_scripts_hold_no_expressions_and_actions_are_pinned():
    plan, workflow = load(ROOT / "action.yml"), load(EXAMPLE / WORKFLOW)
    steps = [
        *plan["runs"]["steps"],
        *(step for one in workflow["jobs"].values() for step in one["steps"]),
    ]
    assert all(step["shell"] == "bash" for step in plan["runs"]["steps"] if "run" in step)
    assert not [step for step in steps if "${{" in step.get("run", "")]
    foreign = {step["uses"] for step in steps if "uses" in step} - {"./.worldgen"}
    assert [name for name in foreign if not re.search("@[0-9a-f]{40}$", name)] == [
        "github/codeql-action/upload-sarif@v4"
    ]


WORKFLOWS = (
    f"examples/ci/{WORKFLOW}",
    *(f".github/workflows/{path.name}" for path in sorted((ROOT / ".github/workflows").iterdir())),
)
CHECKS = {
    "action": ("check-jsonschema", "--builtin-schema", "vendor.github-actions", "action.yml"),
    "workflows": ("check-jsonschema", "--builtin-schema", "vendor.github-workflows", *WORKFLOWS),
    "security": ("zizmor", "--offline", "--min-severity=medium", "action.yml", *WORKFLOWS),
}


@pytest.mark.gate
@pytest.mark.parametrize("check", CHECKS)
def test_linters_have_nothing_to_say(check):
    name, *options = CHECKS[check]
    program = shutil.which(
        name, path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    )
    if program is None:
        pytest.skip(f"NOT LINTED: there is no {name} here; pip install 'worldgen[dev]'")
    done = subprocess.run(
        [program, *options], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.nightly
def test_the_projects_own_campaign_finds_nothing(tmp_path):
    command = Path(sys.executable).with_name("worldgen")
    done = subprocess.run(
        [ROOT / ".ci" / "campaign", "1", tmp_path],
        env={**os.environ, "WORLDGEN": str(command)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "no failure of mapper under swept found" in done.stdout
    assert "run: .ci/run" in (ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")
