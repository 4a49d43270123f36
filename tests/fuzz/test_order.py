"""What "smaller" means to the shrinker.

An earlier measure decides, whatever the later ones are.
"""

import numpy as np

from fuzz.simplicity import Case, simplicity
from sim.scenario import Scenario
from worldgen import Pose, Target, World


def case(side, solid, heading=0.0):
    """A square world with this many solid cells in its first rows."""
    walls = np.zeros((side, side), bool)
    walls.ravel()[:solid] = True
    place = (side - 0.5) / 10
    return Case(
        World(walls, Pose(0.65, place, heading), Target(place, place, 0.05)), Scenario("turn-right")
    )


def test_fewer_cells_weigh_more_than_fewer_solid_ones():
    assert simplicity(case(9, solid=20)) < simplicity(case(10, solid=1))


def test_fewer_solid_cells_weigh_more_than_a_heading_along_an_axis():
    assert simplicity(case(9, solid=3, heading=0.1)) < simplicity(case(9, solid=4))


def test_of_two_cases_that_differ_in_the_heading_alone_the_quarter_turn_is_simpler():
    assert simplicity(case(9, solid=3)) < simplicity(case(9, solid=3, heading=0.1))
