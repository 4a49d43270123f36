"""The commands in docs/howto/sets.md work."""

import re
import shlex
from pathlib import Path

import pytest

from tests.helpers.command_line import worldgen

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "sets.md").read_text(encoding="utf-8")
FEWER = ("--count 10000", "--count 8 --size 20")


@pytest.mark.gate
def test_the_commands_of_the_page_work_one_after_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = re.findall(r"^\$ worldgen (.*)$", PAGE, re.MULTILINE)
    assert len(lines) == 7
    for line in lines:
        result = worldgen(*shlex.split(line.replace(*FEWER)))
        assert result.code == 0, result.err
    assert (tmp_path / "again.zip").read_bytes() == (tmp_path / "mazes.zip").read_bytes()


@pytest.mark.nightly
@pytest.mark.parametrize("number", [0, 1])
def test_its_python_works(number, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[number]
    exec(compile(code, "sets.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) == (100, 20)[number]
