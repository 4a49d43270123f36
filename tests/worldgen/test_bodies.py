"""Bodies, drives and goals: what a robot can be, and how a file holds it."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidWorld
from worldgen.files.grid import dumps, loads
from worldgen.lattice import UNIT, footprint_on_lattice
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, check_certificate, decide
from worldgen.robot import Drive, Pose, Robot, Target, convex_footprint
from worldgen.world import Cut, Witness, World

RECTANGLE = ((0.45, -0.31), (0.45, 0.31), (-0.45, 0.31), (-0.45, -0.31))
WALLS = np.zeros((40, 60), bool)


def a_world(**parts):
    robot = {"start": Pose(1.0, 1.0), "target": Target(4.0, 2.0, 0.05)} | parts
    return World(WALLS, robots=[Robot(**robot)])


def test_a_footprint_may_be_listed_either_way_around_and_with_corners_on_its_sides():
    clockwise = [RECTANGLE[0], *reversed(RECTANGLE[1:])]
    dense = [(0.45, -0.31), (0.45, 0.0), (0.45, 0.31), (-0.45, 0.31), (-0.45, -0.31), (0.1, -0.31)]
    for corners in (RECTANGLE, clockwise, dense):
        assert convex_footprint(corners) == RECTANGLE


BAD = {
    "two corners": [(0, 0), (1, 1)],
    "17 corners": [(math.cos(k), math.sin(k)) for k in range(17)],
    "no area": [(0, 0), (1, 1), (2, 2)],
    "a notch": [(0, 0), (2, 0), (1, 0.2), (1, 2)],
    "crossing sides": [(0, 0), (1, 1), (1, 0), (0, 1)],
    "a star": [(math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k)) for k in range(5)],
    "a word": [(0, 0), (1, 0), ("a", 1)],
    "three numbers": [(0, 0), (1, 0), (1, 1, 1)],
}


@pytest.mark.parametrize("name", BAD)
def test_a_footprint_that_is_not_a_convex_polygon_is_refused(name):
    with raises(InvalidWorld, "wrong-footprint"):
        Robot(Pose(0, 0), Target(1, 1, 0.1), footprint=BAD[name])


def test_the_radii_of_a_footprint_are_those_of_the_discs_about_its_axle():
    centred = Robot(Pose(0, 0), Target(1, 1, 0.1), footprint=RECTANGLE)
    assert math.hypot(0.45, 0.31) < centred.radius < math.hypot(0.45, 0.31) + 1e-12
    assert 0.31 - 1e-12 < centred.inner_radius < 0.31
    ahead = replace(centred, footprint=[(x + 0.5, y) for x, y in RECTANGLE])
    assert ahead.inner_radius == 0.0


def test_the_body_on_the_lattice_is_within_a_unit_of_the_footprint():
    draw = random.Random(1)
    for _ in range(200):
        count = draw.randint(3, 16)
        turns = sorted(draw.uniform(0, 2 * math.pi) for _ in range(count))
        size = draw.uniform(0.02, 3.0)
        corners = convex_footprint([(size * math.cos(t), size * math.sin(t)) for t in turns])
        body = footprint_on_lattice(corners, 0.1) / UNIT * 0.1
        for corner in body:
            assert min(math.dist(corner, own) for own in corners) <= 0.1 / UNIT * 0.7072
        sides = np.roll(body, -1, axis=0) - body
        after = np.roll(sides, -1, axis=0)
        assert (sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0] > 0).all()


def test_a_footprint_thinner_than_the_lattice_is_refused():
    with raises(InvalidWorld, "wrong-footprint"):
        footprint_on_lattice(((0.0, 0.0), (1e-6, 0.0), (1e-6, 1e-6)), 0.1)


FAULTS = {
    "a footprint larger than 256 cells": {"footprint": [(0, 0), (30, 0), (0, 30)]},
    "an unknown arrival": {"target": Target(4.0, 2.0, 0.05, arrival="soon")},
    "an unknown contact": {"target": Target(4.0, 2.0, 0.05, contact="bounce")},
    "a negative tolerance": {"target": Target(4.0, 2.0, 0.05, 0.0, -0.1)},
    "a goal's heading that is not a number": {"target": Target(4.0, 2.0, 0.05, math.nan)},
    "reverse without a turning radius": {"drive": Drive(reverse=True)},
    "a negative turning radius": {"drive": Drive(-0.5)},
    "a car that hardly steers": {"drive": Drive(0.5, steering_rate=1e-300)},
    "a car that slides": {"drive": Drive(0.5), "target": Target(4.0, 2.0, 0.05, contact="slide")},
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_robot_that_cannot_be_is_refused(name):
    with pytest.raises(InvalidWorld):
        a_world(**FAULTS[name])


KINDS = {
    "a footprint": {"footprint": RECTANGLE},
    "a car": {"drive": Drive(0.5, reverse=True, steering_rate=2.0)},
    "a heading": {"target": Target(4.0, 2.0, 0.05, heading=1.5, heading_tolerance=0.1)},
    "an arrival": {"target": Target(4.0, 2.0, 0.05, arrival="stop", arrival_speed=0.1)},
    "a contact": {"target": Target(4.0, 2.0, 0.05, contact="fail")},
    "slide by name": {"target": Target(4.0, 2.0, 0.05, contact="slide")},
}


@pytest.mark.parametrize("name", KINDS)
def test_a_file_holds_a_robot_of_each_kind(name):
    world = a_world(**KINDS[name])
    data = dumps(world)
    assert data.startswith(b"%worldgen-grid 2\n")
    assert loads(data) == world
    assert world.digest != a_world().digest


def test_a_plain_robot_keeps_version_1():
    assert dumps(a_world()).startswith(b"%worldgen-grid 1\n")


def test_a_file_holds_the_certificates_of_a_footprint():
    world = a_world(footprint=RECTANGLE)
    path = Witness([0.0, 1.0, 1.0], [1.0, 4.0, 4.0], [1.0, 2.0, 2.0], 0.05, [0.0, 0.0, 1.0])
    cut = Cut(np.empty((0, 2)), 0.0, boxes=[[0, 65535, 64, 1024, 2048, 2560]])
    for proof in (path, cut, Cut([[3, 4]], 0.2)):
        proved = replace(world, certificate=proof)
        assert loads(dumps(proved)) == proved


def test_poses_do_not_cut_a_disc():
    cut = Cut(np.empty((0, 2)), 0.0, boxes=[[0, 65535, 64, 1024, 2048, 2560]])
    with raises(InvalidWorld, "wrong-certificate"):
        replace(a_world(), certificate=cut)


CORNERS = "[[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]]"
FILE_FAULTS = {
    "both bodies": ("footprint =", "radius = 0.2\nfootprint =", "conflict"),
    "no body": ("footprint", "# footprint", "missing-key"),
    "a footprint of two": (CORNERS, "[[0.2, 0.1], [0.3, 0.1]]", "wrong-footprint"),
    "no footprint in it": (CORNERS, "[]", "wrong-footprint"),
    "half a corner": ("[0.2, 0.1],", "[0.2],", "wrong-type"),
    "an unknown drive": ("arrival", 'drive = "tank"\narrival', "unknown-name"),
    "a car without its radius": ("arrival", 'drive = "car"\narrival', "missing-key"),
    "a radius without a car": ("arrival", "turning_radius = 1.0\narrival", "conflict"),
    "reverse as a word": ("arrival", 'reverse = "yes"\narrival', "wrong-type"),
    "an unknown arrival": ('"stop"', '"soon"', "unknown-name"),
    "a negative tolerance": ("heading_tolerance = 0.1", "heading_tolerance = -0.1", "below-minimum"),
    "any heading": ("heading_tolerance = 0.1", "heading_tolerance = 3.2", "above-maximum"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILE_FAULTS)
def test_a_fault_in_a_robot_of_a_file_is_one_message_with_its_line(name):
    good = dumps(
        a_world(
            footprint=((0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1)),
            target=Target(4.0, 2.0, 0.05, 1.5, 0.1, arrival="stop"),
        )
    ).decode()
    old, new, code = FILE_FAULTS[name]
    assert old in good
    with raises(FormatError, code) as caught:
        loads(good.replace(old, new, 1).encode())
    assert 4 <= caught.value.line <= 12


def test_a_body_is_decided_by_the_discs_around_it_and_in_it():
    walls = np.zeros((40, 60), bool)
    walls[:, 30] = True
    walls[10:25, 30] = False
    # A gap of 1.5 m; the body is 0.62 m wide and 1.09 m across.
    wide = World(walls, robots=[Robot(Pose(1, 2), Target(5, 2, 0.1), footprint=RECTANGLE)])
    proof = decide(wide)
    assert proof.result == REACHABLE
    assert check_certificate(replace(wide, certificate=proof.certificate)).valid
    walls[15:25, 30] = True
    narrow = replace(wide, walls=walls)
    proof = decide(narrow)
    assert proof.result == BLOCKED
    assert check_certificate(replace(narrow, certificate=proof.certificate)).valid


def test_a_cut_that_only_stops_the_outer_disc_says_nothing_about_the_body():
    walls = np.zeros((40, 60), bool)
    walls[:, 30] = True
    walls[10:18, 30] = False
    # A gap of 0.8 m, through which the body fits lengthwise.
    world = World(walls, robots=[Robot(Pose(1, 2), Target(5, 2, 0.1), footprint=RECTANGLE)])
    around = decide(world, radius=world.robot_radius)
    assert around.result == BLOCKED
    assert not check_certificate(replace(world, certificate=around.certificate)).valid


def test_a_car_is_not_said_to_arrive_on_the_path_of_a_disc():
    world = a_world(drive=Drive(1.0))
    path = decide(a_world()).certificate
    assert decide(world).result in (REACHABLE, UNDECIDED)
    assert not check_certificate(replace(world, certificate=path)).valid
