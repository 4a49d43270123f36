"""The studio's campaigns: started, watched, stopped and resumed; the contents of their folders.

And what the studio refuses to run.
"""

import asyncio
import json
import os
import shlex
import signal
import subprocess
from dataclasses import replace
from types import SimpleNamespace

import pytest

from fuzz.campaign import store
from fuzz.campaign.configure import configure
from fuzz.campaign.run import Campaign
from fuzz.campaign.store import MEMORY
from fuzz.failure import Failure
from fuzz.overview.building import Conclusion, build_overview
from fuzz.shrink.snippet import snippet
from fuzz.studio import Folder
from fuzz.studio.campaigns.state import campaign_state
from fuzz.studio.campaigns.watching import Watching
from fuzz.studio.requests.protocol import Watch
from fuzz.triage.diagnosis import diagnosis_of
from fuzz.unit.options import CampaignOptions
from tests.helpers.campaign_folder import CORPUS, LOOP
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from tests.helpers.studio import Answers, fitting, message_of, page_of, studio_of
from tests.helpers.studio_campaign import HANGS, SHORT, acts, begin, watch
from worldgen import generate
from worldgen.errors import OutputError
from worldgen.files.grid import read_world, write_world
from worldgen.files.locks import holder, lock, sign
from worldgen.world import FailureRecord


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("campaigns")


@pytest.fixture(scope="module")
def page(folder):
    with studio_of(folder) as gate, page_of(gate) as page:
        yield page


@pytest.fixture(scope="module")
def done(page):
    """Return the folder's name and the last state of a campaign of two units."""
    assert begin(page, "done", units=2)["answer"]["controller"] == "turn-right"
    return watch(page, "done")


def failures(page, folder):
    return page.ask("failures", folder=folder)["answer"]["failures"]


@pytest.mark.nightly
def test_a_campaign_from_the_page_finds_what_the_library_finds(done, folder):
    given = {"controller": "turn-right", "motion": "swept", "families": ("trap",), "examples": 8}
    config = configure(CampaignOptions(**given), 1)
    campaign = Campaign(config, units=2)
    for _ in campaign.run():
        pass
    found = {path.stem: path.read_bytes() for path in (folder / "done").glob("*.grid")}
    overview = build_overview(config, campaign.state, Conclusion())
    assert found == {stem: failure.dumps() for stem, failure in overview.files.items()} and found
    assert done["worlds"] == campaign.state.worlds
    assert done["met"] == dict(campaign.state.met_by_group)


MORE = {
    "oracles": ["turn", "detour=5"],
    "vary": ["robot_speed=1,2"],
    "epoch": 1,
    "shrink": False,
    "examples": 3,
}


@pytest.mark.gate
def test_the_copied_command_does_at_a_terminal_what_the_page_does(page, folder):
    drawn = generate("trap", 1)
    write_world(drawn, folder / "drawn.grid")
    asked = (
        SHORT
        | MORE
        | {"strategies": [], "world": message_of(read_world(folder / "drawn.grid")), "units": 1}
    )
    begin(page, "by page", **asked)
    watch(page, "by page")
    line = page.ask("command", folder="by line", **asked, world_name="drawn.grid")["answer"]
    program, *words = shlex.split(line)
    assert program == "worldgen" and worldgen(*words).code in (0, 1)
    assert written(folder / "by line") == written(folder / "by page") != {}


def written(out):
    """Return what a campaign wrote, except for times."""
    files = {path.relative_to(out).as_posix(): path for path in out.rglob("*") if path.is_file()}
    whole = {
        name: path.read_bytes()
        for name, path in files.items()
        if name.endswith((".grid", "campaign.json"))
    }
    lines = (out / ".campaign/journal.txt").read_text().splitlines()
    records = [json.loads(line.partition(" ")[2]) for line in lines]
    units = [record for record in records if record["type"] == "unit"]
    whole["units"] = [
        one | {"seconds": 0, "first_met": [met[:2] for met in one["first_met"]]} for one in units
    ]
    return whole


@pytest.mark.gate
def test_no_command_names_a_map_that_is_in_no_file(page):
    message = SHORT | {"strategies": [], "world": message_of(generate("trap", 2)), "units": 1}
    assert (
        page.ask("command", folder="x", **message, world_name=None)["error"]["code"] == "not-saved"
    )


@pytest.mark.nightly
def test_a_campaign_that_is_done_says_so(done, page):
    assert (done["running"], done["units"], done["budget"]) == (
        False,
        2,
        {"units": 2, "seconds": None},
    )
    (listed,) = [
        state for state in page.ask("campaigns")["answer"]["campaigns"] if state["folder"] == "done"
    ]
    assert listed == done


@pytest.mark.gate
def test_a_failure_is_looked_at_with_its_run_and_the_line_that_replays_it(done, page, folder):
    first = failures(page, "done")[0]
    seen = page.ask("look", name=first["name"])["answer"]
    assert seen["run"]["steps"] > 0 and seen["words"].startswith(first["verdict"])
    assert seen["replay"] == f"worldgen replay {folder / first['name']}"
    # The cause has its circumstance, as in the report.
    diagnosis = diagnosis_of(Failure.read(folder / first["name"]))
    assert (seen["sentence"], seen["advice"]) == (diagnosis.sentence(), diagnosis.advice)
    assert seen["sentence"] != diagnosis.cause.sentence


def test_a_failure_without_a_recorded_cause_is_looked_at_with_that_of_its_run(tmp_path):
    failure = Failure.read(CORPUS / LOOP).without("cause", "circumstance")
    failure.write(tmp_path / LOOP)
    seen = Answers(tmp_path).ask("look", name=LOOP)
    assert seen["sentence"] == diagnosis_of(failure).sentence()
    gone = read_world(tmp_path / LOOP)
    gone = replace(gone, failure=replace(gone.failure, controller="./gone.py:Robot"))
    write_world(gone, tmp_path / "gone.grid")
    seen = Answers(tmp_path).ask("look", name="gone.grid")
    assert (seen["sentence"], seen["words"]) == ("", "") and seen["error"] is not None


def test_what_is_copied_finds_a_controller_s_file_wherever_it_is_pasted(tmp_path, monkeypatch):
    here, label = tmp_path / "a place", "./mine.py:Robot+robot_speed=2"
    here.mkdir()
    (here / "mine.py").write_text("")
    monkeypatch.chdir(here)
    answers = Answers(here, (label,))
    failure = FailureRecord("./mine.py:Robot", "swept", 0, "loop", "0" * 16, {"steps": 10})
    write_world(replace(generate("trap", 1), failure=failure), here / "f.grid")
    line = answers.ask("command", **(SHORT | {"folder": "out", "controller": label, "units": 1}))
    for one in (line, answers.ask("look", name="f.grid")["replay"]):
        subprocess.run(
            f"worldgen() {{ test -f ./mine.py; }}\n{one}", shell=True, cwd="/", check=True
        )


@pytest.mark.gate
def test_a_failure_s_test_is_that_of_the_command_line(done, page, folder):
    name = failures(page, "done")[0]["name"]
    assert page.ask("snippet", name=name)["answer"] == snippet(Failure.read(folder / name))


@pytest.mark.nightly
def test_what_is_marked_as_known_is_counted_and_not_kept_by_the_next_campaign(done, page, folder):
    first = next(one for one in failures(page, "done") if one["group"] in done["met"])
    page.ask("know", name=first["name"], known=True)
    assert {one["group"] for one in failures(page, "done") if one["known"]} == {first["group"]}
    begin(page, "again", units=2, known=True)
    state = watch(page, "again")
    assert (
        first["group"] in state["known"] and not (folder / f"again/{first['group']}.grid").exists()
    )
    page.ask("know", name=first["name"], known=False)
    assert not any(one["known"] for one in failures(page, "done"))


def watched(page, folder, units):
    """Watches a campaign until it has done more units than that."""
    page.send("watch", folder=folder)
    while page.hear()["part"]["units"] <= units:
        pass


@pytest.mark.nightly
def test_a_campaign_outlives_the_server_and_is_stopped_and_resumed_from_another(tmp_path):
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        begin(page, "long", units=100_000)
        watched(page, "long", 0)
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        assert page.ask("campaigns")["answer"]["campaigns"][0]["running"]
        page.ask("stop", folder="long")
        stopped = watch(page, "long")
        assert 0 < stopped["units"] < 100_000 and (stopped["error"], stopped["activity"]) == (
            None,
            "stopped",
        )
        assert page.ask("resume", folder="long")["answer"]["running"]
        watched(page, "long", stopped["units"])
        page.ask("stop", folder="long")
        assert not watch(page, "long")["running"]


@pytest.mark.nightly
def test_a_campaign_that_has_yet_to_begin_is_stopped_and_leaves_nothing(tmp_path):
    (tmp_path / "mine.py").write_text(HANGS)
    label = f"{tmp_path}/mine.py:Robot"
    with studio_of(tmp_path, named=[label]) as gate, page_of(gate) as page:
        asked = page.send("begin", folder="a/b", **SHORT | {"controller": label}, units=1)
        acts(tmp_path)
        stop = page.send("stop", folder="a/b")
        said = [page.hear() for _ in range(3)]
        assert said[0] == {"id": asked, "part": "a/b"}
        said = {one["id"]: one for one in said[1:]}
        assert said[stop]["answer"] is None
        assert said[asked]["error"]["code"] == "campaign-stopped"
        assert not (tmp_path / "a").exists()
        assert begin(page, "a/b", units=1)["answer"]["folder"] == "a/b"


@pytest.mark.nightly
def test_what_goes_on_is_stopped_before_it_does_and_keeps_what_it_had(tmp_path):
    mine, label = tmp_path / "mine.py", f"{tmp_path}/mine.py:Robot"
    mine.write_text(HANGS)
    memory = tmp_path / "c/.campaign"
    with studio_of(tmp_path, named=[label]) as gate, page_of(gate) as page:
        begin(page, "c", units=1)
        state = watch(page, "c")
        stored = json.loads((memory / "campaign.json").read_text())
        stored["configuration"]["scenario"]["controller"] = label
        (memory / "campaign.json").write_text(json.dumps(stored))
        asked = page.send("resume", folder="c", units=2)
        assert page.hear() == {"id": asked, "part": "c"}
        stop = page.send("stop", folder="c")
        said = {one["id"]: one for one in (page.hear(), page.hear())}
        assert said[stop]["answer"]["units"] == state["units"] == 1
        assert "error" in said[asked] and not list(memory.glob("studio.begins.*"))


def test_what_is_no_campaign_is_not_stopped(page):
    assert page.ask("stop", folder="nothing")["error"]["code"] == "no-campaign"


@pytest.mark.nightly
def test_on_the_drawn_map_only_the_poses_vary(page, folder):
    drawn = generate("trap", 1)
    begin(page, "drawn", units=1, strategies=[], world=message_of(drawn))
    watch(page, "drawn")
    walls = [read_world(path).walls for path in (folder / "drawn").glob("*.grid")]
    assert walls and all((found == drawn.walls).all() for found in walls)


@pytest.mark.gate
def test_a_folder_that_is_not_yet_a_campaign_has_its_worlds_listed_below_it(page, folder):
    (folder / "corpus/inner").mkdir(parents=True)
    write_world(generate("corridor", 3), folder / "corpus/inner/w.grid")
    (folder / "corpus/broken.grid").write_text("no world")
    said = page.ask("failures", folder="corpus")["answer"]
    assert said["failures"] == [] and said["faults"][0]["source"] == "corpus/broken.grid"
    assert {"name": "corpus", "worlds": 2} in page.ask("campaigns")["answer"]["folders"]


@pytest.mark.gate
def test_a_campaign_that_cannot_be_read_is_told_and_hides_no_other(done, page, folder):
    (folder / "bent/.campaign").mkdir(parents=True)
    (folder / "bent/.campaign/campaign.json").write_text("{")
    said = page.ask("campaigns")["answer"]
    assert (
        "done" in [state["folder"] for state in said["campaigns"]]
        and said["faults"][0]["source"] == "bent/.campaign/campaign.json"
    )
    (folder / "bent/.campaign/campaign.json").unlink()


# What the studio refuses to run.


@pytest.mark.gate
@pytest.mark.parametrize(
    ("changes", "why"),
    [({"controller": "./mine.py:Robot"}, "not-named"), ({"strategies": ["./mine.py:family"]}, "not-registered"),
     ({"oracles": ["./mine.py:oracle=3"]}, "not-registered"), ({"motion": "./mine.py:M"}, "not-registered"),
     ({"units": 0}, "wrong-message"), ({"units": None}, "no-budget"), ({"seed": "-1"}, "wrong-message"),
     ({"workers": 1000}, "wrong-message"), ({"epoch": -1}, "out-of-range"),
     ({"baseline": ["../x"]}, "outside-of-folder"), ({"baseline": ["none"]}, "wrong-kind-of-file"),
     ({"vary": ["nothing=1"]}, "unknown-name")],
)  # fmt: skip
def test_a_campaign_that_cannot_be_or_may_not_be_is_refused_and_leaves_nothing(
    page, folder, changes, why
):
    assert begin(page, "refused", **({"units": 1} | changes))["error"]["code"] == why
    assert not (folder / "refused").exists()


@pytest.mark.gate
@pytest.mark.parametrize("name", ["../outside", ".hidden", "", "/tmp/x", "a/../../x"])
@pytest.mark.parametrize("do", ["begin", "resume", "stop", "watch"])
def test_no_campaign_leads_out_of_the_folder(page, do, name):
    assert page.ask(do, **fitting(do, folder=name, **SHORT, units=1))["error"]["code"] in (
        "outside-of-folder",
        "not-a-file-name",
    )


@pytest.mark.parametrize("name", ["plain.txt", "plain.txt/below", "known", "known/mine"])
def test_a_file_and_the_folder_of_known_failures_are_no_place_for_a_campaign(page, folder, name):
    (folder / "plain.txt").write_text("mine")
    assert "another folder" in begin(page, name, units=1)["error"]["remedy"]
    assert (folder / "plain.txt").read_text() == "mine"


def test_a_folder_that_cannot_be_written_is_told_and_begins_nothing(page, folder):
    (folder / "full/.campaign/studio.txt").mkdir(parents=True)
    assert begin(page, "full", units=1)["error"]["code"] == "unwritable"
    assert not (folder / "full/.campaign/campaign.json").exists()


def test_a_campaign_s_memory_that_is_a_link_is_not_written(page, folder, tmp_path):
    (folder / "linked").mkdir()
    (folder / "linked/.campaign").symlink_to(tmp_path)
    assert begin(page, "linked", units=1)["error"]["code"] == "not-a-campaign-folder"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gate
@pytest.mark.parametrize(
    "changes",
    [{"scenario": {"controller": "./evil.py:Robot", "motion": "swept"}}, {"families": ["./evil.py:family"]},
     {"oracles": ["./evil.py:oracle"]}],
)  # fmt: skip
def test_a_campaign_of_elsewhere_that_asks_for_other_code_or_files_is_not_resumed(
    done, page, folder, changes
):
    said = json.loads((folder / "done/.campaign/campaign.json").read_text())
    said["configuration"] |= changes
    (folder / "evil/.campaign").mkdir(parents=True, exist_ok=True)
    (folder / "evil/.campaign/campaign.json").write_text(json.dumps(said))
    assert "error" in page.ask("resume", folder="evil", units=3)
    assert not (folder / "evil/.campaign/units").exists()


@pytest.mark.gate
def test_a_failure_of_a_controller_that_nobody_named_is_shown_and_not_run(done, page, folder):
    world = read_world(folder / failures(page, "done")[0]["name"])
    (folder / "foreign").mkdir()
    record = replace(world.failure, controller=f"cmd:touch {folder}/gone")
    write_world(replace(world, failure=record), folder / "foreign/f.grid")
    seen = page.ask("look", name="foreign/f.grid")["answer"]
    assert (
        seen["run"] is None
        and seen["error"]["code"] == "not-named"
        and seen["world"]["width"] == world.width
    )
    assert not (folder / "gone").exists()


@pytest.mark.gate
def test_a_known_failure_whose_oracle_is_a_file_s_stops_the_campaign_before_it_begins(
    done, page, folder
):
    world = read_world(folder / failures(page, "done")[0]["name"])
    (folder / "known/evil").mkdir(parents=True)
    record = replace(
        world.failure, evidence={**world.failure.evidence, "oracle": "./evil.py:f", "objection": {}}
    )
    write_world(replace(world, failure=record), folder / "known/evil/f.grid")
    assert begin(page, "never", units=1, known=True)["error"]["code"] == "not-registered"
    (folder / "known/evil/f.grid").unlink()


def test_a_signed_file_says_who_keeps_it_and_a_free_one_nothing(tmp_path):
    file = tmp_path / "lock"
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT)
    assert lock(descriptor)
    sign(descriptor)
    assert holder(file) == os.getpid()
    os.close(descriptor)
    assert holder(file) is None and holder(tmp_path / "none") is None


def test_a_lock_that_names_another_s_process_stops_nothing(page, folder):
    (folder / "forged/.campaign").mkdir(parents=True)
    (folder / "forged/.campaign/lock").write_text(f"{os.getpid()} {os.uname().nodename}\n")
    before = signal.getsignal(signal.SIGINT)
    assert page.ask("stop", folder="forged")["error"]["code"] == "no-campaign"
    assert signal.getsignal(signal.SIGINT) == before


@pytest.mark.nightly
def test_every_strategy_that_the_form_offers_may_be_asked_for(page):
    strategies = [
        strategy for strategy in page.ask("hello")["answer"]["strategies"] if strategy != "sealed"
    ]  # for robots that continue past a wall
    assert "archive" in strategies
    assert "answer" in begin(page, "of strategies", strategies=strategies, units=1)
    assert {strategy["strategy"] for strategy in watch(page, "of strategies")["strategies"]} <= set(
        strategies
    )


@pytest.mark.nightly
def test_a_campaign_by_the_clock_that_was_stopped_says_so(done, page):
    begin(page, "by the clock", seconds=600)
    watched(page, "by the clock", 0)
    page.ask("stop", folder="by the clock")
    assert (watch(page, "by the clock")["activity"], done["activity"]) == ("stopped", "done")


@pytest.fixture
def stored(tmp_path):
    """A campaign's folder in which no process is active."""
    config = configure(CampaignOptions(controller="turn-right", families=("trap",), examples=8), 1)
    store.begin(config, tmp_path / "c", store.Budget(units=2)).store.close()
    return tmp_path / "c"


def give_up(out):
    """Make a command that writes there end with an error."""
    with raises(OutputError, "worker-died"), store.errors_recorded(out):
        raise OutputError(
            "worker-died",
            "a worker of {out} died",
            "give fewer --workers",
            at_terminal=True,
            out=out,
        )


def write_summary(folder, status, units):
    summary = {"version": 3, "status": status, "controller": "turn-right", "motion": "swept"}
    summary |= {"seed": 1, "units": units, "worlds": 3, "steps": 4, "seconds": 0.5}
    (folder / MEMORY / "summary.json").write_text(json.dumps(summary))


def test_why_a_campaign_gave_up_is_read_from_its_record_with_paths_in_the_folder(stored):
    give_up(stored)
    error = campaign_state(stored, "c", stored.parent).error
    assert (error.code, error.facts) == ("worker-died", {"out": "c"})
    assert (error.problem, error.terminal) == ("a worker of c died", True)


def test_a_campaign_that_begins_again_has_not_given_up(stored):
    give_up(stored)
    store.resume(stored).store.close()
    assert campaign_state(stored, "c").error is None


@pytest.mark.parametrize(
    ("status", "units", "activity"),
    [
        ("done", 2, "done"),
        ("done", 1, "stopped"),
        ("", 2, "done"),
        ("stopped", 2, "stopped"),
        ("running", 2, "stopped"),
        ("failed", 2, "gave-up"),
    ],
)
def test_a_campaign_that_no_process_runs_says_how_it_ended(stored, status, units, activity):
    write_summary(stored, status, units)
    assert campaign_state(stored, "c").activity == activity


def test_a_campaign_whose_error_is_recorded_gave_up(stored):
    give_up(stored)
    assert campaign_state(stored, "c").activity == "gave-up"


def test_what_was_refused_after_a_campaign_was_done_says_nothing_of_it(stored):
    write_summary(stored, "done", 2)
    give_up(stored)
    state = campaign_state(stored, "c")
    assert (state.activity, state.error) == ("done", None)


@pytest.mark.parametrize(
    "changes",
    [{"templates": {"problem": "{out:>1000000000}", "remedy": ""}}, {"templates": {"problem": "{out.x}", "remedy": ""}},
     {"facts": []}, {"version": 2}, {"templates": 3}, {"templates": {"problem": "{nothing}", "remedy": ""}}],
)  # fmt: skip
def test_a_record_that_no_campaign_wrote_is_passed_over(stored, changes):
    give_up(stored)
    file = stored / MEMORY / "error.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))
    assert store.read_error(stored) is None


def test_a_command_that_could_not_begin_another_campaign_there_leaves_no_record(stored):
    with raises(OutputError, "another-campaign"), store.errors_recorded(stored, begins=True):
        raise OutputError("another-campaign", "{out} holds another campaign", "", out=stored)
    assert store.read_error(stored) is None


def test_a_folder_without_a_campaign_gets_no_record(tmp_path):
    give_up(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_page_hears_of_a_running_campaign_while_only_time_passes(tmp_path, monkeypatch):
    elapsed = iter((1.0, 1.5, 2.0))
    monkeypatch.setattr("fuzz.studio.campaigns.watching._EVERY", 0.0)
    watching = Watching(Folder(tmp_path))
    monkeypatch.setattr(
        watching, "_read", lambda _: SimpleNamespace(running=True, elapsed=next(elapsed))
    )

    async def heard():
        states = watching.ask(Watch(id=0, folder="c"))
        return [(await anext(states))[0] for _ in range(3)]

    assert asyncio.run(heard()) == ["part", "part", "part"]
