"""Check the README's statements besides its console commands.

``test_documented_commands.py`` runs the commands.
"""

import re
from pathlib import Path

from tests.repo.readme_command import commands, python_example

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_two_commands_do_the_set_up():
    first, second = commands(README)
    assert first.endswith("worldgen demo --out demo") and second.endswith(
        "python -m pytest -n auto"
    )


def test_the_python_example_of_the_readme_works(capsys):
    exec(compile(python_example(README), "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


def test_every_local_link_of_the_readme_leads_somewhere():
    links = re.findall(r"\]\(([^)#:]+)\)", README)
    assert links and all((ROOT / link).exists() for link in links)
