"""Stand in for the compiled core: Python imports this file only if the core is missing."""

from pathlib import Path

from worldgen.support.missing_core import refuse

refuse("worldgen", str(Path(__file__).parents[1]))
