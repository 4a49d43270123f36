import pytest


@pytest.mark.worldgen(family=["corridor", "trap", "rooms"], controller="./robot.py:Robot", count=3)
def test_the_robot_arrives(worldgen_episode):
    assert worldgen_episode.verdict == "reached"
