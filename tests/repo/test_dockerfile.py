"""The image can't be built in a test, but everything that its file names must exist."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "Dockerfile").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_extras_of_the_image_exist():
    extras = [name for found in re.findall(r"\[([a-z,]+)\]", TEXT) for name in found.split(",")]
    assert extras and set(extras) <= PROJECT["optional-dependencies"].keys()


def test_its_python_is_one_that_the_package_supports():
    [image] = re.findall(r"^FROM python:([\d.]+)-slim$", TEXT, re.MULTILINE)
    assert f"Programming Language :: Python :: {image}" in PROJECT["classifiers"]


def test_it_runs_as_an_ordinary_user():
    assert re.findall(r"^USER (\w+)$", TEXT, re.MULTILINE)[-1] == "worldgen"
