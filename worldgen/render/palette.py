"""Colours of the pictures: one hue per meaning.

Source: Masataka Okabe, Kei Ito, "Color Universal Design: How to make figures and presentations that
    are friendly to colorblind people", 2008. Neutrals are greys, so no distinction depends on red
    against green.
"""

from __future__ import annotations

# Okabe and Ito's colours.
# Blue: the target, and its signal as a tint.
TARGET = "#0072B2"
# Bluish green: the robot's start, and the path that it could take.
START = "#009E73"
# Vermillion: the path that it takes instead.
LOOP = "#D55E00"
# Orange: cells that burn at some time.
FIRE = "#E69F00"
# Sky blue: anything that moves the robot besides its wheels.
PUSH = "#56B4E9"
# Yellow: cells of a coverage task that the robot missed.
MISSED = "#E3C800"
# A lighter yellow, with a dark edge: cells that the text next to the picture names.
NAMED = "#F0E442"
# Violet, as in the player: the robot's memory.
MEMORY = "#6A3FB5"
# Reddish purple: where the run broke the world's rules, and cuts.
TUNNEL = "#CC79A7"
# Red, with stripes and a frame: walls that the robot entered.
PIERCED = "#C00018"
# Neutrals.
PAPER = "#FFFFFF"
# Where the signal is weakest.
FLOOR = "#F9FBFD"
WALL = "#343A43"
INK = "#1B1F24"
GREY = "#5F6773"
# A tint of LOOP, for earlier positions of the same robot.
APPROACH = "#E8A37C"


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of ``#RRGGBB``."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def mix(first: str, second: str, share: float) -> str:
    """Mix ``share`` (0 to 1) of the second colour into the first."""
    parts = (round(a + (b - a) * share) for a, b in zip(rgb(first), rgb(second), strict=True))
    return "#" + "".join(f"{part:02X}" for part in parts)


# Arrow heads, which must stand out from the line.
LOOP_HEAD = mix(LOOP, "#000000", 0.4)
PUSH_HEAD = mix(PUSH, "#000000", 0.45)
# The floor that the robot covers in its loop.
SWEPT = mix(PAPER, LOOP, 0.35)
# A light colour below the stripes, for readers who cannot tell the hues apart.
PIERCED_GROUND = mix(mix(WALL, FLOOR, 0.6), PIERCED, 0.25)
# The floor where the signal is strongest.
FULL_TINT = mix(FLOOR, TARGET, 0.55)
