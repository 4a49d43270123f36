"""Compare controllers over worlds for the page: one cell after another, as ``worldgen compare``."""

from __future__ import annotations

from dataclasses import replace

from fuzz.studio.requests.folder import Opened, answer
from fuzz.studio.requests.limits import MOST_STEPS
from fuzz.studio.requests.messages import restored
from fuzz.studio.requests.protocol import (
    CellPart,
    ColumnTotal,
    Compare,
    ComparedWorld,
    ComparisonMessage,
    RowPart,
    SendPart,
)
from fuzz.studio.requests.running import check_registered, scenario_of
from sim.compare.comparison import Comparison, ComparisonCell, NamedWorld, compare, standing
from sim.compare.report import describe_detail
from sim.options.run import step_budget
from sim.scenario import Scenario
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
from worldgen.files.grid import read_world
from worldgen.generation import generate
from worldgen.reach import decide
from worldgen.world import World


@answer.register
def _compare(
    request: Compare, opened: Opened, part: SendPart[RowPart | CellPart]
) -> ComparisonMessage:
    # Check the whole message before the first run.
    scenarios = {label: scenario_of(label, request, opened) for label in request.controllers}
    # Send each cell once it is known, so that the page fills while the runs continue.
    worlds = []
    rows = []
    for row, one in enumerate(request.worlds):
        # A world that cannot be read only affects its own row.
        try:
            world = _world(one, opened)
        except WorldgenError as error:
            part(RowPart(row=row, error=opened.folder.refusal(error)))
            continue
        part(RowPart(row=row, width=world.width, height=world.height))
        named = NamedWorld(str(row), world)
        cells = []
        for column, (label, scenario) in enumerate(scenarios.items()):
            try:
                cell = _cell(named, label, scenario, request.seeds, request.steps)
            except WorldgenError as error:
                part(RowPart(row=row, column=column, error=opened.folder.refusal(error)))
                continue
            cells.append(cell)
            part(
                CellPart(
                    row=row,
                    column=column,
                    verdict=cell.verdict,
                    detail=describe_detail(cell),
                    steps=cell.steps,
                    time=cell.time,
                    runs=len(cell.runs),
                    reached=cell.reached,
                    seed=cell.shown.seed,
                )
            )
        # Only rows that every controller completed are ranked and totalled.
        if len(cells) == len(scenarios):
            worlds.append(named)
            rows.append(tuple(cells))
            part(RowPart(row=row, best=[*standing([cell.rank_time for cell in cells])[0]]))
    totals = Comparison(tuple(scenarios), tuple(worlds), tuple(rows)).totals() if rows else ()
    columns = [
        ColumnTotal(one.runs, one.reached, one.wins, one.shared_wins, one.mean_time)
        for one in totals
    ]
    return ComparisonMessage(columns, len(rows))


def _world(asked: ComparedWorld, opened: Opened) -> World:
    """Return a world that the page sent, a world in the folder, or one that a family makes."""
    if asked.world is not None:
        world = restored(asked.world)
    elif asked.family is not None and asked.seed is not None:
        check_registered("family", asked.family, FAMILIES.names())
        world = generate(asked.family, int(asked.seed))
    elif asked.file is not None:
        world = read_world(opened.folder.place(asked.file))
    else:
        raise InvalidParameter("wrong-message", "a world is not named", "name its file")
    if world.certificate is None:
        world = replace(world, certificate=decide(world).certificate)
    return world


def _cell(
    world: NamedWorld, label: str, scenario: Scenario, seeds: int, steps: int | None
) -> ComparisonCell:
    """Return one cell, within the same budget as a run on the page Play."""
    budget = step_budget(world.world, scenario.run) if steps is None else steps
    budget = min(max(budget, 1), MOST_STEPS)
    return compare([world], {label: scenario}, seeds=seeds, steps=budget).cells[0][0]
