"""docs/reference/controllers.md: its tables match the code.

Its commands run together with all documented commands.
"""

import io
import json
import re
from pathlib import Path

from sim import Observation, RunOptions, simulate
from sim.controllers.examples.python import Example
from sim.controllers.programs.process import ProcessController, observation_line, read_command
from sim.evidence import evidence_table
from sim.host.__main__ import serve
from worldgen import generate

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "reference" / "controllers.md").read_text(encoding="utf-8")


def test_the_document_names_every_field_of_an_observation():
    table = TEXT.partition("| field | unit |")[2].partition("\n\n")[0]
    names = [
        name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])
    ]
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
    assert rows == [
        f"{limits.deadline:g}",
        f"{limits.start_deadline:g}",
        f"{(limits.memory or 0) >> 30}G",
    ]


def test_the_kinds_of_evidence_are_those_of_the_document():
    rows = dict(re.findall(r"\| `(crash|hang|invalid-command)` \|(.*)", TEXT))
    for verdict, script in {
        "crash": "read l; exit 3",
        "hang": "read l; sleep 9",
        "invalid-command": "yes",
    }.items():
        with ProcessController(
            ["sh", "-c", f"echo oops >&2; {script}"], start_deadline=0.5
        ) as controller:
            episode = simulate(generate("trap", 4, size=20), controller, RunOptions(steps=9))
        assert episode.verdict == verdict and all(
            f"`{key}`" in rows[verdict] for key in evidence_table(episode.evidence)
        )
