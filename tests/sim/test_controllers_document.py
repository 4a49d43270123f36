"""docs/controllers.md: its commands work, print what it says, and its tables are those of the code."""

import io
import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from sim import Observation, RunOptions, simulate
from sim.commands.new_controller import new_controller
from sim.controllers.process import ProcessController, observation_line, read_command
from sim.examples.python import Example
from sim.host import serve
from tests.helpers.command_line import worldgen
from worldgen import generate

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "controllers.md").read_text(encoding="utf-8")
SHORTER = {
    "--units 1": "--units 1 --no-shrink --workers 1",
    "other.py --units 1": "other.py --units 1 --examples 40",
    "cmd:python ": f"cmd:{sys.executable} ",
}
DIGEST = re.compile(", trace [0-9a-f]{16}$")


def commands():
    """Commands, each with the lines that it is said to print."""
    found = []
    for line in "".join(re.findall(r"```console\n(.*?)```", TEXT, flags=re.DOTALL)).splitlines():
        if line.startswith("$ "):
            found.append((line.removeprefix("$ "), []))
        else:
            found[-1][1].append(line)
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("document")
    shutil.copy(ROOT / "tests" / "data" / "controllers" / "bounce.c", place)
    return place


def typed(line):
    for long, short in SHORTER.items():
        line = line.replace(long, short)
    program, *words = shlex.split(line)
    if program == "cc":
        if shutil.which("cc") is None:
            pytest.skip("there is no C compiler here (cc): the document's program in C is not built")
        subprocess.run([program, *words], check=True)
        return ""
    if words[0] == "new-controller":
        return CliRunner().invoke(new_controller, words[1:], catch_exceptions=False).stdout
    result = worldgen(*words)
    assert result.code in ((0, 1) if words[0] == "fuzz" else (0,)), result.err
    return result.out


@pytest.mark.parametrize(("line", "said"), [pytest.param(*command, id=command[0]) for command in commands()])
def test_a_command_of_the_document_does_what_it_says(line, said, folder, monkeypatch):
    monkeypatch.chdir(folder)
    if line.endswith("cmd:./bounce") and not Path("bounce").exists():
        pytest.skip("there is no C compiler here (cc): the document's program in C is not built")
    printed = [DIGEST.sub("", text) for text in typed(line).splitlines()]
    if "fuzz" not in line and "failures/" not in line:
        on_stdout = [DIGEST.sub("", text) for text in said if not text.startswith("wrote ") and "witness" not in text]
        assert [text for text in on_stdout if text not in printed] == []


def put_in_the_bug(path):
    bug = re.search(r"`(self\.top_speed \* math\..*)`", TEXT)[1]
    path.write_text(path.read_text().replace('"speed": self.top_speed', f'"speed": {bug}'))


@pytest.mark.gate
def test_the_bug_of_the_document_is_found(folder, monkeypatch):
    monkeypatch.chdir(folder)
    CliRunner().invoke(new_controller, ["buggy", "--kind", "process"], catch_exceptions=False)
    put_in_the_bug(Path("buggy.py"))
    options = ("--units", 1, "--examples", 24, "--seed", 1, "--workers", 1, "--no-shrink")
    found = worldgen("fuzz", "--controller", "cmd:./buggy.py", *options, "--out", "bug").out
    kind = re.search(r"class (crash-\S+),", TEXT)[1].replace("other.", "buggy.")
    assert "crash (exit code 1 in step" in found and f"class {kind}" in found


def test_the_document_names_every_field_of_an_observation():
    table = TEXT.partition("| field | unit |")[2].partition("\n\n")[0]
    names = [name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert tuple(names) == Observation._fields


def test_the_lines_of_the_document_are_lines_of_the_protocol():
    reset, seen, answer = re.findall(r"```json\n\s*(\{.*\})\n\s*```", TEXT)
    observation = Observation(**json.loads(seen))
    assert observation_line(observation).decode().strip() == seen
    assert read_command(answer.encode()).speed == json.loads(reset)["reset"]["top_speed"]
    serve(Example(), io.BytesIO(f"{reset}\n{seen}\n".encode()), answers := io.BytesIO())
    assert read_command(answers.getvalue()).speed == observation.top_speed


def test_the_limits_of_the_document_are_the_defaults():
    limits = ProcessController(["sh"]).limits
    rows = re.findall(r"\| `\+(?:deadline|start|memory)=.*\| (\S+) \|", TEXT)
    assert rows == [f"{limits.deadline:g}", f"{limits.start_deadline:g}", f"{(limits.memory or 0) >> 30}G"]


def test_the_kinds_of_evidence_are_those_of_the_document():
    rows = dict(re.findall(r"\| `(crash|hang|invalid-command)` \|(.*)", TEXT))
    for verdict, script in {"crash": "read l; exit 3", "hang": "read l; sleep 9", "invalid-command": "yes"}.items():
        with ProcessController(["sh", "-c", f"echo oops >&2; {script}"], start_deadline=0.5) as controller:
            episode = simulate(generate("trap", 4, size=20), controller, RunOptions(steps=9))
        assert episode.verdict == verdict and all(f"`{key}`" in rows[verdict] for key in episode.evidence)
