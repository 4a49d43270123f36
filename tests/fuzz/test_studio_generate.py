"""What the studio shows for a family: a preview, and only parameters that have an effect."""

import pytest

from fuzz.studio.catalogue import IDLE, catalogue
from tests.helpers.raising import raises
from tests.helpers.studio import page_of, studio_of
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES

HIDDEN = [
    (family, name, idle.by, value)
    for family, parameters in IDLE.items()
    for name, idle in parameters.items()
    for value in idle.values
]


@pytest.mark.parametrize(("family", "name", "by", "value"), HIDDEN)
def test_a_parameter_that_the_page_hides_would_be_refused(family, name, by, value):
    known = {parameter.name: parameter for parameter in FAMILIES.get(family).parameters}
    default = known[name].default
    other = not default if isinstance(default, bool) else type(default)(1)
    with raises(InvalidParameter, "no-effect"):
        generate(family, 1, **{by: value, name: other})


def test_each_family_says_which_parameters_others_decide_about():
    families = {one.name: one.parameters for one in catalogue([], print).families}
    maze = {one.name: one.idle for one in families["maze"]}
    assert maze["newest"].by == "algorithm" and "growing-tree" not in maze["newest"].values
    assert maze["mask"] is None


@pytest.mark.gate
def test_every_family_has_a_preview(tmp_path):
    with studio_of(tmp_path) as gate, page_of(gate) as page:
        for family in FAMILIES.names():
            assert page.ask("preview", family=family)["answer"]["width"] <= 60
        assert page.ask("preview", family="./mine.py:mine")["error"]["code"] == "not-registered"
