"""Every process of the studio runs an edited controller's current version, never an earlier one."""

import asyncio
import os

import pytest

from fuzz.studio import Folder
from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.requests import edits
from fuzz.studio.requests.edits import UNKNOWN, digest_of_file, edited_files, loaded_files
from fuzz.studio.requests.protocol import Edits
from fuzz.studio.requests.refusals import frames_of
from sim.controllers import CONTROLLERS
from tests.helpers.raising import raises
from tests.helpers.studio import message_of, page_of, sent, studio_of
from worldgen import generate
from worldgen.errors import InvalidParameter

SPINS = """
from gains import TURN

class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return (0.0, TURN), memory
"""


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "mine.py").write_text(SPINS)
    (tmp_path / "gains.py").write_text("TURN = 0.1\n")
    return tmp_path / "mine.py"


@pytest.fixture
def gate(robot):
    with studio_of(robot.parent, named=[f"{robot}:Robot"]) as gate:
        yield gate


def run_once(page, robot):
    """The part of the robot in the answer to ``run``."""
    message = {"world": message_of(generate("corridor", 3)), "motion": "swept", "time_step": 0.015}
    said = page.ask("run", **message, seed=0, options={}, controllers=[f"{robot}:Robot"], steps=50)
    return said["parts"][-1]


def edit(file, text):
    """Write a file without changing its size or its time."""
    facts = file.stat()
    file.write_text(text)
    os.utime(file, ns=(facts.st_atime_ns, facts.st_mtime_ns))


def test_a_file_that_is_edited_within_a_second_is_compiled_again(robot):
    name = f"{robot}:Robot"
    observation = None
    for turn in ("0.1", "0.2", "0.3"):
        edit(robot.parent / "gains.py", f"TURN = {turn}\n")
        command, _ = CONTROLLERS.get(name).act(observation, ())
        assert command[1] == float(turn)
        CONTROLLERS.forget(str(robot))
    assert not (robot.parent / "__pycache__").exists()


def test_every_file_that_a_controller_imports_is_known_with_what_was_read_of_it(robot):
    CONTROLLERS.get(f"{robot}:Robot")
    helper = robot.parent / "gains.py"
    loaded = {
        file: digest for file, digest in loaded_files(0.0).items() if str(robot.parent) in file
    }
    assert set(loaded) == {str(robot), str(helper)} and edited_files(loaded) == []
    helper.touch()
    assert edited_files(loaded) == []
    edit(helper, "TURN = 0.5\n")
    assert edited_files(loaded) == [str(helper)]


def test_code_that_was_read_during_an_edit_counts_as_edited(robot):
    assert edited_files({str(robot): UNKNOWN}) == [str(robot)]


def test_a_file_is_read_again_only_after_a_change(robot, monkeypatch):
    reads = []
    digest = edits.digest_of_source
    monkeypatch.setattr(edits, "digest_of_source", lambda data: reads.append(1) or digest(data))
    later = robot.stat().st_ctime + 10
    monkeypatch.setattr(edits.time, "time", lambda: later)
    before = [digest_of_file(str(robot)) for _ in range(3)]
    assert len(set(before)) == 1 and len(reads) == 1
    edit(robot, SPINS.replace("0.0", "0.1"))
    assert digest_of_file(str(robot)) != before[0] and len(reads) == 2


def test_a_file_that_was_just_written_is_read_at_each_look(robot, monkeypatch):
    monkeypatch.setattr(edits.time, "time", lambda: robot.stat().st_ctime)
    before = digest_of_file(str(robot))
    edit(robot, SPINS.replace("0.0", "0.1"))
    assert digest_of_file(str(robot)) != before


def edits_of(named, loaded):
    return Watching(Folder("."), named, loaded).ask(Edits(id=0))


def test_a_file_of_a_sibling_folder_is_not_next_to_the_controller(tmp_path):
    names = {}
    for folder in ("robot", "robot-old"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(SPINS)
        names[folder] = f"{tmp_path}/{folder}/mine.py:Robot"
    helper = tmp_path / "robot-old" / "gains.py"
    helper.write_text("TURN = 0.1\n")

    async def first():
        heard = edits_of(list(names.values()), lambda: [str(helper)])
        _, part, _ = await anext(heard)
        await heard.aclose()
        return sent(part)

    shown = {one["name"]: one["controllers"] for one in asyncio.run(first())}
    assert shown["gains.py"] == [names["robot-old"]]


@pytest.mark.parametrize(
    ("text", "line", "code"),
    [
        ("class Robot:\n    def act(self:\n", 2, "def act(self:"),
        ("LIMIT = 3\nSPEED = 1 / (LIMIT - 3)\n", 2, "SPEED = 1 / (LIMIT - 3)"),
        ("import gains\n", 1, "TURN = missing"),
    ],
)
def test_a_fault_names_the_file_the_line_and_the_code(robot, text, line, code):
    (robot.parent / "gains.py").write_text("TURN = missing\n")
    robot.write_text(text)
    with raises(InvalidParameter, "code-failed") as caught:
        CONTROLLERS.get(f"{robot}:Robot")
    frame = frames_of(caught.value)[-1]
    assert (frame["line"], frame["code"]) == (line, code)
    assert frame["file"] in ("mine.py", "gains.py")


def test_a_page_hears_of_an_edit_once_the_file_stays_as_it_is(robot):
    label = f"{robot}:Robot"

    async def listen():
        heard = edits_of([label], lambda: [str(robot.parent / "gains.py")])
        _, first, _ = await anext(heard)
        robot.write_text("")
        robot_turns = [await anext(heard)]
        robot.write_text(SPINS + "# edited\n")
        while robot_turns[-1][0] == "turn":
            robot_turns.append(await anext(heard))
        await heard.aclose()
        return sent(first), sent(robot_turns[-1][1])

    before, after = asyncio.run(listen())
    assert [one["name"] for one in before] == ["gains.py", "mine.py"]
    assert all(one["controllers"] == [label] for one in before)
    assert before[0] == after[0]
    assert after[1]["digest"] == digest_of_file(str(robot))


@pytest.mark.gate
def test_each_run_is_of_the_code_as_it_is_now(gate, robot):
    with page_of(gate) as page:
        first = run_once(page, robot)
        edit(robot.parent / "gains.py", "TURN = 0.2\n")
        second = run_once(page, robot)
        robot.write_text("class Robot:\n    def act(self:\n")
        broken = run_once(page, robot)
        robot.write_text(SPINS.replace("TURN)", "1 / 0)"))
        crashed = run_once(page, robot)
        robot.write_text(SPINS)
        edit(robot.parent / "gains.py", "TURN = 0.1\n")
        assert run_once(page, robot)["digest"] == first["digest"] != second["digest"]
    assert broken["error"]["code"] == "code-failed"
    assert broken["error"]["frames"][-1] == {"file": "mine.py", "line": 2, "code": "def act(self:"}
    assert crashed["verdict"] == "crash"
    assert crashed["frames"][-1]["code"] == "return (0.0, 1 / 0), memory"


def test_a_file_of_a_behaviour_names_only_the_compositions_that_contain_it(robot):
    named = [f"behaviours+by=vote:avoid,{robot}:Robot+priority=2", "behaviours:avoid,wander"]

    async def first():
        async for _, part, _ in edits_of(named, tuple):
            return sent(part)

    (entry,) = asyncio.run(first())
    assert (entry["file"], entry["controllers"]) == (str(robot), [f"{robot}:Robot"])
