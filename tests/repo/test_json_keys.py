"""The keys of ``--json`` that scripts rely on; new ones may be added, these stay."""

import json

import pytest

from tests.helpers.command_line import worldgen

KEYS = {
    "verify": {"result", "certificate_valid", "clearance", "radius"},
    "run": {"verdict", "steps", "time", "path_length", "collisions", "trace_digest", "evidence"},
    "audit": {"ok", "findings"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys")
    assert worldgen("trap", "--seed", 1, "--out", folder / "w.grid").code == 0
    worldgen("run", folder / "w.grid", "--controller", "turn-right", "--trace", folder / "t.csv")
    return folder


@pytest.mark.parametrize("command", KEYS)
def test_json_has_the_keys_that_scripts_rely_on(command, folder):
    more = {"run": ("--controller", "turn-right"), "audit": (folder / "t.csv",)}.get(command, ())
    answer = json.loads(worldgen(command, folder / "w.grid", *more, "--json").out)
    assert KEYS[command] <= set(answer)
