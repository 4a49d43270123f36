"""What makes a campaign the same one: its configuration, and the code that it depends on."""

import json
from dataclasses import replace

import pytest

from fuzz.campaign.store import fingerprint_of
from fuzz.campaign.store.fingerprint import config_of, digest_of_sources
from fuzz.layouts.variation import Variation
from sim.scenario import Scenario
from tests.fuzz.test_campaign_folder import CONFIG
from worldgen import generate


def test_a_configuration_comes_back_from_its_folder_as_it_was():
    vary = (Variation("robot_speed", (0.5, 1.0)),)
    scenario = Scenario.parse("turn-right+sensor_noise=0.1", motion="endpoint", time_step=0.03)
    config = replace(
        CONFIG,
        scenario=scenario,
        families=("trap",),
        vary=vary,
        fixed_map=generate("trap", 3),
        oracles=("detour=5",),
    )
    stored = json.loads(json.dumps(fingerprint_of(config).configuration))
    assert config_of(stored) == config


@pytest.mark.parametrize(
    ("file", "same"),
    [("fuzz/studio/page/campaign.js", True), ("fuzz/player/page/picture/map.js", True), ("fuzz/report/page.py", True),
     ("fuzz/core/looks.c", False), ("fuzz/_core.abi3.so", True), ("fuzz/studio_of_mine.py", False)],
)  # fmt: skip
def test_an_edit_of_what_shows_a_campaign_leaves_it_as_it_is_and_one_of_the_core_does_not(
    tmp_path, file, same
):
    (tmp_path / file).parent.mkdir(parents=True)
    (tmp_path / "fuzz/failure.py").write_text("")
    before = digest_of_sources([tmp_path / "fuzz"])
    (tmp_path / file).write_text("changed")
    assert (digest_of_sources([tmp_path / "fuzz"]) == before) is same
