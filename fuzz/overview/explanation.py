"""Explain one failure: what happens in its run, why, and after which changes the robot arrives."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from fuzz.cause import CAUSE, CIRCUMSTANCE, GAP, Diagnosis
from fuzz.failure import Failure
from fuzz.layouts.variation import changes_on_map
from fuzz.overview.counterfactual import Counterfactuals, counterfactuals
from fuzz.overview.describe import run_to_draw
from fuzz.triage.diagnosis import diagnosis_of
from fuzz.triage.run_facts import RunFacts, run_facts
from sim.clock.stopping import stopping_when
from sim.drawing.picture import trails_of
from sim.episode import Episode
from sim.evidence import evidence_table
from sim.verdict import ARRIVALS
from worldgen import render
from worldgen.errors import WorldgenError
from worldgen.files.json_file import plain
from worldgen.render.overlay import naming
from worldgen.support.plain_text import shown


@dataclass(frozen=True)
class Explanation:
    """What is known about a failure.

    Args:
        failure: The failure, as its controller runs now.
        verdict: The verdict now; empty if its controller cannot be run.
        diagnosis: Why it fails; ``None`` if its controller cannot be run, or if the robot arrives now.
        words: What happened in its run, to follow the verdict.
        facts: What its run shows.
        why: The single changes after which its robot arrives; ``None`` if they cannot be tried.
        problem: Why they cannot be tried; else empty.
    """

    failure: Failure
    verdict: str = ""
    diagnosis: Diagnosis | None = None
    words: str = ""
    facts: RunFacts = field(default_factory=RunFacts)
    why: Counterfactuals | None = None
    problem: str = ""

    @property
    def goes_wrong(self) -> str:
        """The sentence of the cause; empty without a cause."""
        return "" if self.diagnosis is None else self.diagnosis.sentence(self.failure.world)

    def table(self) -> dict[str, Any]:
        """Return the form of this record in JSON; ``docs/reference/verdicts.md`` describes it."""
        untried = {"changes": [], "sentence": "", "problem": self.problem}
        return {
            "verdict": self.verdict,
            "cause": "" if self.diagnosis is None else self.diagnosis.cause.value,
            "goes_wrong": self.goes_wrong,
            **(untried if self.why is None else self.why.table()),
            **plain(self.facts),
        }

    def text(self) -> list[str]:
        """Return the lines for the terminal; none if nothing is known but the problem."""
        if self.why is None and not self.words and not self.facts.text():
            return []
        failure = self.failure
        who = "The fleet" if failure.world.is_fleet else "It"
        lines = [shown(f"{failure.who}: {self.verdict}{self.words}")]
        if self.diagnosis is not None:
            lines.append(f"{self.diagnosis.cause}: {self.goes_wrong}")
        if changes := changes_on_map(failure.world):
            lines.append(shown(changes))
        if self.why is not None:
            lines.append(shown(f"{who} {self.why.describe()}."))
        return lines + self.facts.text()

    def picture(self, suffix: str) -> bytes:
        """Return a picture with the cells that the changes name.

        Args:
            suffix: ``.svg`` or ``.png``.
        """
        failure = self.failure
        cells = () if self.why is None else self.why.cells
        depends = self.goes_wrong if self.why is None else self.why.describe()
        trails = naming(trails_of(run_to_draw(failure)[0], failure.world), cells)
        title = f"{self.verdict}: {depends}"
        if suffix == ".svg":
            return render.draw_svg(failure.stored, trail=trails, title=title).encode()
        return render.draw_png(failure.stored, trail=trails, title=title)


def explain_failure(
    failure: Failure,
    controller: str | None = None,
    *,
    with_code: bool = True,
    seconds: float = math.inf,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Explanation:
    """Run a failure and every changed scenario, and return what they show.

    Args:
        failure: The failure.
        controller: A controller to use instead of the recorded one.
        with_code: False to leave out what runs inside the controller.
        seconds: Time limit for trying changes, after which those not yet tried are left out.
        progress: Called after each changed run with the number of runs so far, and about how many
            are made in all.
    """
    # Another controller has neither the cause nor the class of the recorded one.
    if controller is not None:
        failure = _unclassified(failure.driven_by(controller))
    try:
        episode, words = run_to_draw(failure)
    except WorldgenError as error:
        return Explanation(failure, problem=str(error))
    failure = _as_run(failure, episode)
    if failure.verdict in ARRIVALS and failure.oracle is None:
        problem = "the robot arrives now"
        return Explanation(failure, failure.verdict, words=words, problem=problem)
    known = Explanation(failure, failure.verdict, diagnosis_of(failure), words)
    try:
        known = replace(known, facts=run_facts(failure, episode, with_code=with_code))
        end = time.monotonic() + seconds
        with stopping_when(lambda: time.monotonic() >= end):
            why = counterfactuals(failure, progress=progress)
            return replace(known, why=why)
    except WorldgenError as error:
        return replace(known, problem=str(error))


def _unclassified(failure: Failure) -> Failure:
    """Return a failure without the recorded cause and signature."""
    return failure.without(CAUSE, CIRCUMSTANCE, GAP, "class")


def _as_run(failure: Failure, episode: Episode) -> Failure:
    """Return a failure with what happens now, if the controller is another one or has changed."""
    is_judged_otherwise = failure.is_breach or failure.oracle is not None
    if is_judged_otherwise or episode.trace_digest == failure.record.trace_digest:
        return failure
    failure = _unclassified(failure)
    return replace(
        failure,
        record=replace(
            failure.record,
            verdict=episode.verdict,
            trace_digest=episode.trace_digest,
            evidence=evidence_table(episode.evidence),
        ),
    )
