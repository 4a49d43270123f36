"""What the README shows works, command by command and line by line."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen
from tests.repo.readme_command import commands

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SHORTER = {"--budget 30s": "--units 1 --workers 1"}  # the same command, a few seconds of it
FAILURE_FOUND = ("run", "fuzz")  # these may end with 1: a failure was found


def console_lines():
    blocks = re.findall(r"```console\n(.*?)```", README, flags=re.DOTALL)
    return [
        line.removeprefix("$ worldgen ") for block in blocks for line in block.splitlines() if line.startswith("$ ")
    ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder that looks like a fresh clone, with the README's own controller in it."""
    place = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "corpora", place / "corpora")
    code = next(block for block in re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL) if "# mine.py" in block)
    (place / "mine.py").write_text(code)
    return place


def test_two_commands_do_the_set_up():
    first, second = commands(README)
    assert first.endswith("worldgen demo --out demo") and second.endswith("python -m pytest -n auto")


@pytest.mark.parametrize("line", console_lines())
def test_a_command_of_the_readme_works(line, folder, monkeypatch):
    monkeypatch.chdir(folder)
    for long, short in SHORTER.items():
        line = line.replace(long, short)
    result = worldgen(*shlex.split(line))
    allowed = (0, 1) if line.startswith(FAILURE_FOUND) else (0,)
    assert result.code in allowed, result.err


def test_the_python_example_of_the_readme_works(capsys):
    code = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)[-1]
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


def test_every_local_link_of_the_readme_leads_somewhere():
    links = re.findall(r"\]\(([^)#:]+)\)", README)
    assert links and all((ROOT / link).exists() for link in links)
