"""Colours of the pictures: one hue per meaning.

Source: Masataka Okabe, Kei Ito, "Color Universal Design: How to make figures and presentations that
    are
friendly to colorblind people", 2008. Neutrals are greys, so no meaning hangs on red against green.
"""

from __future__ import annotations

__all__ = [
    "APPROACH",
    "FIRE",
    "FLOOR",
    "FULL_TINT",
    "GREY",
    "INK",
    "LOOP",
    "LOOP_HEAD",
    "PAPER",
    "PIERCED",
    "PIERCED_GROUND",
    "START",
    "SWEPT",
    "TARGET",
    "TUNNEL",
    "WALL",
    "mix",
    "rgb",
]

# Okabe and Ito
TARGET = "#0072B2"  # blue: the target, and its signal as a tint
START = "#009E73"  # bluish green: the robot's start, and the path that it could take
LOOP = "#D55E00"  # vermillion: what it does instead
FIRE = "#E69F00"  # orange: cells that burn at some time
TUNNEL = "#CC79A7"  # reddish purple: where the run broke the world's rules, and cuts
PIERCED = "#C00018"  # red, with stripes and a frame: walls that the robot went into
# neutrals
PAPER = "#FFFFFF"
FLOOR = "#F9FBFD"  # where the signal is weakest
WALL = "#343A43"
INK = "#1B1F24"
GREY = "#5F6773"
APPROACH = "#E8A37C"  # a tint of LOOP: the same robot, earlier


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of ``#RRGGBB``."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def mix(first: str, second: str, share: float) -> str:
    """Return the colour with ``share`` (0 to 1) of the second in it."""
    parts = (round(a + (b - a) * share) for a, b in zip(rgb(first), rgb(second), strict=True))
    return "#" + "".join(f"{part:02X}" for part in parts)


LOOP_HEAD = mix(LOOP, "#000000", 0.4)  # arrow heads, to stand out from the line
SWEPT = mix(PAPER, LOOP, 0.35)  # the floor that the robot covers in its loop
PIERCED_GROUND = mix(mix(WALL, FLOOR, 0.6), PIERCED, 0.25)  # light below the stripes, for every eye
FULL_TINT = mix(FLOOR, TARGET, 0.55)  # the floor where the signal is strongest
