"""``worldgen init`` writes files that CI services and pytest read, and loses no user data."""

import shlex
import tomllib
from pathlib import Path

import pytest
import yaml

from fuzz.campaign.run import Campaign
from fuzz.ci import project as module
from fuzz.ci.project import FIXED, KNOWN, Project
from fuzz.failure import Failure
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidParameter, OutputError
from worldgen.plugins.installation import Origin

EXAMPLE = Path(__file__).parents[2] / "examples" / "ci"
ROBOT = "./robot.py:Robot"

RAISES = """
class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        raise ValueError("no idea")
"""


@pytest.fixture(autouse=True)
def from_an_index(monkeypatch):
    """Each test sets where worldgen comes from."""
    monkeypatch.setattr(module, "origin", Origin)


def test_the_example_s_workflow_is_what_init_writes(tmp_path):
    Project(tmp_path, ROBOT, families=("corridor", "trap", "rooms")).write(force=False)
    written = (tmp_path / ".github" / "workflows" / "worldgen.yml").read_text()
    assert written == (EXAMPLE / ".github" / "workflows" / "worldgen.yml").read_text()


def test_a_workflow_names_the_repository_that_worldgen_came_from(tmp_path, monkeypatch):
    monkeypatch.setattr(
        module, "origin", lambda: Origin("https://github.com/owner/worldgen", "abc123")
    )
    project = Project(tmp_path, ROBOT)
    project.write(force=False)
    plan = yaml.safe_load((tmp_path / ".github" / "workflows" / "worldgen.yml").read_text())
    sources = [
        step["with"]
        for step in plan["jobs"]["pull-request"]["steps"]
        if step.get("with", {}).get("repository")
    ]
    assert [(source["repository"], source["ref"]) for source in sources] == [
        ("owner/worldgen", "abc123")
    ]
    assert project.must_be_told_where_worldgen_is == ""


@pytest.mark.parametrize(
    "controller", [ROBOT, 'cmd:./robot --name "O\'Neill" #1', "package.module:Robot+radius=0.2"]
)
def test_a_controller_reaches_the_ci_file_as_it_is(controller, tmp_path):
    for ci in ("github", "gitlab"):
        Project(tmp_path / ci, controller, ci=ci).write(force=False)
    workflow = yaml.safe_load(
        (tmp_path / "github" / ".github" / "workflows" / "worldgen.yml").read_text()
    )
    uses = [
        step
        for step in workflow["jobs"]["pull-request"]["steps"]
        if step.get("uses") == "./.worldgen"
    ]
    assert [step["with"]["controller"] for step in uses] == [controller]
    job = yaml.safe_load((tmp_path / "gitlab" / ".gitlab" / "worldgen.yml").read_text())["worldgen"]
    words = shlex.split(job["script"][-1])
    assert words[words.index("--controller") + 1] == controller


def test_what_cannot_stand_in_a_workflow_is_refused(tmp_path):
    with raises(InvalidParameter, "not-for-a-ci-file"):
        Project(tmp_path, "cmd:./robot ${{ secrets.TOKEN }}").check(force=False)


def test_the_tables_follow_what_the_file_holds(tmp_path):
    before = '# mine\n[project]\nname = "robot"\n'
    (tmp_path / "pyproject.toml").write_text(before)
    Project(tmp_path, ROBOT, "endpoint").write(force=False)
    text = (tmp_path / "pyproject.toml").read_text()
    tool = tomllib.loads(text)["tool"]
    assert text.startswith(before)
    assert tool["worldgen"]["fuzz"] == {
        "controller": ROBOT,
        "motion": "endpoint",
        "baseline": [str(KNOWN)],
        "units": 6,
        "seed": 1,
    }
    assert tool["pytest"]["ini_options"] == {"worldgen_corpus": [str(FIXED)]}


def test_pytest_settings_of_the_user_s_own_are_left_alone(tmp_path):
    (tmp_path / "pyproject.toml").write_text('[tool.pytest.ini_options]\ntestpaths = ["tests"]\n')
    project = Project(tmp_path, ROBOT)
    project.write(force=False)
    assert not project.runs_fixed_failures
    assert tomllib.loads((tmp_path / "pyproject.toml").read_text())["tool"]["pytest"] == {
        "ini_options": {"testpaths": ["tests"]}
    }


@pytest.mark.parametrize(
    ("name", "table"), [("tox.ini", "[pytest]"), ("setup.cfg", "[tool:pytest]"), ("pytest.ini", "")]
)
def test_pytest_settings_in_another_file_stay_in_force(name, table, tmp_path):
    (tmp_path / name).write_text(f"{table}\naddopts = -q\n")
    project = Project(tmp_path, ROBOT)
    project.write(force=False)
    assert not project.runs_fixed_failures
    assert "pytest" not in tomllib.loads((tmp_path / "pyproject.toml").read_text())["tool"]


def test_every_job_installs_the_project_s_own_requirements(tmp_path):
    (tmp_path / "requirements.txt").write_text("numpy\n")
    (tmp_path / "pyproject.toml").write_text('[build-system]\nrequires = ["setuptools"]\n')
    Project(tmp_path, ROBOT).write(force=False)
    plan = yaml.safe_load((tmp_path / ".github" / "workflows" / "worldgen.yml").read_text())
    for job in plan["jobs"].values():
        [install] = [step["run"] for step in job["steps"] if step.get("name") == "Install"]
        assert install.endswith("pytest ./.worldgen -r requirements.txt -e .")


def test_a_controller_without_a_name_is_refused(tmp_path):
    with raises(InvalidParameter, "empty-name"):
        Project(tmp_path, "").check(force=False)


def test_a_project_that_is_set_up_is_left_alone(tmp_path):
    Project(tmp_path, ROBOT, ci="none").write(force=False)
    with raises(OutputError, "file-exists"):
        Project(tmp_path, ROBOT, ci="none").check(force=False)
    with raises(OutputError, "already-set-up"):
        Project(tmp_path, ROBOT, ci="none").check(force=True)


def test_a_damaged_pyproject_is_refused_and_kept(tmp_path):
    (tmp_path / "pyproject.toml").write_text("[tool")
    with raises(FormatError, "invalid-toml"):
        Project(tmp_path, ROBOT).check(force=True)
    assert (tmp_path / "pyproject.toml").read_text() == "[tool"


def test_gitlab_s_own_file_is_not_touched(tmp_path):
    (tmp_path / ".gitlab-ci.yml").write_text("build: {script: [make]}\n")
    Project(tmp_path, ROBOT, ci="gitlab").write(force=False)
    assert (tmp_path / ".gitlab-ci.yml").read_text() == "build: {script: [make]}\n"


@pytest.mark.nightly
def test_after_init_the_search_of_a_pull_request_meets_no_new_class(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    robot = (EXAMPLE / "robot.py").read_text()
    (tmp_path / "robot.py").write_text(robot.replace("BACK = 0.5", "BACK = 0.1"))
    options = ("--controller", ROBOT, "--family", "rooms", "--units", "1")
    done = worldgen("init", *options)
    known = sorted(Path(KNOWN).glob("*.grid"))
    assert done.code == 0 and known and f"{KNOWN}: {len(known)} known failure" in done.out, done.err
    again = worldgen("fuzz", *options, "--seed", "1", "--baseline", KNOWN, "--out", "found")
    assert again.code == 0 and "no new failure" in again.out and "known: " in again.out


@pytest.mark.gate
def test_after_init_the_search_with_the_written_settings_meets_no_new_class(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.py").write_text(RAISES)
    done = worldgen("init", "--controller", ROBOT, "--family", "corridor", "--units", "1")
    assert done.code == 0 and f"{KNOWN}: 1 known failure" in done.out, done.err
    assert all(Failure.read(path).shrinking == "done" for path in Path(KNOWN).glob("*.grid"))
    again = worldgen("fuzz", "--out", "found", "--workers", 1)
    assert again.code == 0 and "no new failure" in again.out and "known: 1 cause" in again.out, (
        again.err
    )


def test_init_names_no_folder_that_goes_when_it_ends(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Campaign, "run", interrupted)
    (tmp_path / "robot.py").write_text(RAISES)
    done = worldgen("init", "--controller", ROBOT, "--units", "1")
    assert done.code == 130 and "interrupted; nothing was kept" in done.err
    assert "--resume" not in done.err and not (tmp_path / "pyproject.toml").exists()


@pytest.mark.gate
def test_the_project_is_complete_before_its_failures_are_shrunk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr("fuzz.shrink.queue.shrunk_or_same", interrupted_at_once)
    (tmp_path / "robot.py").write_text(RAISES)
    done = worldgen("init", "--controller", ROBOT, "--family", "corridor", "--units", "1")
    assert done.code == 130 and "the project is complete, and 1 known failure is not" in done.err
    (known,) = Path(KNOWN).glob("*.grid")
    assert Failure.read(known).shrinking == "none" and (tmp_path / "pyproject.toml").exists()


def interrupted_at_once(failure):
    raise KeyboardInterrupt


def interrupted(campaign):
    raise KeyboardInterrupt
    yield
