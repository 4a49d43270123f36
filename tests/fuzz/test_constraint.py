"""What the user of a campaign fixed is the same in every world that it runs, shrinks and stores.

The expected values are taken from the options as given, not from the campaign's constraint.
"""

import contextlib
import json
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz.campaign.configure import configure
from fuzz.campaign.executors import InlineExecutor
from fuzz.campaign.run import Campaign
from fuzz.campaign.state import UnitDone
from fuzz.campaign.store import Budget, begin, resume
from fuzz.campaign.store.fingerprint import config_of, fingerprint_of
from fuzz.campaign.unit import run_unit
from fuzz.commands._session import CampaignSession
from fuzz.failure import Failure
from fuzz.overview.natural import natural_runs
from fuzz.shrink import shrink
from fuzz.simplicity import Case
from fuzz.triage.triage import Triage
from fuzz.unit.constraint import FIXED, Constraint
from fuzz.unit.options import CampaignOptions
from fuzz.unit.result import SearchState, UnitResult
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import write_world

STRATEGIES = ("native", "archive", "boundary", "features", "sealed", "trap", "map", "fleet", "all")


def options(strategy, folder, *, controller="turn-right", time_step=None, vary=(), **more):
    """Return the options of a small campaign with one strategy, or with all of them."""
    where = {"strategies": (strategy,)}
    if strategy == "all":
        where = {}
    elif strategy == "sealed":
        where["motion"] = "stepped"
    elif strategy == "fleet":
        where = {"robots": 2, "strategies": ("features",)}
    elif strategy == "trap":
        where = {"families": ("trap",)}
    elif strategy == "map":
        path = folder / "map.grid"
        if not path.exists():
            world = replace(generate("trap", 3), certificate=None, provenance=None)
            write_world(replace(world, robot_speed=1.5, robot_radius=0.0512345), path)
        where = {"world": path, "shrink": True}
    return CampaignOptions(
        controller=controller, time_step=time_step, vary=vary, examples=4, **{**where, **more}
    )


def violations(case, given):
    """Return the quantities of a world and its run that are not as the options demand."""
    world, scenario = case
    run = scenario.run
    allowed = {}
    if given.world is not None:
        allowed["robot_radius"] = {0.0512345, round(0.75 * 0.0512345, 6), round(0.5 * 0.0512345, 6)}
        allowed["robot_speed"] = {1.5}
    for option in given.controller.split("+")[1:]:
        name, _, value = option.partition("=")
        allowed[name] = {float(value)}
    if given.time_step is not None:
        allowed["time_step"] = {given.time_step}
    for text in given.vary:
        name, _, values = text.partition("=")
        allowed[name] = {float(value) for value in values.split(",")}
    switches = run.thesis if run.motion == "stepped" else run.robot
    found = []
    for name, values in allowed.items():
        if name == "robot_radius":
            own = {robot.radius for robot in world.robots}
        elif name == "robot_speed":
            own = {robot.speed for robot in world.robots}
        elif name == "time_step":
            own = {run.time_step}
        else:
            own = {getattr(switches, name)}
        if not own <= values:
            found.append(f"{name} is {own}, not in {values}")
    return found


def wrong(failures, given):
    """Return the violations of some failures, with their signatures."""
    return [
        (failure.signature, *found)
        for failure in failures
        if (found := violations(Case(failure.world, failure.scenario), given))
    ]


FIXED_BY_USER = [
    pytest.param({"time_step": 0.06}, id="time-step"),
    pytest.param({"vary": ("robot_radius=0.09,0.05", "robot_speed=1.1")}, id="robot"),
    pytest.param(
        {"controller": "turn-right+wall_friction=0.13", "vary": ("time_step=0.02,0.05",)},
        id="option",
    ),
]


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("fixed", FIXED_BY_USER)
def test_no_strategy_finds_a_failure_of_another_robot(strategy, fixed, tmp_path):
    asked = options(strategy, tmp_path, **fixed)
    found = run_unit(configure(asked, 1), 0).failures.values()
    assert wrong(found, asked) == []


@pytest.mark.gate
@pytest.mark.parametrize("fixed", FIXED_BY_USER)
def test_a_strategy_that_runs_another_robot_ends_the_unit_as_a_bug_of_ours(fixed, tmp_path):
    free = run_unit(configure(options("native", tmp_path), 1), 0).failures
    other = next(iter(free.values()))
    result = UnitResult("native")
    triage = Triage(configure(options("native", tmp_path, **fixed), 1), result)
    with pytest.raises(RuntimeError, match="'native' changed what the campaign fixes"):
        triage.enter(other.world, other.scenario, str(other.verdict))
    assert not result.failures


@pytest.mark.nightly
@pytest.mark.parametrize("fixed", FIXED_BY_USER)
def test_a_known_failure_is_not_moved_to_a_boundary_of_what_is_fixed(fixed, tmp_path):
    known = run_unit(configure(options("native", tmp_path, **fixed), 1), 0).failures
    asked = replace(options("boundary", tmp_path, **fixed), examples=96)
    config = configure(asked, 1)
    found = [run_unit(config, unit, SearchState(failures=known)).failures for unit in range(2)]
    assert any(found) and wrong([one for unit in found for one in unit.values()], asked) == []


@pytest.mark.gate
def test_shrinking_keeps_what_the_campaign_fixed_and_nothing_else(tmp_path):
    asked = options("native", tmp_path, time_step=0.06, vary=("robot_radius=0.09,0.05",))
    found = list(run_unit(configure(asked, 1), 0).failures.values())[:4]
    small = [shrink(failure).failure for failure in found]
    assert small and wrong(small, asked) == []
    # The same failures of a campaign that fixed nothing get the usual numbers.
    free = []
    for failure in found:
        details = {key: value for key, value in failure.record.details.items() if key != FIXED}
        record = replace(failure.record, details=details)
        free.append(shrink(replace(failure, record=record)).failure)
    assert wrong(free, asked) != []


def test_the_command_shrink_keeps_what_the_campaign_fixed(tmp_path):
    asked = options("native", tmp_path, time_step=0.06)
    found = next(iter(run_unit(configure(asked, 1), 0).failures.values()))
    found.write(tmp_path / "found.grid")
    small = tmp_path / "small.grid"
    assert worldgen("shrink", tmp_path / "found.grid", "--out", small).code == 0
    failure = Failure.read(small)
    assert failure.options.time_step == 0.06
    assert failure.record.details[FIXED] == {"time_step": [0.06]}


def test_natural_worlds_are_of_the_robot_that_is_searched():
    asked = options(
        "all", None, vary=("robot_radius=0.12,0.1", "time_step=0.03", "wall_friction=0.2")
    )
    config = configure(asked, 1)
    runs, examples = natural_runs(config.scenario, ["trap", "maze"], 12, seed=1, vary=config.vary)
    assert runs.worlds >= 10 and len(examples) > 1
    assert [violations(case, asked) for case in examples.values() if violations(case, asked)] == []


def test_what_varies_does_not_change_the_natural_worlds_themselves():
    scenario = Scenario("bug2")
    (plain, _), (varied, _) = (
        natural_runs(
            scenario, ["trap"], 4, seed=3, vary=configure(options("all", None, vary=vary), 1).vary
        )
        for vary in ((), ("robot_radius=0.07",))
    )
    assert plain == varied


def test_a_default_that_is_typed_is_fixed_like_any_other_value(tmp_path):
    typed = [
        options("all", tmp_path, time_step=0.015, motion="endpoint"),
        options("all", tmp_path, controller="turn-right+time_step=0.015", motion="endpoint"),
    ]
    for asked in typed:
        config = configure(asked, 1)
        assert config.time_steps == (0.015,) and config.constraint.fixes("time_step")
    free = configure(options("all", tmp_path, motion="endpoint"), 1)
    assert len(free.time_steps) > 1 and not free.constraint.allowed


@pytest.mark.parametrize(
    ("given", "name"),
    [
        pytest.param(
            {"time_step": 0.015, "vary": ("time_step=0.03",)}, "time_step", id="time-step"
        ),
        pytest.param(
            {"controller": "bug1+wall_friction=0.1", "vary": ("wall_friction=0.1,0.2",)},
            "wall_friction",
            id="option",
        ),
    ],
)
def test_a_quantity_is_not_both_fixed_and_varied(given, name, tmp_path):
    with raises(InvalidParameter, code="twice", name=name):
        configure(options("all", tmp_path, **given), 1)


def test_a_stored_campaign_keeps_its_constraint(tmp_path):
    asked = options("map", tmp_path, time_step=0.015, vary=("wall_friction=0.1,0.2",))
    config = configure(asked, 1)
    stored = json.loads(json.dumps(fingerprint_of(config).configuration))
    assert config_of(stored).constraint == config.constraint
    assert {name for name, _ in config.constraint.allowed} == {
        "robot_radius", "robot_speed", "wall_friction", "robot_target_radius", "time_step",
    }  # fmt: skip


def test_radii_of_the_target_that_vary_replace_the_maps_own(tmp_path):
    config = configure(options("map", tmp_path, vary=("robot_target_radius=0.1,0.2",)), 1)
    assert dict(config.constraint.allowed)["robot_target_radius"] == (0.1, 0.2)


def test_settings_of_the_project_are_given_too(tmp_path, monkeypatch):
    (tmp_path / "pyproject.toml").write_text("[tool.worldgen.fuzz]\ntime-step = 0.06\n")
    monkeypatch.chdir(tmp_path)
    asked = ("--controller", "turn-right", "--family", "features", "--examples", 2, "--seed", 1)
    worldgen("fuzz", *asked, "--units", 1, "--workers", 1, "--out", "out")
    files = [*(tmp_path / "out").rglob("*.grid")]
    assert files and {Failure.read(file).options.time_step for file in files} == {0.06}


@pytest.mark.parametrize(
    "details", [{}, {FIXED: 3}, {FIXED: []}, {FIXED: {"time_step": 0.06, "robot_radius": []}}]
)
def test_a_record_of_another_form_fixes_nothing(details):
    assert Constraint.recorded(details) == Constraint()


def test_an_option_that_the_run_does_not_have_is_not_checked():
    case = Case(generate("trap", 1), Scenario("turn-right"))
    assert Constraint.of({"no_such": [1.0]}).allows(case)
    assert not Constraint.of({"robot_radius": [0.08]}).allows(case)


def cut_short(campaign):
    """Run a campaign until its first unit is done."""
    for event in campaign.run():
        if isinstance(event, UnitDone):
            return


CONTROLLERS = ("turn-right", "bug1", "wall-left")
VARIED = {
    "robot_radius": (0.09, 0.05),
    "robot_speed": (1.1, 0.7),
    "wall_friction": (0.0, 0.15),
    "time_step": (0.02, 0.05),
}


@st.composite
def campaigns(draw):
    """Draw a strategy and options that fix something."""
    strategy = draw(st.sampled_from(STRATEGIES))
    names = draw(st.lists(st.sampled_from([*VARIED]), unique=True, max_size=3))
    vary = tuple(
        f"{name}={','.join(map(str, draw(st.lists(st.sampled_from(VARIED[name]), min_size=1, unique=True))))}"
        for name in names
    )
    controller = "turn-right" if strategy == "sealed" else draw(st.sampled_from(CONTROLLERS))
    if "wall_friction" not in names and draw(st.booleans()):
        controller += "+wall_friction=0.13"
    more = {"controller": controller, "vary": vary}
    if "time_step" not in names:
        more["time_step"] = draw(st.sampled_from((None, 0.015, 0.03, 0.06)))
    if strategy != "sealed":
        more["motion"] = draw(st.sampled_from(("swept", "endpoint")))
    return strategy, more, draw(st.integers(0, 2**32)), draw(st.booleans())


@pytest.mark.nightly
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(campaigns())
def test_no_stored_failure_of_any_campaign_breaks_what_the_user_fixed(tmp_path_factory, drawn):
    strategy, more, seed, is_resumed = drawn
    folder = tmp_path_factory.mktemp("campaign")
    asked = replace(options(strategy, folder, **more), epoch=1)
    config = configure(asked, seed)
    begun = begin(config, folder / "out", Budget(units=2))
    if is_resumed:
        with contextlib.closing(begun.store):
            cut_short(Campaign(begun.config, units=2, store=begun.store))
        begun = resume(folder / "out", None)
    CampaignSession(begun, InlineExecutor(), quiet=True).run()
    stored = [Failure.read(file) for file in (folder / "out").rglob("*.grid")]
    assert wrong(stored, asked) == []
