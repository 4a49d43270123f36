"""Print how pogema-toolbox reads MovingAI map files: rows of # and ., by file."""

import importlib.abc
import importlib.machinery
import json
import sys
import types
from pathlib import Path


class Absent(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Empty modules for the toolbox's other imports.

    It is installed without its dependencies.
    """

    def find_spec(self, name, path=None, target=None):
        if name.startswith("pogema_toolbox"):
            return None
        return importlib.machinery.ModuleSpec(name, self, is_package=True)

    def create_module(self, spec):
        return type("Empty", (types.ModuleType,), {"__getattr__": lambda self, name: object})(
            spec.name
        )

    def exec_module(self, module):
        module.__path__ = []


sys.meta_path.append(Absent())
from pogema_toolbox.moving_ai_ingestion import map_to_grid  # noqa: E402

grids = {}
for name in sys.argv[1:]:
    with Path(name).open("rb") as stream:
        grids[name] = map_to_grid(stream, remove_border=False).split("\n")
print(json.dumps(grids))
