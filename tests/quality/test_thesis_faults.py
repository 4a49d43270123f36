"""The shrunk faults of the thesis's motion, as described in docs/notes/thesis.md."""

import functools
import pathlib
import re
import shlex

import pytest

from benchmarks.thesis_faults import KINDS, draw_worlds, tally
from fuzz.campaign.run import Campaign
from fuzz.failure import Failure
from fuzz.shrink import removable
from fuzz.shrink.predicate import StillFails
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim import simulate
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.repo.documented_commands import DOCS, part_with
from worldgen import Cut, Witness, check_certificate
from worldgen.files.grid import read_world
from worldgen.render.frame import BAND
from worldgen.render.primitives import DrawnLine
from worldgen.render.scene import compose

ROOT = pathlib.Path(__file__).parents[2]
FAULTS = ROOT / "corpora" / "thesis-faults"
NAMES = sorted(path.stem for path in FAULTS.glob("*.grid"))
CAUSES = ("slide", "back-off", "corner")
ROBOTS = ("thesis-1", "thesis-2", "thesis-3")
PAGE = part_with(DOCS / "notes" / "thesis.md", "The faults of the thesis's motion")
README = (FAULTS / "README.md").read_text(encoding="utf-8")
TABLE = dict(re.findall(r"^\| `([\w-]+)\.grid` \| `([\w-]+)` \|", README, flags=re.MULTILINE))


@functools.cache
def world_of(name):
    return read_world(FAULTS / f"{name}.grid")


def run(name, variation="", steps=20_000):
    failure = Failure.of(world_of(name))
    record, options = failure.record, failure.options
    scenario = Scenario.parse(record.controller + variation, motion="stepped", seed=options.seed)
    return simulate(world_of(name), scenario.controller, scenario.options(world_of(name), steps))


def search(robot, families, examples):
    scenario = Scenario.parse(robot, motion="stepped")
    config = CampaignConfig(scenario, seed=1, families=families, examples=examples, shrink=False)
    campaign = Campaign(config, units=3)
    for _ in campaign.run():
        pass
    return campaign.state


def test_the_readme_lists_every_file():
    assert sorted(TABLE) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_fault_replays_with_the_cause_of_the_readme(name):
    shown = replay(Failure.of(world_of(name)))
    assert shown.confirmed, shown.reason
    assert world_of(name).failure.details["cause"] == TABLE[name]


@pytest.mark.parametrize("name", NAMES)
def test_the_readme_gives_size_and_steps_of_the_file(name):
    world = world_of(name)
    row = next(line for line in README.splitlines() if f"`{name}.grid`" in line)
    assert f"| {world.width} x {world.height}, {world.solid_cells} solid |" in row
    told = {int(number) for number in re.findall(r"step (\d+)", row)}
    assert told <= {value for value in world.failure.evidence.values() if isinstance(value, int)}


@pytest.mark.parametrize("cause", CAUSES)
@pytest.mark.parametrize("robot", ROBOTS)
def test_there_is_a_small_world_for_each_cause_and_robot(robot, cause):
    world = world_of(f"{robot}-{cause}")
    assert world.failure.controller == robot and world.failure.evidence["cause"] == cause
    assert world.solid_cells <= 3 and isinstance(world.certificate, Witness)


@pytest.mark.parametrize("robot", ROBOTS)
def test_there_is_a_walled_off_target_for_each_robot(robot):
    world = world_of(f"{robot}-breach")
    assert isinstance(world.certificate, Cut) and check_certificate(world).valid
    assert run(f"{robot}-breach", "+keep_going").verdict == "reached"


@pytest.mark.parametrize("name", NAMES)
def test_nothing_more_can_be_removed_from_a_fault(name):
    world = world_of(name)
    assert removable(world, StillFails.of(Failure.of(world))) == []


@pytest.mark.parametrize("name", [f"{robot}-{cause}" for robot in ROBOTS for cause in CAUSES])
def test_the_repair_of_its_cause_alone_removes_a_fault(name):
    cause = world_of(name).failure.evidence["cause"]
    healed = run(name, f"+repair_{cause.replace('-', '_')}")
    assert getattr(healed.evidence, "cause", None) != cause


@pytest.mark.parametrize("name", NAMES)
def test_with_all_repairs_no_wall_is_entered_and_no_closed_target_reached(name):
    healed = run(name, "+repaired")
    assert healed.verdict not in ("tunnel", "overlap")
    assert healed.verdict != "reached" or isinstance(world_of(name).certificate, Witness)


@pytest.mark.nightly
def test_a_short_campaign_finds_all_three_causes():
    met = search("thesis-2", ("features",), 400).met
    found = {
        cause
        for cause in CAUSES
        for kind in met
        if kind.startswith((f"tunnel-{cause}", f"overlap-{cause}"))
    }
    assert found == set(CAUSES)


@pytest.mark.nightly
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_campaign_with_all_repairs_finds_no_way_into_a_wall(robot):
    state = search(f"{robot}+repaired", ("features", "sealed", "trap"), 150)
    assert state.worlds > 300
    assert not {"tunnel", "overlap", "breach"} & set(state.verdicts)


@functools.cache
def sample(kind):
    return list(draw_worlds(kind, 150, seed=2))


@pytest.mark.gate
@pytest.mark.parametrize("kind", KINDS)
def test_slide_and_back_off_repaired_leave_no_overlap_of_a_pixel(kind):
    for robot in ROBOTS:
        assert tally(sample(kind), f"{robot}+repair_slide+repair_back_off", 10_000)["overlap"] == 0


@pytest.mark.gate
def test_faults_are_frequent_for_the_random_rule_among_traps():
    assert tally(sample("four Us"), "thesis-3")["tunnel"] > 20
    assert tally(sample("four Us"), "thesis-3+repaired")["tunnel"] == 0


@pytest.mark.gate
def test_the_faults_help_the_random_rule_out_of_traps():
    worlds = sample("four Us")
    assert (
        tally(worlds, "thesis-3+keep_going")["reached"]
        > tally(worlds, "thesis-3+repaired")["reached"]
    )


def test_the_exact_loop_has_period_104():
    assert run("thesis-1-loop-104").evidence.period == 104


@pytest.mark.parametrize("kind", ["drifting", "confined"])
def test_the_two_other_kinds_of_never_last_for_a_hundred_thousand_steps(kind):
    episode = run(f"thesis-1-{kind}", steps=100_000)
    assert (episode.verdict, episode.evidence.kind) == ("stalled", kind)


def console():
    """Return the page's commands with the lines that they print, if the page shows any."""
    for block in re.findall(r"```console\n(.*?)```", PAGE, flags=re.DOTALL):
        for part in block.split("$ worldgen ")[1:]:
            command, _, shown = part.partition("\n")
            yield pytest.param(command, shown, id=command)


@pytest.mark.gate
@pytest.mark.parametrize(("command", "shown"), list(console()))
def test_the_page_shows_what_its_commands_print(command, shown, monkeypatch):
    monkeypatch.chdir(ROOT)
    result = worldgen(*shlex.split(command))
    printed = result.out + result.err  # a note follows on stderr
    assert printed.strip().endswith(shown.strip()) if shown else "confirmed" in result.out


def test_every_picture_and_link_of_the_page_leads_somewhere():
    links = re.findall(r"\]\(([^)#:]+)\)", PAGE)
    assert len(links) >= 7 and all((ROOT / "docs/notes" / link).exists() for link in links)


def test_the_proof_of_a_breach_is_drawn_inside_the_frame():
    world = world_of("thesis-2-breach")
    assert (world.certificate.cells < 0).any()  # cells of the cut outside the grid
    scene = compose(world, None, signal=False, witness=True, title="", pixels=300)
    drawn = [
        part.points
        for part in scene.primitives
        if isinstance(part, DrawnLine) and len(part.points) == 7
    ]
    assert len(drawn) == 2 and all((points >= 0).all() for points in drawn)
    assert (
        max(points[:, 1].max() for points in drawn) < scene.frame.bottom + BAND * scene.frame.unit
    )
