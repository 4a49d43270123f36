"""The faults: for each promise, a small change to the sources that breaks it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """One change to one file that breaks one promise.

    Args:
        name: Its name in the runner.
        promise: What no longer holds.
        file: The source file, from the repository's root.
        text: The original text, which occurs exactly once in the file.
        planted: The text that replaces it.
        tests: Files that are expected to catch it; they run first.
    """

    name: str
    promise: str
    file: str
    text: str
    planted: str
    tests: tuple[str, ...]


FAULTS = (
    # Worlds and their files
    Fault(
        "upside-down",
        "a world that is written and read is the same world",
        "worldgen/files/grid/writer.py",
        "rows = flip_rows(world.walls)",
        "rows = world.walls",
        ("tests/worldgen/test_grid_file.py",),
    ),
    Fault(
        "other-worlds",
        "a family's seed gives the same world as ever",
        "worldgen/random_streams.py",
        "return low + self.below(high - low + 1)",
        "return high - self.below(high - low + 1)",
        ("tests/worldgen/test_random_streams.py", "tests/contracts/test_families.py"),
    ),
    # Proofs
    Fault(
        "disc-too-small",
        "the prover lets no disc through a gap that is too narrow",
        "worldgen/reach/still/walls.py",
        "return (radius * UNIT) ** 2",
        "return (radius * UNIT - UNIT // 8) ** 2",
        ("tests/worldgen/test_reach.py",),
    ),
    Fault(
        "free-cells",
        "the checker refuses a cut through a cell that is free",
        "worldgen/reach/check/certificate.py",
        "outside or bool(blocked[iy, ix]),",
        "outside or ix >= 0,",
        ("tests/worldgen/test_reach_check.py",),
    ),
    Fault(
        "ends-early",
        "the checker refuses a witness that ends outside the target",
        "worldgen/reach/check/certificate.py",
        "missed <= TOLERANCE,",
        "missed <= 1.0,",
        ("tests/worldgen/test_reach_check.py",),
    ),
    Fault(
        "fire-forgotten",
        "the checker refuses a witness through a cell while it is blocked",
        "worldgen/reach/check/certificate.py",
        "(since[cell] <= end[piece]) & (until[cell] > begin[piece])",
        "(since[cell] <= end[piece]) & (until[cell] > end[piece])",
        ("tests/worldgen/test_reach_check.py", "tests/worldgen/test_reach_timed.py"),
    ),
    Fault(
        "no-margin-of-time",
        "a timed witness is clear of every change, at every time",
        "worldgen/reach/timed/earliest.py",
        "points[far], times[at] - MARGIN, times[far] + MARGIN",
        "points[far], times[at] - MARGIN, times[at] + MARGIN",
        ("tests/worldgen/test_reach_timed.py",),
    ),
    # The simulator
    Fault(
        "corners-cut",
        "under swept no disc cuts a wall's corner; shapely agrees",
        "sim/core/motion/geometry.c",
        "if (!corner_is_clear(clear_sq, dx * cx + dy * cy, across, length_sq)) {",
        "if (!corner_is_clear(clear_sq / 4, dx * cx + dy * cy, across, length_sq)) {",
        ("tests/agreement/test_swept_against_shapely.py",),
    ),
    Fault(
        "tunnel-unseen",
        "a robot whose centre goes through a wall ends as tunnel",
        "sim/core/episode/step.c",
        "report->ending == WG_LIMIT && may_tunnel && wg_segment_crosses_box(",
        "report->ending == WG_LOOP && may_tunnel && wg_segment_crosses_box(",
        ("tests/sim/test_episode.py",),
    ),
    Fault(
        "loop-missed",
        "a run whose complete state comes back within its budget is a loop",
        "sim/core/episode/recurrence.h",
        "if (step < search->next && step < budget) {",
        "if (step < search->next && step <= budget) {",
        ("tests/agreement/test_no_loop_is_missed.py", "tests/sim/test_episode.py"),
    ),
    Fault(
        "late-entry",
        "a loop's entry is the first state that comes back",
        "sim/core/episode/recurrence.c",
        "while (entry > quiet && log[entry - 1] == log[entry - 1 + period]) {",
        "while (entry > quiet + 1000 && log[entry - 1] == log[entry - 1 + period]) {",
        ("tests/sim/test_episode.py", "tests/sim/test_batch.py"),
    ),
    Fault(
        "short-digest",
        "the digest depends on every word of every state",
        "sim/core/episode/step.c",
        "for (int64_t k = 0; k < words; k++) {\n        digest = hash(digest, wg_word(robot->body, "
        "k));",
        "for (int64_t k = 0; k < words - 1; k++) {\n        digest = hash(digest, "
        "wg_word(robot->body, k));",
        ("tests/sim/test_episode.py", "tests/quality/test_library_failures.py"),
    ),
    Fault(
        "start-of-another",
        "many runs are the single runs, bit for bit",
        "sim/episode/batch.py",
        "starts = poses or (world.start,)",
        "starts = poses or (worlds[0].start,)",
        ("tests/agreement/test_drivers.py",),
    ),
    Fault(
        "lockstep-in-transit",
        "robots in lockstep do what each does alone",
        "sim/core/runs/batch.c",
        "settings->steps = settings->loop_entry + report->period;",
        "settings->steps = settings->loop_entry + 2 * report->period;",
        ("tests/agreement/test_drivers.py",),
    ),
    Fault(
        "command-of-a-class",
        "a controller as a Python class runs as its compiled twin",
        "sim/core/runs/python_act.c",
        "taken[3] = used_random;",
        "taken[3] = 1.0;",
        ("tests/sim/test_episode.py", "tests/sim/test_vector_controllers.py"),
    ),
    Fault(
        "secret-memory",
        "a controller with memory that it doesn't declare proves no loop",
        "sim/runners/python_loop.py",
        "complete = begun is not None and host.is_unchanged(begun)",
        "complete = True",
        ("tests/sim/test_episode.py",),
    ),
    Fault(
        "clock-forgiven",
        "a class whose moves depend on a clock proves no loop",
        "sim/runners/lattice.py",
        "return other.trace is not None and np.array_equal(other.trace.states, trace.states)",
        "return other.trace is not None",
        ("tests/sim/test_frozen_time.py",),
    ),
    Fault(
        "held-clock-forgiven",
        "a class proves no loop, however it holds a clock",
        "sim/runners/lattice.py",
        "if self.host.has_read_real:",
        "if False:",
        ("tests/sim/test_held_clocks.py",),
    ),
    Fault(
        "chance-unseeded",
        "runs with frozen time repeat",
        "sim/controllers/frozen_time.py",
        "random.seed(self._seed)",
        "random.seed()",
        ("tests/sim/test_frozen_time.py",),
    ),
    Fault(
        "field-unset",
        "a controller's name sets the fields of its class",
        "sim/controllers/fields.py",
        "return kind(**given)",
        "return kind()",
        ("tests/sim/test_fields.py",),
    ),
    Fault(
        "reused-confirmation",
        "the second run that confirms a failure calls the controller",
        "fuzz/triage/judging.py",
        "origin.answers.forget(proofs_only=is_loop)",
        "pass",
        ("tests/sim/test_answers.py",),
    ),
    Fault(
        "fast-audit",
        "an audit finds every move that is faster than the robot",
        "sim/audit/judge.py",
        "rows = np.flatnonzero(steps > allowed + slack)",
        "rows = np.flatnonzero(steps > 2.0 * allowed + slack)",
        ("tests/sim/test_audit.py",),
    ),
    Fault(
        "renamed-key",
        "the keys of run --json stay",
        "sim/commands/run.py",
        '"trace_digest": episode.trace_digest,',
        '"digest": episode.trace_digest,',
        ("tests/repo/test_json_keys.py",),
    ),
    # The fuzzer
    Fault(
        "loose-evidence-check",
        "the evidence check of a loop compares two whole periods, state by state",
        "fuzz/evidence_checks/loop.py",
        "if not np.array_equal(one, two):",
        "if one.shape != two.shape:",
        ("tests/fuzz/test_evidence_checks.py",),
    ),
    Fault(
        "counter-drifts",
        "the evidence check of a drifting memory refuses a counter",
        "fuzz/evidence_checks/budget.py",
        "if not (np.abs(change) <= slight).all():",
        "if not np.isfinite(slight).all():",
        ("tests/fuzz/test_memory_drift.py",),
    ),
    Fault(
        "rows-stay",
        "a shrunk failure is 1-minimal: no cell, row or column can go",
        "fuzz/shrink/edits.py",
        "if world.walls.shape[axis] - count < _SMALLEST_SIDE:",
        "if world.walls.shape[axis] - count < _SMALLEST_SIDE + 4:",
        ("tests/fuzz/test_shrink.py",),
    ),
    Fault(
        "order-reversed",
        "smaller means fewer cells before anything else",
        "fuzz/simplicity.py",
        "for measure in ORDER)",
        "for measure in reversed(ORDER))",
        ("tests/fuzz/test_order.py",),
    ),
    Fault(
        "ties-by-chance",
        "of two different failures one comes first, however they are found",
        "fuzz/failure.py",
        "return FailureOrder(self.size, self.digest)",
        'return FailureOrder(self.size, "")',
        ("tests/fuzz/test_failure_order.py",),
    ),
    Fault(
        "classes-merged",
        "failures that touch walls differently are in different classes",
        "fuzz/facts/signature.py",
        "[min(count, 3)]",
        "[min(count, 1)]",
        ("tests/fuzz/test_signature.py", "tests/quality/test_library_failures.py"),
    ),
    Fault(
        "unit-by-chance",
        "with --units a campaign's corpus depends on its seed alone",
        "fuzz/search/task.py",
        "return RandomStream(self.config.seed)",
        "return RandomStream(self.config.seed + id(self) // 16 % 997)",
        ("tests/fuzz/test_campaign.py",),
    ),
    Fault(
        "resumed-short",
        "a campaign that is stopped and resumed ends as one that was not",
        "fuzz/campaign/store/journal.py",
        "steps=self.steps,",
        "steps=0,",
        ("tests/fuzz/test_campaign_interrupted.py",),
    ),
    Fault(
        "old-names",
        "a baseline's failures are run again, so that no old name hides a new cause",
        "fuzz/corpus/baseline.py",
        "now, reason = _failure_now(failure)",
        'now, reason = failure, ""',
        ("tests/fuzz/test_baseline.py",),
    ),
    Fault(
        "any-digest",
        "replay compares the digest of every state",
        "fuzz/triage/replaying.py",
        "if episode.trace_digest != record.trace_digest:",
        "if len(episode.trace_digest) != len(record.trace_digest):",
        ("tests/fuzz/test_commands.py",),
    ),
    Fault(
        "always-zero",
        "replay ends with 1 if a failure is not confirmed",
        "fuzz/commands/replay.py",
        'if not all(result["confirmed"] for result in results):',
        'if not any(result["confirmed"] for result in results):',
        ("tests/fuzz/test_commands.py",),
    ),
    # Formats
    Fault(
        "map-upside-down",
        "an imported map has its walls where they were",
        "worldgen/interop/formats/ros.py",
        "pixels = flip_rows(",
        "pixels = (",
        ("tests/worldgen/test_ros_map.py",),
    ),
    Fault(
        "turned-too-thin",
        "no wall of a turned map is missed",
        "worldgen/interop/geometry/turned_pixels.py",
        "along_cell = 0.5 * per_cell + 0.5 * spread + _ROUNDING",
        "along_cell = 0.5 * per_cell + 0.5 + _ROUNDING",
        ("tests/worldgen/test_ros_turned.py",),
    ),
    Fault(
        "closed-too-much",
        "a blocked world closes only what it has to",
        "worldgen/shutting.py",
        "walls[cell] = False",
        "walls[cell] = True",
        ("tests/worldgen/test_shutting.py",),
    ),
    Fault(
        "export-upside-down",
        "what is exported and imported again is the same map",
        "worldgen/interop/formats/ros.py",
        "solid = flip_rows(world.walls)",
        "solid = world.walls",
        ("tests/worldgen/test_ros_out.py", "tests/worldgen/test_formats.py"),
    ),
    Fault(
        "wrong-sum",
        "a set's manifest has the digest of each file",
        "worldgen/sets/making.py",
        "hashlib.sha256(data).hexdigest(), metrics",
        "hashlib.sha256(data[:-1]).hexdigest(), metrics",
        ("tests/worldgen/test_sets.py",),
    ),
    Fault(
        "harder",
        "the difficulty of a world is the published number",
        "worldgen/difficulty/model.py",
        "(1.0 + total / (1.0 + abs(total))) / 2.0",
        "(1.0 + total / (2.0 + abs(total))) / 2.0",
        ("tests/worldgen/test_difficulty_search.py",),
    ),
    # Plug-ins and pages
    Fault(
        "one-episode",
        "an environment's series of episodes follows its seed, as the simulator's runs do",
        "worldgen_plugins/for_gymnasium/single.py",
        "crew.episode[0] += 1",
        "crew.episode[0] += 0",
        ("tests/plugins/test_gymnasium.py", "tests/agreement/test_environments.py"),
    ),
    Fault(
        "nothing-fails",
        "pytest fails for a stored failure that is not fixed",
        "worldgen_plugins/for_pytest.py",
        "raise NotAsExpected(outcome.reason)",
        "return",
        ("tests/plugins/test_pytest.py",),
    ),
    Fault(
        "loader-left",
        "a program that imports Hypothesis and worldgen finds the modules as they always are",
        "worldgen_plugins/for_hypothesis.py",
        "module.__loader__ = self._loader",
        "module.__loader__ = self",
        ("tests/plugins/test_hypothesis.py",),
    ),
    Fault(
        "another-robot",
        "shrinking keeps what the user of a campaign fixed",
        "fuzz/shrink/trying.py",
        "if candidate is None or not self._constraint.allows(candidate):",
        "if candidate is None:",
        ("tests/fuzz/test_constraint.py",),
    ),
    Fault(
        "fire-not-read",
        "a planner that never reads the timeline is not at fault for a fire",
        "fuzz/facts/hazards.py",
        "    return reads.any",
        "    return True",
        ("tests/fuzz/test_hazards.py",),
    ),
    Fault(
        "any-token",
        "the studio answers only who brings its token",
        "fuzz/studio/gate.py",
        "offered[0] == SUBPROTOCOL and self.is_token(offered[1])",
        "offered[0] == SUBPROTOCOL",
        ("tests/fuzz/test_studio_safety.py", "tests/fuzz/test_studio.py"),
    ),
    Fault(
        "script-in-the-page",
        "nothing in a failure runs code in the report's page",
        "fuzz/player/one_file.py",
        '.replace("<", "\\\\u003c")',
        "",
        ("tests/fuzz/test_report.py",),
    ),
)
