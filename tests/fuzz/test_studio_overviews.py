"""The order of failures on the studio's wall, and what it takes from campaigns' overviews."""

import json

from fuzz.cause import Cause
from fuzz.studio.campaigns.overviews import example_in, ranks
from tests.helpers.campaign_folder import LOOP, STALLED, campaign_folder, explain_the_loop

RETURNS = Cause.RETURNS_TO_A_WALL.value
WANDERS = Cause.WANDERS.value
UNSENSED = "harmed-by-what-it-cannot-sense"


def test_causes_come_by_severity_and_what_no_robot_can_sense_comes_last(tmp_path):
    causes = [UNSENSED, UNSENSED, WANDERS, "", RETURNS, Cause.GOES_THROUGH_A_WALL.value]
    order = ranks(causes, [tmp_path])
    assert sorted(set(causes), key=order.__getitem__) == [
        Cause.GOES_THROUGH_A_WALL.value,
        RETURNS,
        "",
        WANDERS,
        UNSENSED,
    ]


def test_among_equally_bad_causes_the_one_of_natural_worlds_comes_first(tmp_path):
    folder = campaign_folder(tmp_path / "c")
    explain_the_loop(folder, [])
    file = folder / ".campaign/overview.json"
    overview = json.loads(file.read_text())
    overview["causes"][0]["natural"] = 3
    file.write_text(json.dumps(overview))
    causes = [Cause.CIRCLES_AN_OBSTACLE.value] * 9 + [RETURNS]
    assert ranks(causes, [])[RETURNS] == 1
    assert ranks(causes, [folder])[RETURNS] == 0


def test_only_the_example_of_a_cause_is_explained(tmp_path):
    folder = campaign_folder(tmp_path / "c")
    assert example_in(folder / LOOP) is None
    explain_the_loop(folder, [{"what": "cell", "value": [2, 1]}])
    assert example_in(folder / LOOP).why == "arrives if some cell is free"
    assert example_in(folder / STALLED) is None


def test_an_overview_that_cannot_be_read_hides_no_failure(tmp_path):
    folder = campaign_folder(tmp_path / "c")
    (folder / ".campaign/overview.json").write_text("{")
    assert ranks([RETURNS], [folder]) == {RETURNS: 0, "": 0}
    assert example_in(folder / LOOP) is None
