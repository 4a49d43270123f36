"""Run the jobs of a GitHub workflow here: every ``run`` with bash, including our action's.

Other actions are not run.
"""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
NAME = re.compile(r"'[^']*'|[a-z_]+(?:\.[\w-]+)+")
BASH = ("bash", "--noprofile", "--norc", "-eo", "pipefail", "-c")


def load(path):
    """Read a workflow or an action, with ``on`` as text and not as a boolean."""
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


@dataclass
class Job:
    """A job in a folder: the output of its steps, and whether it has failed.

    Args:
        folder: The workspace.
        action: The composite action behind ``uses: ./.worldgen``, in the root of this repository.
        known: Values of contexts by name: ``github.event_name``.
        env: Variables for every step that override the workflow's.
    """

    folder: Path
    action: dict
    known: dict = field(default_factory=dict)
    env: dict = field(default_factory=dict)
    failed: bool = False
    log: str = ""
    ran: list = field(default_factory=list)

    @property
    def summary(self):
        file = self.folder / ".summary.md"
        return file.read_text(encoding="utf-8") if file.exists() else ""

    def run(self, steps):
        """Runs steps, each if its condition holds."""
        for step in steps:
            condition = (
                str(step.get("if", "success()")).removeprefix("${{").removesuffix("}}").strip()
            )
            if "cancelled()" not in condition and self.failed:
                continue
            if self.value(condition):
                self.step(step)
        return self

    def step(self, step):
        """Run one step: a script, or our action; for others, only record the name."""
        self.ran.append(step.get("name", step.get("uses", "")))
        if "run" in step and "pip install" not in step["run"]:
            self.script(step)
        elif step.get("uses") == "./.worldgen":
            given = {name: self.filled(str(text)) for name, text in step.get("with", {}).items()}
            self.known |= {
                f"inputs.{name}": one.get("default", "")
                for name, one in self.action["inputs"].items()
            }
            self.known |= {f"inputs.{name}": text for name, text in given.items()}
            before, self.failed = (
                self.failed,
                False,
            )  # steps of an action ask for the action's success, not the job's
            self.run(self.action["runs"]["steps"])
            self.failed |= before
            for name, output in self.action["outputs"].items():
                self.known[f"steps.{step.get('id')}.outputs.{name}"] = self.filled(output["value"])

    def script(self, step):
        """Runs a script with bash, and reads the outputs that it sets."""
        outputs = self.folder / ".outputs"
        outputs.write_text("")
        files = {"GITHUB_OUTPUT": outputs, "GITHUB_STEP_SUMMARY": self.folder / ".summary.md"}
        env = (
            os.environ
            | {name: self.filled(str(text)) for name, text in step.get("env", {}).items()}
            | self.env
        )
        temporary = self.folder.with_name("runner-temp")
        temporary.mkdir(exist_ok=True)
        places = {
            "GITHUB_WORKSPACE": self.folder,
            "GITHUB_ACTION_PATH": ROOT,
            "RUNNER_TEMP": temporary,
        }
        env |= {name: str(path) for name, path in (files | places).items()}
        env |= {"RUNNER_OS": "Linux", "RUNNER_ARCH": "X64"}
        env["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{env['PATH']}"
        done = subprocess.run(
            [*BASH, step["run"]],
            cwd=self.folder,
            env=env,
            capture_output=True,
            text=True,
            check=False,
        )
        self.log += done.stdout + done.stderr
        self.failed |= done.returncode != 0
        for line in outputs.read_text().splitlines():
            name, _, text = line.partition("=")
            self.known[f"steps.{step.get('id')}.outputs.{name}"] = text

    def filled(self, text):
        """Return a text with its expressions replaced by their values."""
        return re.sub(r"\$\{\{(.*?)\}\}", lambda found: str(self.value(found[1])), text)

    def value(self, expression):
        """Return the value of an expression; an unknown name is empty."""
        python = NAME.sub(
            lambda found: found[0] if found[0][0] == "'" else f"known({found[0]!r})", expression
        )
        python = re.sub(
            "!(?!=)", " not ", python.replace("&&", " and ").replace("||", " or ")
        ).strip()
        functions = {"cancelled": lambda: False, "success": lambda: not self.failed}
        return eval(python, functions | {"known": lambda name: self.known.get(name, "")})
