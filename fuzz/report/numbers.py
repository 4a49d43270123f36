"""Describe a failure in words and numbers, for the table next to its picture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

from fuzz.boundary import describe_boundaries
from fuzz.cause import CAUSE, CIRCUMSTANCE, GAP
from fuzz.failure import SHRINKING, ShrinkState
from fuzz.overview.describe import describe_seeds
from fuzz.report.gather import ReplayedFailure
from sim.evidence import JointLoopEvidence, LoopEvidence
from worldgen.robot_overrides import describe_body
from worldgen.support.plain_text import counted, describe_value
from worldgen.world import Cut, Value, Witness, World

Row: TypeAlias = tuple[str, str]


class FactGroup(NamedTuple):
    """Facts under a heading; raw ones, as the file has them, are folded away at first."""

    title: str
    rows: list[Row]
    is_raw: bool = False


# Details that have their own row, or are not for readers; others are listed under their names.
_SAID = (
    "class",
    CAUSE,
    CIRCUMSTANCE,
    GAP,
    "motion_version",
    "original",
    "one_minimal",
    SHRINKING,
    "failing_seeds",
    "failing_share_at_least",
    "chance",
    "states",
    "boundaries",
    "found_by",
    "kept",
    "shrunk_from",
)
_SHRUNK = {
    ShrinkState.DONE: "done: no cell, row or column can be removed",
    ShrinkState.CUT_SHORT: "cut short: time ran out before it finished",
    ShrinkState.NONE: "none: the world is as it was found",
}


def groups(seen: ReplayedFailure) -> list[FactGroup]:
    """Return everything known about a failure, as rows of name and value under headings."""
    # Groups without rows are left out.
    record = seen.failure.record
    found = [
        FactGroup("Failure", _of_the_failure(seen)),
        FactGroup("Run", _of_the_run(seen)),
        FactGroup("World", _of_the_world(seen.failure.world)),
        FactGroup("Search", _of_the_search(seen)),
        FactGroup("Options", _as_written(record.parameters), is_raw=True),
        FactGroup("Evidence", _as_written(record.evidence), is_raw=True),
    ]
    return [group for group in found if group.rows]


def _as_written(table: Mapping[str, Value]) -> list[Row]:
    return [(name, describe_value(value)) for name, value in table.items()]


def _of_the_failure(seen: ReplayedFailure) -> list[Row]:
    record = seen.failure.record
    rows = [
        ("verdict", record.verdict),
        ("cause", seen.failure.group),
        ("controller", seen.failure.label),
        (
            "motion model",
            f"{record.motion}, version {record.details.get('motion_version', 'unknown')}",
        ),
        ("seed of the run", str(record.seed)),
        ("replayed for this report", _replayed(seen)),
    ]

    # How reliably it fails: seeds, the exact answer about chance, boundaries.
    seeds = describe_seeds(seen.failure)
    if seeds:
        least = record.details.get("failing_share_at_least")
        bound = (
            f"; at least {least:.1%} of all, with 95 % confidence"
            if isinstance(least, float)
            else ""
        )
        rows.append(("chance", f"{seeds}{bound}"))
    if "chance" in record.details:
        states = (
            f", over {describe_value(record.details['states'])} states"
            if "states" in record.details
            else ""
        )
        rows.append(("exact answer", f"{describe_value(record.details['chance'])}{states}"))
    begins = describe_boundaries(seen.failure)
    if begins:
        rows.append(("boundary", begins))
    rows.append(("shrinking", _SHRUNK[seen.failure.shrinking]))
    return rows


def _replayed(seen: ReplayedFailure) -> str:
    if seen.replay.confirmed:
        return "confirmed: same verdict, evidence and digest"
    return f"not confirmed: {seen.replay.reason}"


def _of_the_run(seen: ReplayedFailure) -> list[Row]:
    episode = seen.replay.episode
    rows = []
    if episode is not None:
        rows += [
            ("steps", f"{episode.steps:,} ({episode.time:.6g} s)"),
            ("path length", f"{episode.path_length:.4g} m"),
            ("contacts", str(episode.collisions)),
        ]
        # How much longer the path is than the proof that the target is reachable.
        witness = seen.failure.world.certificate
        if isinstance(witness, Witness) and witness.length > 0:
            rows.append(("path / witness", f"{episode.path_length / witness.length:.3g}"))
        loop = episode.evidence
        if isinstance(loop, LoopEvidence | JointLoopEvidence) and episode.steps:
            step = episode.time / episode.steps
            rows.append(("loop entered", f"step {loop.entry:,} ({loop.entry * step:.6g} s)"))
            rows.append(("period", f"{loop.period:,} steps ({loop.period * step:.6g} s)"))
    return [*rows, ("trace digest", seen.failure.record.trace_digest)]


def _of_the_world(world: World) -> list[Row]:
    side = world.cell_size
    line = world.timeline
    robot = world.robots[0]
    body = f"radius {robot.radius:.4g} m"
    if not robot.is_disc or robot.drive.is_car:
        body = describe_body(robot)
    rows = [
        ("cells", f"{world.width} x {world.height}, {world.solid_cells:,} solid"),
        ("size", f"{world.width * side:.4g} x {world.height * side:.4g} m, cells of {side:.4g} m"),
        ("robot", f"{body}, at most {world.robot_speed:.4g} m/s"),
    ]
    if world.is_dynamic:
        rows.append(("changes", f"{len(line):,}, the last at {line.last_time:.6g} s"))
    # What proves that the target is reachable or walled off.
    proof = world.certificate
    if isinstance(proof, Witness):
        rows.append(("witness", f"{proof.length:.4g} m in {proof.duration:.4g} s"))
        fits = "the radius of the largest disc that fits"
        if not robot.is_disc:
            fits = "by which the footprint could be padded all around"
        rows.append(("clearance", f"{proof.clearance:.4g} m, {fits}"))
    elif isinstance(proof, Cut) and proof.boxes is not None:
        rows.append(("cut", f"{len(proof.boxes):,} sets of poses that overlap a wall"))
    elif isinstance(proof, Cut):
        rows.append(
            ("cut", f"{len(proof.cells)} cells stop every disc above {proof.clearance:.4g} m")
        )
    made = world.provenance
    if made is not None:
        rows.append(("generated by", f"{made.family}, version {made.version}, seed {made.seed}"))
        rows += [("on the map", changed) for changed in made.changed]
    return rows


def _of_the_search(seen: ReplayedFailure) -> list[Row]:
    details = seen.failure.record.details
    rows = []
    if "found_by" in details:
        rows.append(("found by strategy", describe_value(details["found_by"])))
    # The campaign knows how often and when the cause was met.
    if seen.campaign is not None:
        campaign = seen.campaign.summary
        group = seen.failure.group
        if group in campaign.met:
            rows.append(("cause met", counted(campaign.met[group], "time")))
        first = next((find for find in campaign.found if find.cause == group), None)
        if first is not None:
            until = f"in world {first.worlds:,}, after {first.steps:,} steps, {first.seconds:.3g} s"
            rows.append(("cause first met", until))
        if campaign.survives_reset:
            rows.append(("state that survives reset()", ", ".join(campaign.survives_reset)))
        if campaign.differs_by:
            rows.append(("makes equal runs differ", ", ".join(campaign.differs_by)))
    if "shrunk_from" in details:
        # Versions before causes kept only the verdict.
        kept = ", kept the verdict and the cause" if details.get("kept") == CAUSE else ""
        rows.append(("shrunk from", f"{describe_value(details['shrunk_from'])} solid cells{kept}"))
    return rows + _others(details)


def _others(details: Mapping[str, Value]) -> list[Row]:
    return [
        (name.replace("_", " "), describe_value(value))
        for name, value in details.items()
        if name not in _SAID
    ]
