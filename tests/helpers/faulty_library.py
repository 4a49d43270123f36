"""A shared library of faulty controllers."""

import subprocess
from pathlib import Path

from build_tools.cores import compiler
from sim.controllers.shared.object_file import include_folder

SOURCE = Path(__file__).parents[1] / "data" / "controllers" / "faulty.c"


def compile_faulty(folder):
    """Compile the library into a folder; return its whole path."""
    made = folder / "faulty.so"
    words = ["-std=c17", "-O1", "-shared", "-fPIC", f"-I{include_folder()}"]
    subprocess.run([*compiler(), *words, str(SOURCE), "-o", str(made)], check=True)
    return made
