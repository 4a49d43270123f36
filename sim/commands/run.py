"""``worldgen run``: run one controller in one world and print the verdict."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sim.verdict import ARRIVALS, Verdict
from worldgen.cli.output import (
    CONTROLLER_HELP,
    PATH,
    SEED,
    check_out,
    emit_json,
    force_option,
    json_option,
    motion_option,
    note,
    say,
    time_step_option,
    typed,
    write_out,
)
from worldgen.cli.robot_options import apply, robot_options
from worldgen.errors import InvalidParameter
from worldgen.support.progress import working

if TYPE_CHECKING:
    from sim.controllers.behaviours.arbitration import Arbitration
    from sim.episode import Episode
    from sim.scenario import Scenario
    from worldgen.world import World

EXAMPLES = (
    "\b\n  worldgen run w.grid --controller turn-right --picture run.png\n"
    "  worldgen run two-robots.grid --controller 1=bug2,2=turn-right\n"
    "  worldgen run w.grid --controller ./mine.py:Robot --motion endpoint --json\n"
    "  worldgen run w.grid --controller hybrid-car --footprint 0.62x0.9 --drive car --turning-radius "
    "0.5 --reverse --arrival stop\n"
    "  worldgen run w.grid --controller thesis-1+noise+sensor_range=50 --motion stepped"
)
# Steps, 400 MB with a memory of 5,000 numbers: a run of a class that is recorded in any case.
_RECORDED = 10_000
_PICTURES = (".png", ".svg", ".html", ".gif")


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option("--controller", required=True, help=CONTROLLER_HELP)
@motion_option
@click.option(
    "--task",
    type=click.Choice(("target", "cover")),
    help="Reach the target, or cover every cell whose centre can be reached.  [default: target]",
)
@click.option(
    "--steps",
    type=int,
    help="Budget in steps.  [default: as for the file's failure, if it is this controller's, "
    "else 50 times the witness's time]",
)
@time_step_option
@click.option("--seed", type=SEED, default=0, help="Seed of random controllers.")
@click.option(
    "--picture",
    type=PATH,
    metavar="OUT",
    help="Draw the world and the trail: .png, .svg, .html, or an animated .gif.",
)
@click.option(
    "--trace",
    type=PATH,
    metavar="OUT",
    help=(
        "Write t,x,y,heading for each step as CSV, and the active behaviour if the controller has "
        "behaviours."
    ),
)
@click.option(
    "--transcript",
    type=PATH,
    metavar="OUT",
    help="Save what was sent to a program (cmd:), for use in a debugger.",
)
@robot_options
@json_option
@force_option
def run(
    path: Path,
    controller: str,
    motion: str,
    task: str | None,
    steps: int | None,
    time_step: float | None,
    seed: int,
    picture: Path | None,
    trace: Path | None,
    transcript: Path | None,
    as_json: bool,
    force: bool,
    **robot: Any,
) -> None:
    """Run a controller in a world and report how it ends.

    Exits with 0 if the robot arrives, with 1 if it does not.
    """
    from sim.controllers.behaviours.arbitration import shares
    from sim.controllers.contract import check_contract
    from sim.episode.describe import describe_frames
    from sim.episode.transcript import check_transcript, transcribed
    from sim.fleet.assignment import controllers_in
    from sim.options.run import MAX_RECORDED, RunOptions
    from sim.scenario import Scenario
    from sim.scenario.unused import ineffective
    from worldgen.files.grid import read_world

    # Read the world and the controllers.
    stored = read_world(path)
    world = _with_robot(stored, robot)
    duration = RunOptions.time_step if time_step is None else time_step
    common = {"time_step": duration, "seed": seed, "task": task or RunOptions.task}
    scenarios = [
        Scenario.parse(part, motion=motion, **common)
        for part in controllers_in(controller, len(world.robots))
    ]
    for sentence in ineffective(dict.fromkeys(scenarios), seeds=typed("seed")):
        note(f"note: {sentence}")
    # Refuse bad output before the run.
    check_transcript(scenarios, transcript)
    check_out("--picture", picture, *_PICTURES, force=force)
    check_out("--trace", trace, force=force)
    steps = _stored_budget(world, scenarios) if steps is None else steps
    # Run; record only if something needs the recording.
    with (
        transcribed(scenarios[0].controller, transcript, force=force),
        working(f"running {_label(scenarios)} in {path}"),
    ):
        # Behaviours are counted only for a single robot, and in runs short enough to be recorded.
        arbitration = scenarios[0].arbitration if len(scenarios) == 1 else None
        short = scenarios[0].options(world, steps).steps <= MAX_RECORDED
        counts = as_json and arbitration is not None and short
        episode = _simulated(world, scenarios, steps, record=bool(picture or trace or counts))
    acted = _acted(arbitration, episode)
    # Explain what went wrong, if anything did.
    check_contract(_at_fault(scenarios, episode), episode.evidence, episode.steps)
    reachable, proof = _is_reachable(world, episode)
    uncertain = _why_uncertain(world, scenarios)
    # Print the result, and anything that may explain it.
    if as_json:
        emit_json(
            {
                **_summary(episode, world),
                **({"behaviours": shares(arbitration, acted)} if arbitration and acted else {}),
                "reachable": reachable,
                **({} if reachable is not False else {"proof": proof}),
                "arrival_uncertain": uncertain or None,
            }
        )
    else:
        say(_sentence(episode, world))
        say(describe_frames(episode.evidence), nl=False)
    if transcript is not None:
        note(f"wrote {transcript}")
    if reachable is not True and episode.verdict not in ARRIVALS:
        note(_why_unreachable(world, reachable, proof))
    if uncertain and episode.verdict not in ARRIVALS:
        note(f"with these disturbances, no controller is certain to arrive: {uncertain}")
    # Write the trace and the picture.
    states = _csv(episode, acted)
    if trace is not None and states:
        write_out(trace, states.encode(), force=force)
    if picture is not None:
        title = (
            f"{_label(scenarios)}, {scenarios[0].run.motion}: {_sentence(episode, world)}, "
            f"{episode.area_covered:.4g} m2 {_covered(world)}"
        )
        with working(f"drawing {picture}"):
            drawn = _picture(world, episode, scenarios[0].controller, title, picture.suffix)
        write_out(picture, drawn, force=force)
    if episode.verdict not in ARRIVALS:
        raise SystemExit(1)


def _with_robot(stored: World, robot: dict[str, Any]) -> World:
    """Return the world with the robot that was asked for, and with a proof about that one."""
    from worldgen.reach import decide

    world = apply(stored, robot)
    if world is stored or world.certificate is not None or world.unread:
        return world
    with working("deciding whether this robot can arrive"):
        return replace(world, certificate=decide(world).certificate)


def _stored_budget(world: World, scenarios: list[Scenario]) -> int | None:
    """Return the budget of the file's failure if the controller and its options are the same.

    ``run`` and ``replay`` then agree. ``None`` without such a failure: the world decides.
    """
    from sim.controllers.catalogue import in_plain_place
    from sim.options.run import RunOptions
    from sim.scenario import Scenario

    record = world.failure
    if record is None or len(set(scenarios)) > 1:
        return None
    asked = scenarios[0]
    try:
        stored = RunOptions.of(record.motion, asked.run.seed, record.parameters)
    except InvalidParameter:  # a record of another version
        return None
    names = {in_plain_place(one, resolve=True) for one in (record.controller, asked.controller)}
    is_same = len(names) == 1 and Scenario(asked.controller, stored) == asked
    return stored.steps if is_same else None


def _why_uncertain(world: World, scenarios: list[Scenario]) -> str:
    """Return why no controller is certain to arrive with these disturbances; else empty."""
    from sim.options.disturbances import why_arrival_is_not_certain

    doubts = (why_arrival_is_not_certain(world, one.run.robot) for one in scenarios)
    return next((doubt.sentence for doubt in doubts if doubt), "")


def _simulated(
    world: World, scenarios: list[Scenario], steps: int | None, *, record: bool
) -> Episode:
    """Run one robot, or all robots of a world with several."""
    from sim.clock.controller_time import Effort
    from sim.controllers.catalogue import CONTROLLERS
    from sim.controllers.catalogue.renewal import survivors_found
    from sim.episode import simulate
    from sim.fleet.episode import simulate_fleet
    from sim.runners.controller_host import host_of

    began = Effort.so_far()
    options = [one.options(world, steps) for one in scenarios]
    # Only a recording shows that the memory of a class drifts.
    in_python = host_of(CONTROLLERS.get(scenarios[0].controller)).in_python
    record = record or (in_python and options[0].steps <= _RECORDED)
    if world.is_fleet:
        names = {number: one.controller for number, one in enumerate(scenarios, start=1)}
        episode: Episode = simulate_fleet(world, names, options, record=record)
    else:
        episode = simulate(world, scenarios[0].controller, options[0], record=record)
    for sentence in survivors_found((one.controller for one in scenarios), began):
        note(f"note: {sentence}")
    return episode


def _acted(arbitration: Arbitration | None, episode: Episode) -> list[str]:
    """Return the behaviour that acted in each step; empty if that was not recorded."""
    from sim.controllers.behaviours.arbitration import acting

    trace = episode.trace
    return [] if arbitration is None or trace is None else acting(arbitration, trace)


def _label(scenarios: list[Scenario]) -> str:
    """Return the text that names all robots' controllers, as on the command line."""
    labels = [one.label() for one in scenarios]
    if len(set(labels)) == 1:
        return labels[0]
    return ",".join(f"{number}={label}" for number, label in enumerate(labels, start=1))


def _at_fault(scenarios: list[Scenario], episode: Episode) -> str:
    """Return the name of the controller that failed, if one did."""
    number = getattr(episode.evidence, "robot", None)
    return scenarios[(number or 1) - 1].controller


def _csv(episode: Episode, acted: list[str]) -> str:
    """Return the recorded states, or none; for several robots, the first column is ``robot``.

    Args:
        episode: The run.
        acted: The behaviour that acted in each step, if the robot has behaviours.
    """
    from sim.outcome import FleetEpisode

    if not isinstance(episode, FleetEpisode):
        return "" if episode.trace is None else episode.trace.to_csv(acted)
    if all(one.trace is None for one in episode.robots):
        return ""
    lines = ["robot,t,x,y,heading"]
    for number, one in enumerate(episode.robots, start=1):
        states = [] if one.trace is None else one.trace.to_csv().splitlines()[1:]
        lines += [f"{number},{state}" for state in states]
    return "\n".join(lines) + "\n"


def _is_reachable(world: World, episode: Episode) -> tuple[bool | None, str]:
    """Return True if the targets can be reached at all, None if that is undecided; and the proof.

    The proof is a word: witness, cut, confinement or swap; empty if there is none. A file without a
    certificate is decided, as ``worldgen verify`` does, only if a robot did not arrive, because
    that can take as long as the run. A file keeps no confinement and no swap.
    """
    from worldgen.reach.decision import unread_reason
    from worldgen.reach.verifying import verify_world
    from worldgen.world import Cut

    if world.unread:
        note(f"warning: {unread_reason(world.unread)}")
        return None, ""

    if world.certificate is not None:
        is_cut = isinstance(world.certificate, Cut)
        return not is_cut, "cut" if is_cut else "witness"
    if episode.verdict == Verdict.REACHED:
        return True, ""
    with working("deciding whether the run could have arrived"):
        answer = verify_world(world)
    reachable = {"reachable": True, "blocked": False}.get(answer["result"])
    return reachable, answer["certificate"] or ""


def _why_unreachable(world: World, reachable: bool | None, proof: str) -> str:
    """Return the note about a run that failed and has no witness."""
    from sim.episode.describe import describe_unreachable

    sentence = describe_unreachable(world, undecided=reachable is None, proof=proof)
    return sentence if reachable is None else f"{sentence}; `worldgen verify` explains why"


def _summary(episode: Episode, world: World) -> dict[str, object]:
    from sim.evidence import evidence_table
    from sim.outcome import FleetEpisode

    robots: dict[str, object] = {}
    if isinstance(episode, FleetEpisode):
        robots["robots"] = [_summary(one, world) for one in episode.robots]
    return {
        "verdict": episode.verdict,
        "steps": episode.steps,
        "time": episode.time,
        "path_length": episode.path_length,
        "collisions": episode.collisions,
        "area_covered": episode.area_covered,
        **({} if episode.cells_left is None else {"cells_left": episode.cells_left}),
        **_goals(episode, world),
        "trace_digest": episode.trace_digest,
        "evidence": evidence_table(episode.evidence),
        **({} if episode.shortfall is None else {"shortfall": asdict(episode.shortfall)}),
        **robots,
    }


def _goals(episode: Episode, world: World) -> dict[str, object]:
    """Return how many goals a robot with waypoints reached, and the one that it never reached."""
    reached = episode.goals_reached
    if reached is None:
        return {}
    goals = world.robots[0].goals
    found: dict[str, object] = {"goals": len(goals), "goals_reached": reached}
    if reached < len(goals):
        number = reached + 1 if reached < len(goals) - 1 else None
        missed = goals[reached]
        found["never_reached"] = {"waypoint": number, "x": missed.x, "y": missed.y}
    return found


def _sentence(episode: Episode, world: World) -> str:
    from sim.episode.describe import describe_evidence, describe_missed_goal
    from worldgen.support.plain_text import counted

    missed = describe_missed_goal(world, episode)
    left = f", {missed}" if missed else ""
    if episode.cells_left:
        left = f", {counted(episode.cells_left, 'cell')} left to cover"
    return (
        f"{episode.verdict}{describe_evidence(episode)}{left}: {counted(episode.steps, 'step')}, "
        f"{episode.time:g} s, {episode.path_length:.3f} m driven, "
        f"{counted(episode.collisions, 'collision')}, trace {episode.trace_digest}"
    )


def _covered(world: World) -> str:
    """Return how an area is counted: cells under the centre, of which a footprint covers more."""
    return "covered" if world.robots[0].is_disc else "of cells entered by its axle"


def _picture(world: World, episode: Episode, controller: str, title: str, suffix: str) -> bytes:
    from sim.controllers.catalogue import CONTROLLERS
    from sim.drawing.picture import drives_of, remembered_at_the_end, trails_of
    from worldgen import render

    # The picture shows this run; the file's failure may have been another.
    world = replace(world, failure=None)
    trails = trails_of(episode, world)
    if trails and not world.is_fleet:
        # If a memory cannot be read, only its own picture is missing.
        try:
            memory = remembered_at_the_end(episode, CONTROLLERS.get(controller))
            trails = [replace(trails[0], memory=memory)]
        except InvalidParameter as error:
            note(f"{error}")
    if suffix == ".gif":
        return render.draw_gif(world, drives_of(episode, world), title=title)
    if suffix == ".svg":
        return render.draw_svg(world, trail=trails, title=title).encode()
    if suffix == ".html":
        return render.draw_html(world, trail=trails, title=title).encode()
    return render.draw_png(world, trail=trails, title=title)
