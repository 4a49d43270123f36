"""Compare controllers over worlds for the page: one cell after another, as ``worldgen compare``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from fuzz.studio.requests.folder import Opened
from fuzz.studio.requests.limits import MOST_COMPARED, MOST_SEEDS, MOST_STEPS, MOST_WORLDS
from fuzz.studio.requests.messages import Request, SendPart, field, restored, seed_of
from fuzz.studio.requests.running import check_registered, scenario_of
from sim.compare.comparison import Comparison, ComparisonCell, NamedWorld, Total, compare, standing
from sim.compare.report import describe_detail
from sim.options.run import step_budget
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world
from worldgen.generation import generate
from worldgen.reach import decide
from worldgen.world import World


@dataclass(frozen=True)
class CompareAnswers(Opened):
    """The answer of the comparison's page."""

    def compare(self, message: Request, part: SendPart) -> dict[str, Any]:
        """Run each controller in each world, row by row; each cell is a part."""
        # Check the whole message before the first run.
        scenarios = self._scenarios(message)
        asked = _counted(message, "worlds", MOST_WORLDS)
        seeds = field(message, "seeds", int)
        if not 1 <= seeds <= MOST_SEEDS:
            raise InvalidParameter(
                "out-of-range", "{seeds} seeds", "choose 1 to {most}", seeds=seeds, most=MOST_SEEDS
            )
        steps = None if message.get("steps") is None else field(message, "steps", int)
        # Send each cell once it is known, so that the page fills while the runs continue.
        worlds = []
        rows = []
        for row, one in enumerate(asked):
            # A world that cannot be read only affects its own row.
            try:
                world = self._world(one)
            except WorldgenError as error:
                part({"row": row, "error": self.folder.refusal(error)})
                continue
            part({"row": row, "width": world.width, "height": world.height})
            named = NamedWorld(str(row), world)
            cells = []
            for column, (label, scenario) in enumerate(scenarios.items()):
                place = {"row": row, "column": column}
                try:
                    cell = _cell(named, label, scenario, seeds, steps)
                except WorldgenError as error:
                    part({**place, "error": self.folder.refusal(error)})
                    continue
                cells.append(cell)
                part({**place, **_shown(cell)})
            # Only rows that every controller completed are ranked and totalled.
            if len(cells) == len(scenarios):
                worlds.append(named)
                rows.append(tuple(cells))
                part({"row": row, "best": standing([cell.rank_time for cell in cells])[0]})
        totals = Comparison(tuple(scenarios), tuple(worlds), tuple(rows)).totals() if rows else ()
        return {"totals": [_total(total) for total in totals], "rows": len(rows)}

    def _scenarios(self, message: Request) -> dict[str, Scenario]:
        labels = _counted(message, "controllers", MOST_COMPARED)
        return {str(label): scenario_of(label, message, self) for label in labels}

    def _world(self, asked: object) -> World:
        """Return a world that the page sent, a world in the folder, or one that a family makes."""
        if not isinstance(asked, dict):
            raise InvalidParameter(
                "wrong-type", "a world in the message is not an object", "reload the page"
            )
        if "world" in asked:
            world = restored(field(asked, "world", dict))
        elif "family" in asked:
            family = field(asked, "family", str)
            check_registered("family", family, FAMILIES.names())
            world = generate(family, seed_of(asked))
        else:
            world = read_world(self.folder.place(field(asked, "file", str)))
        if world.certificate is None:
            world = replace(world, certificate=decide(world).certificate)
        return world


def _counted(message: Request, name: str, most: int) -> Sequence[object]:
    """Return a list from the message; it must have 1 to ``most`` entries."""
    found: Sequence[object] = field(message, name, list)
    if not 1 <= len(found) <= most:
        raise InvalidParameter(
            "out-of-range",
            "{count} {what}",
            "choose 1 to {most}",
            count=len(found),
            what=name,
            most=most,
        )
    return found


def _cell(
    world: NamedWorld, label: str, scenario: Scenario, seeds: int, steps: int | None
) -> ComparisonCell:
    """Return one cell, within the same budget as a run on the page Play."""
    budget = step_budget(world.world, scenario.run) if steps is None else steps
    budget = min(max(budget, 1), MOST_STEPS)
    return compare([world], {label: scenario}, seeds=seeds, steps=budget).cells[0][0]


def _shown(cell: ComparisonCell) -> dict[str, Any]:
    return {
        "verdict": cell.verdict,
        "detail": describe_detail(cell),
        "steps": cell.steps,
        "time": cell.time,
        "runs": len(cell.runs),
        "reached": cell.reached,
        "seed": cell.shown.seed,
    }


def _total(total: Total) -> dict[str, Any]:
    return {
        "runs": total.runs,
        "reached": total.reached,
        "wins": total.wins,
        "shared": total.shared_wins,
        "mean_time": total.mean_time,
    }
