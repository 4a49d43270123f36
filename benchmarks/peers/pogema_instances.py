"""Print the instances of POGEMA's Puzzles benchmark, as pogema places the agents.

``PYTHON benchmarks/peers/pogema_instances.py MAPS.yaml`` prints one JSON list. It runs in a
separate environment with ``pogema==1.4.0`` and PyYAML, because pogema pins old versions of NumPy
and pydantic. Positions are (row, column), and row 0 is the top one.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

AGENTS = (2, 3, 4)
SEEDS = range(10)


def main() -> None:
    """Place the agents of each map, number of agents and seed."""
    pogema: Any = importlib.import_module("pogema")
    grid: Any = importlib.import_module("pogema.grid")
    yaml: Any = importlib.import_module("yaml")
    instances = []
    for name, rows in yaml.safe_load(Path(sys.argv[1]).read_text()).items():
        for agents in AGENTS:
            for seed in SEEDS:
                # Let POGEMA place the agents, so that both sides solve its own instances.
                config = pogema.GridConfig(map=rows, num_agents=agents, seed=seed)
                placed = grid.Grid(config, add_artificial_border=False)
                instances.append(
                    {
                        "map": name,
                        "seed": seed,
                        "rows": rows.split(),
                        "starts": [[int(k) for k in place] for place in placed.starts_xy],
                        "targets": [[int(k) for k in place] for place in placed.finishes_xy],
                    }
                )
    json.dump(instances, sys.stdout)


if __name__ == "__main__":
    main()
