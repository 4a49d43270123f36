"""Find which metrics of a world predict that a controller fails, and how well ``difficulty`` does.

``python -m benchmarks.difficulty`` makes worlds of every family with static worlds, with parameters
drawn at random, runs the library's controllers in them, and prints the tables of
``docs/notes/difficulty.md``: Spearman's rank correlation of every metric with failure, with
bootstrap intervals, and the weights in ``worldgen/difficulty/model.py``. ``--json`` prints one
object; ``--barn FOLDER`` adds the correlations with the published outcomes of the BARN challenge,
from a copy of its repository. It takes ten minutes.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import numpy.typing as npt

from benchmarks.along_the_path import AROUND, around
from benchmarks.library import controllers
from sim import simulate_many
from worldgen.difficulty import METRICS, measure
from worldgen.difficulty.model import difficulty, squashed
from worldgen.difficulty.space import drawn, free_parameters
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.family import FAMILIES
from worldgen.generation import generate
from worldgen.random_streams import RandomStream
from worldgen.reach import decide
from worldgen.world import Pose, Target, World

# The words of a round that takes seconds; the gate runs it.
TINY = ("--worlds", "2")

FAMILIES_AT_REST = ("cave", "corridor", "forest", "maze", "rooms", "rubble", "trap")
# Worlds of each family.
WORLDS = 110
# Two and a half minutes in steps of 15 ms: time for 300 m in worlds of about 3 m.
STEPS = 10_000
# Other names of controllers that are run anyway.
SKIPPED = ("thesis-1", "thesis-2", "thesis-3")
# Adding retreat, turning, decisions and visibility does not improve the prediction.
CANDIDATES = ("concavity", "detour")
# Shares of failed runs between which a controller discriminates worlds.
OFTEN = (0.1, 0.9)
# They ignore the target's direction: they fail if a wall leads around an island.
LED_AWAY = ("wall-left", "wall-right")
BOOTSTRAP = 1000

Floats = npt.NDArray[np.float64]


def worlds_of(name: str, count: int, seed: int) -> Iterator[World]:
    """Yield the worlds of a family, each with different parameters."""
    rng = RandomStream(seed).child("difficulty", name)
    family = FAMILIES.get(name)
    # All are 30 x 30 cells of 0.1 m, or as the family sets them.
    free = free_parameters(family, ("size", "cell_size"))
    made = 0
    while made < count:
        try:
            yield generate(family, rng.below(2**32), **drawn(free, rng, 0.4))
        except (InvalidParameter, GenerationFailed):
            continue
        made += 1


def ranks(values: Floats) -> Floats:
    """Return ranks from 1; equal values share the mean of their ranks."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    shared: Floats = (last - (counts - 1) / 2.0)[place]
    return shared


def spearman(one: Floats, other: Floats) -> float:
    """Return Spearman's rank correlation; NaN if one of them is constant."""
    a = ranks(one)
    b = ranks(other)
    a = a - a.mean()
    b = b - b.mean()
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / size if size else float("nan")


def interval(one: Floats, other: Floats, rng: np.random.Generator) -> tuple[float, float]:
    """Return the middle 95 % of the correlations of worlds resampled with replacement."""
    drawn_again = rng.integers(0, len(one), (BOOTSTRAP, len(one)))
    found = [spearman(one[rows], other[rows]) for rows in drawn_again]
    low, high = np.nanpercentile(found, [2.5, 97.5])
    return float(low), float(high)


def auc(score: Floats, failed: npt.NDArray[np.bool_]) -> float:
    """Return the probability that a failed run's score is higher than an arriving run's."""
    lost = int(failed.sum())
    won = int((~failed).sum())
    return (
        float((ranks(score)[failed].sum() - lost * (lost + 1) / 2) / (lost * won))
        if lost and won
        else float("nan")
    )


@dataclass(frozen=True, eq=False)
class Campaign:
    """The measurements, and the outcomes of the runs.

    Args:
        families: (n,) family of each world.
        metrics: n tables of metrics.
        radius: (n,) radius of the robot, m.
        failed: For each controller, (n,) bool.
    """

    families: npt.NDArray[np.str_]
    metrics: Sequence[Mapping[str, float]]
    radius: Floats
    failed: Mapping[str, npt.NDArray[np.bool_]]

    def column(self, name: str) -> Floats:
        """Return a (n,) array of one metric; NaN where it is empty."""
        return np.array([table.get(name, np.nan) for table in self.metrics])

    @property
    def telling(self) -> list[str]:
        """Controllers that head for the target, and fail neither hardly ever nor nearly always."""
        low, high = OFTEN
        return [
            name
            for name, lost in self.failed.items()
            if low <= lost.mean() <= high and name not in LED_AWAY
        ]

    @property
    def share(self) -> Floats:
        """Share of those controllers that fail, (n,)."""
        found: Floats = np.mean([self.failed[name] for name in self.telling], axis=0)
        return found


def run_campaign(count: int, seed: int, names: Sequence[str]) -> Campaign:
    """Make worlds, measure them, and run the controllers."""
    worlds = [world for name in FAMILIES_AT_REST for world in worlds_of(name, count, seed)]
    families = np.repeat(FAMILIES_AT_REST, count)
    failed = {
        name: ~simulate_many(worlds, [name], motion="swept", steps=STEPS).reached for name in names
    }
    tables = [{**measure(world).as_dict(), **around(world)} for world in worlds]
    return Campaign(families, tables, np.array([world.robot_radius for world in worlds]), failed)


def correlations(campaign: Campaign) -> dict[str, dict[str, Any]]:
    """Return correlations by metric: with the share of failing controllers, and with each."""
    rng = np.random.default_rng(0)
    found = {}
    for metric in (*METRICS, *AROUND):
        values = campaign.column(metric)
        there = ~np.isnan(values)
        if there.sum() < len(values) // 2:
            continue
        each = {
            name: round(spearman(values[there], lost[there].astype(float)), 2)
            for name, lost in campaign.failed.items()
            if 0 < lost.sum() < len(lost)
        }
        found[metric] = {**_with_interval(values[there], campaign.share[there], rng), "each": each}
    return found


def _with_interval(one: Floats, other: Floats, rng: np.random.Generator) -> dict[str, float]:
    low, high = interval(one, other, rng)
    return {"all": round(spearman(one, other), 2), "low": round(low, 2), "high": round(high, 2)}


def fitted(
    campaign: Campaign, rows: npt.NDArray[np.bool_]
) -> tuple[dict[str, tuple[float, float]], float]:
    """Return scales and weights of the right signs, and the offset.

    They are fitted by least squares with projected gradient steps.
    """
    # Squash every metric to 0 to 1, with a scale near its median.
    scales = {}
    columns = []
    for name in CANDIDATES:
        raw = np.nan_to_num(campaign.column(name))
        plain = np.maximum(raw - 1.0, 0.0) if name == "detour" else raw
        if METRICS[name].unit == "m":
            plain = raw / campaign.radius
        scales[name] = float(f"{max(float(np.median(plain[plain > 0])), 0.01):.2g}")
        pairs = zip(raw.tolist(), campaign.radius.tolist(), strict=True)
        columns.append([squashed(name, value, scales[name], radius) for value, radius in pairs])
    # Fit the weights by projected gradient descent: a weight of the wrong sign becomes 0.
    x = np.array(columns).T[rows]
    share = campaign.share[rows]
    sign = np.array([METRICS[name].harder for name in CANDIDATES], float)
    weights = np.zeros(len(CANDIDATES))
    offset = 0.0
    for _ in range(20_000):
        total = x @ weights + offset
        slope = (0.5 + 0.5 * total / (1 + np.abs(total)) - share) / (1 + np.abs(total)) ** 2
        weights = weights - 2.0 * (x.T @ slope) / len(x)
        weights = np.where(weights * sign < 0.0, 0.0, weights)
        offset -= 2.0 * float(slope.mean())
    # Drop weights that hardly matter.
    kept = zip(CANDIDATES, weights.tolist(), strict=True)
    return {
        name: (scales[name], round(weight, 2)) for name, weight in kept if abs(weight) >= 0.05
    }, round(offset, 2)


def judged(campaign: Campaign, score: Floats, rows: npt.NDArray[np.bool_]) -> dict[str, float]:
    """Return how well a score separates failed runs from the others.

    It is the area under the curve, over all runs and by controller.
    """
    lost = {name: campaign.failed[name][rows] for name in campaign.telling}
    found = {
        "all": round(auc(np.tile(score[rows], len(lost)), np.concatenate([*lost.values()])), 3)
    }
    return found | {name: round(auc(score[rows], failed), 3) for name, failed in lost.items()}


def scored(campaign: Campaign, weights: Mapping[str, tuple[float, float]], offset: float) -> Floats:
    """Return a (n,) array: the model's value for each world; empty metrics count as 0."""
    rows = zip(campaign.metrics, campaign.radius.tolist(), strict=True)
    full = [(dict.fromkeys(weights, 0.0) | dict(table), radius) for table, radius in rows]
    return np.array([difficulty(table, radius, weights, offset) for table, radius in full])


def barn_worlds(folder: Path) -> Iterator[tuple[int, World, float]]:
    """Yield the number, world and share of failed runs of BARN's worlds for the DWA planner."""
    outcomes: dict[int, list[bool]] = {}
    for line in (folder / "res" / "dwa_out.txt").read_text().splitlines():
        number, success = line.split()[:2]
        outcomes.setdefault(int(number), []).append(success == "0")
    pose = re.compile(
        r"<model name='unit_cylinder_\d+'>\s*<static>1</static>\s*<pose frame=''>(\S+) (\S+) "
    )
    for number, lost in sorted(outcomes.items()):
        text = (folder / "jackal_helper" / "worlds" / "BARN" / f"world_{number}.world").read_text()
        # x from -4.65 m, y from -0.15 m; obstacles are one cell wide, 0.15 m.
        walls = np.zeros((92, 32), np.bool_)
        for x, y in pose.findall(text):
            ix = round((float(x) + 4.65) / 0.15 - 0.5)
            iy = round((float(y) + 0.15) / 0.15 - 0.5)
            if 0 <= ix < 32 and 0 <= iy < 92:
                walls[iy, ix] = True
        world = World(walls, Pose(2.4, 3.15, 1.57), Target(2.4, 13.15, 0.5), 0.15, 0.2)
        yield number, replace(world, certificate=decide(world).certificate), float(np.mean(lost))


def barn_table(folder: Path) -> dict[str, Any]:
    """Return the correlations of the metrics with the published share of failed runs."""
    rng = np.random.default_rng(0)
    found = list(barn_worlds(folder))
    tables = [{**measure(world).as_dict(), **around(world)} for _, world, _ in found]
    share = np.array([lost for _, _, lost in found])
    result: dict[str, Any] = {
        "worlds": len(found),
        "failed": round(float(share.mean()), 3),
        "metrics": {},
    }
    for metric in (*METRICS, *AROUND):
        values = np.array([table.get(metric, np.nan) for table in tables])
        there = ~np.isnan(values)
        if there.sum() > 10 and len(np.unique(values[there])) > 1:
            result["metrics"][metric] = _with_interval(values[there], share[there], rng)
    return result


def in_words(found: Mapping[str, Any], names: Sequence[str]) -> str:
    """Return the table of correlations in Markdown."""
    head = ["metric", "all, with its interval", *(f"`{name}`" for name in names)]
    lines = [f"| {' | '.join(head)} |", "| --- |" + " ---: |" * (1 + len(names))]
    for metric, row in sorted(found.items(), key=lambda item: -abs(item[1]["all"])):
        cells = [f"{row['each'][name]:+.2f}" if name in row["each"] else "" for name in names]
        interval_text = f"{row['all']:+.2f} [{row['low']:+.2f}, {row['high']:+.2f}]"
        lines.append(f"| `{metric}` | {interval_text} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--worlds", type=int, default=WORLDS, help=f"worlds of each family (default {WORLDS})"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the worlds (default 0)")
    parser.add_argument(
        "--barn", type=Path, help="folder with a copy of the BARN challenge's repository"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    given = parser.parse_args()
    campaign = run_campaign(
        given.worlds, given.seed, [name for name in controllers() if name not in SKIPPED]
    )
    result = report(campaign)
    # The BARN worlds are a data set of others, and take minutes to convert.
    result["barn"] = None if given.barn is None else barn_table(given.barn)
    if given.json:
        click.echo(json.dumps(result))
        return
    found = result.pop("correlations")
    click.echo(in_words(found, list(found["length"]["each"])))
    for key, value in result.items():
        click.echo(f"{key}: {value}")


def report(campaign: Campaign) -> dict[str, Any]:
    """Return all printed figures of a campaign."""
    every = np.ones(len(campaign.families), np.bool_)
    even = np.arange(len(every)) % 2 == 0
    weights, offset = fitted(campaign, every)
    return {
        "worlds": len(every),
        "failed": {name: round(float(lost.mean()), 2) for name, lost in campaign.failed.items()},
        "telling": campaign.telling,
        "correlations": correlations(campaign),
        "weights": weights,
        "offset": offset,
        "auc_held_out": judged(campaign, scored(campaign, *fitted(campaign, even)), ~even),
        "auc_of_the_model": judged(campaign, campaign.column("difficulty"), every),
    }


if __name__ == "__main__":
    main()
