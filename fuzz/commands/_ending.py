"""Show what a campaign found once it has ended: text, one JSON object, reports for CI services."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import UNSET, structs

from fuzz.campaign.store import SUMMARY, Summary
from fuzz.campaign.summary import (
    describe_share,
    describe_strategies,
    describe_time,
    describe_units,
    describe_unrun,
)
from fuzz.facts.hazards import hazard_words
from fuzz.failure import Failure
from fuzz.layouts.map_windows import describe_tried
from fuzz.overview import CauseResult, cause_of
from fuzz.overview.building import Overview
from fuzz.overview.describe import describe
from fuzz.overview.terminal import describe_coverage, overview_lines
from fuzz.unit.answer import Answer
from fuzz.unit.config import CampaignConfig
from sim.controllers.contract import runs_differ, state_survives_reset
from worldgen.cli.output import emit_json, note, say
from worldgen.files.json_file import plain
from worldgen.render import wants_color
from worldgen.support.plain_text import counted, shown
from worldgen.support.results import results

if TYPE_CHECKING:
    from fuzz.ci import Report
    from fuzz.corpus import Baseline


@dataclass(frozen=True)
class Ending:
    """A campaign that has ended.

    Args:
        config: Its definition.
        overview: What it found.
        summary: Its numbers.
        failing: By the stem of their file, the failures that make the exit code 1.
        hazards: The others that it shows: those whose fire the controller could not have avoided.
        known: The failures that were known before.
        variants: Number of variants of known causes that were not known.
        interrupted_steps: Steps of the controller that were still running when time was up.
        out: Its folder.
        lasts: True if the folder still exists after the command.
        remedy: The command that gives it more time.
    """

    config: CampaignConfig
    overview: Overview
    summary: Summary
    failing: Mapping[str, Failure]
    hazards: Mapping[str, Failure]
    known: Baseline
    variants: int
    interrupted_steps: int
    out: Path
    lasts: bool
    remedy: str

    def print_json(self) -> None:
        """Print one object, for scripts."""
        lists = {"failures": self._listed(self.failing), "hazards": self._listed(self.hazards)}
        emit_json(SUMMARY.table(self.summary) | plain(self.overview.result) | lists)

    def print_text(self) -> None:
        """Print the summary, and notes about what the user may want to change."""
        summary = self.summary
        result = structs.replace(self.overview.result, summary=summary)
        color = wants_color(results())
        for line in overview_lines(
            self.overview._replace(result=result),
            self.out if self.lasts else None,
            remedy=self.remedy,
            robots=self.config.robots,
        ):
            say(line, color=color)
        if summary.known:
            times = counted(sum(summary.known.values()), "time")
            new = f"; {counted(self.variants, 'new variant')} of known causes"
            say(
                f"known: {counted(len(summary.known), 'cause')}, met {times}"
                f"{new if self.variants else ''}"
            )
        say(
            f"seed {summary.seed}: {describe_units(summary)}, "
            f"{counted(summary.steps, 'step')} in {summary.seconds:.1f} s"
        )
        if summary.tried:
            say(f"tried on the map: {describe_tried(summary.tried)}")
        # Add notes about slow, stateful or hanging controllers.
        controller = self.config.scenario.controller
        if (share := describe_share(summary, controller)) is not None:
            note(share)
        if summary.survives_reset is not UNSET:
            note(str(state_survives_reset(controller, summary.survives_reset)))
        if summary.differs_by is not UNSET:
            note(str(runs_differ(controller, summary.differs_by)))
        if summary.unrun_lines is not UNSET:
            note(describe_unrun(summary))
        if self.interrupted_steps:
            note(
                f"{counted(self.interrupted_steps, 'step')} of {controller} were still running when "
                f"time was up, and had to be interrupted; if a step may hang, run the controller "
                f"as a program: each step then has a deadline, and a hang is a failure "
                f"(docs/reference/controllers.md)"
            )
        if self.hazards:
            note(f"--count-hazards makes failures of {hazard_words(self.hazards.values())}")

    def print_in_detail(self) -> None:
        """Print each failure with its picture, and the yield of each strategy."""
        summary = self.summary
        met = Counter(summary.met)
        for stem, failure in sorted(self.failing.items()):
            say(describe(failure, self._path(stem), met=met))
        if self.hazards:
            hazards = self.hazards.values()
            say(f"{hazard_words(hazards)}: {counted(len(hazards), 'failure')}")
            say("")
        for stem, failure in sorted(self.hazards.items()):
            say(describe(failure, self._path(stem), met=met))
        verdicts = ", ".join(
            f"{count} {verdict}" for verdict, count in Counter(summary.verdicts).most_common()
        )
        say(f"{describe_time(summary)}; quick runs: {verdicts or 'none'}; {met.total()} examined")
        natural = self.overview.result.natural
        if natural is not None and natural.worlds:
            say(describe_coverage(natural))
        say(describe_strategies(summary))
        if summary.known:
            often = ", ".join(
                f"{shown(group)} {counted(times, 'time')}"
                for group, times in sorted(summary.known.items())
            )
            say(f"known: {counted(len(summary.known), 'cause')}, met {often}")

    def for_ci(self, *, accepts_no_answer: bool) -> Report:
        """Return the campaign in the form of the reports for CI services.

        Args:
            accepts_no_answer: True if the user accepts that there is no answer.
        """
        from fuzz.ci import CiFinding, FindingState, Report

        summary = self.summary
        facts = {
            "controller": shown(summary.controller),
            "motion": summary.motion,
            "answer": str(summary.answer),
        }
        facts |= {
            name: str(getattr(summary, name)) for name in ("seed", "units", "worlds", "steps")
        }
        facts["seconds"] = f"{summary.seconds:.1f}"
        facts |= {
            f"{part}_seconds": f"{summary.times[part]:.1f}"
            for part in ("search", "shrinking")
            if summary.times
        }
        # List what is new, the worst cause first, then the known failures that were met.
        new = [
            CiFinding.of(
                one,
                self._path(stem),
                FindingState.NEW if stem in self.failing else FindingState.HAZARD,
                cause=cause,
            )
            for stem, one, cause in self._in_order()
        ]
        stored = sorted(self.known.failures.items(), key=lambda item: (item[0][2], item[1][0]))
        met = [
            CiFinding.of(one, path, FindingState.KNOWN)
            for (_, _, group), (path, one) in stored
            if summary.known.get(group)
        ]
        return Report(
            "fuzz",
            (*new, *met),
            facts,
            no_answer=str(summary.answer_reason) if summary.answer == Answer.NONE else "",
            remedy=shown(self.remedy),
            is_accepted=accepts_no_answer,
        )

    def _in_order(self) -> list[tuple[str, Failure, CauseResult | None]]:
        """Return the shown failures by stem, the worst cause first and of each the clearest first.

        The clearest comes with its cause, which tells what it depends on.
        """
        rest = {**self.failing, **self.hazards}
        ordered = []
        for cause in self.overview.result.causes:
            for file in cause.files:
                stem = file.removesuffix(".grid")
                example = cause if file == cause.file else None
                ordered.append((stem, rest.pop(stem), example))
        return ordered + [(stem, one, None) for stem, one in sorted(rest.items())]

    def _listed(self, failures: Mapping[str, Failure]) -> list[dict[str, object]]:
        return [
            {
                "file": str(self._path(stem)),
                "verdict": failure.verdict,
                "cause": cause_of(failure).value,
                "class": stem,
                "solid_cells": failure.world.solid_cells,
                "shrinking": failure.shrinking.value,
                "replay": failure.replay_command(self._path(stem)),
            }
            for stem, failure in sorted(failures.items())
        ]

    def _path(self, stem: str) -> Path:
        return self.out / f"{stem}.grid"
