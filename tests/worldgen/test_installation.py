"""Messages name the place that worldgen was installed from, because it may not be in a package
index.
"""

import json
from importlib.metadata import PathDistribution

import pytest

from worldgen.plugins import installation
from worldgen.plugins.installation import origin, pip_install, requirement


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Pretend that worldgen was installed with this record of its origin, which may be None or
    damaged.
    """

    def pretend(record):
        checkout = tmp_path / "checkout.egg-info"
        site = tmp_path / "worldgen-1.0.dist-info"
        for folder in (checkout, site):
            folder.mkdir()
            (folder / "METADATA").write_text(
                "Metadata-Version: 2.1\nName: worldgen\nVersion: 1.0\n"
            )
        if record is not None:
            text = record if isinstance(record, str) else json.dumps(record)
            (site / "direct_url.json").write_text(text)
        found = [PathDistribution(checkout), PathDistribution(site)]
        monkeypatch.setattr(installation, "distributions", lambda name: found)

    return pretend


def test_from_an_index_the_name_is_enough(installed):
    installed(None)
    assert pip_install("studio") == "pip install 'worldgen[studio]'"


def test_from_a_repository_it_is_the_same_commit(installed):
    installed(
        {
            "url": "https://github.com/owner/worldgen.git",
            "vcs_info": {"vcs": "git", "commit_id": "abc123"},
        }
    )
    assert requirement("gym") == "worldgen[gym] @ git+https://github.com/owner/worldgen.git@abc123"
    assert origin().github == "owner/worldgen"


def test_another_host_is_not_taken_for_github(installed):
    installed(
        {
            "url": "https://example.org/github.com/owner/worldgen",
            "vcs_info": {"commit_id": "abc123"},
        }
    )
    assert origin().github == ""


def test_from_a_checkout_it_is_that_folder(installed, tmp_path):
    folder = tmp_path / "my checkout"
    folder.mkdir()
    installed({"url": folder.as_uri(), "dir_info": {"editable": True}})
    assert pip_install("studio") == f"pip install -e '{folder}[studio]'"


@pytest.mark.parametrize("kind", ["dir_info", "archive_info"])
def test_a_place_that_is_gone_is_not_named(kind, installed, tmp_path):
    installed({"url": (tmp_path / "gone").as_uri(), kind: {}})
    assert requirement("studio") == "worldgen[studio]"


def test_an_archive_on_a_server_is_named(installed):
    installed({"url": "https://example.org/worldgen.whl", "archive_info": {}})
    assert requirement() == "worldgen @ https://example.org/worldgen.whl"


@pytest.mark.parametrize(
    "text",
    ["", "no JSON", "[]", '{"url": 1, "vcs_info": 2}', '{"url": "file://[", "dir_info": {}}'],
)
def test_a_damaged_record_is_no_obstacle(text, installed):
    installed(text)
    assert requirement("studio").startswith("worldgen[studio]")
