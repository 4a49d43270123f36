"""Units of a campaign: pure functions of (configuration, unit number, search state).

Any worker can do any of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from fuzz.search.plan import planned_strategy
from fuzz.search.registry import strategy_of
from fuzz.search.task import SearchTask
from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import NO_DEADLINE, Deadline
from fuzz.unit.result import ScreenedRun, SearchState, UnitResult
from sim.clock.controller_time import Effort
from sim.clock.stopping import OutOfTime, check_time, stopping_when
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.lines_run import report_lines, watch_lines


def run_unit(
    config: CampaignConfig,
    unit: int,
    memory: SearchState | None = None,
    deadline: Deadline = NO_DEADLINE,
    screened: Mapping[int, ScreenedRun] = MappingProxyType({}),
) -> UnitResult:
    """Do one unit: draw, run, prove, classify.

    Without a deadline the result depends only on the arguments.

    Args:
        config: Definition of the campaign.
        unit: Number of the unit.
        memory: Findings of the units up to the epoch before the last; none if omitted.
        deadline: When to end with the results so far; the result then has ``cut`` set.
        screened: Runs that it made before it was cut short, which are not made again.
    """
    began = Effort.so_far()
    known = SearchState() if memory is None else memory
    name = planned_strategy(config, unit, known)
    result = UnitResult(strategy=name)
    triage = Triage(config, result, deadline)
    # State that the controller has kept from other units must not matter here.
    watch_lines(as_loaded(config.scenario.controller))
    try:
        with stopping_when(deadline.to_begin_is_over):
            check_time()
            strategy_of(name)(SearchTask(name, config, unit, known, triage, screened))
    except OutOfTime:
        result.cut = True
    except KeyboardInterrupt:
        result.cut = result.interrupted = True
    triage.end()
    report_lines()
    result.effort = began.since()
    result.lines = result.effort.lines
    return result
