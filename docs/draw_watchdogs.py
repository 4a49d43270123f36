"""Draws the picture of ``docs/howto/watchdog.md``: what progress checkers miss and interrupt.

``python docs/draw_watchdogs.py`` writes it to ``docs/pictures``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from fuzz.failure import Failure
from fuzz.watchdogs import WatchdogResult, drives_of, judge

ROOT = Path(__file__).parent.parent
CONTROLLERS = ("bug2", "wall-left", "vfh", "tangent-bug", "potential-field")
RADII = (0.1, 0.2, 0.5, 1.0, 2.0, 4.0)
WORLDS = 60
WIDTH, HEIGHT = 640, 320
LEFT, RIGHT, TOP, BOTTOM = 60, 200, 24, 56
INK, MISSED, INTERRUPTED = "#1b1f24", "#cf222e", "#0969da"


def chart(results: Sequence[WatchdogResult]) -> Image.Image:
    """Return the shares of missed loops and interrupted arrivals over the radii."""
    scale = 2
    image = Image.new("RGB", (WIDTH * scale, HEIGHT * scale), "white")
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(13 * scale)

    def at(number: int, share: float) -> tuple[float, float]:
        x = LEFT + (WIDTH - LEFT - RIGHT) * number / (len(RADII) - 1)
        return scale * x, scale * (HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share)

    # Axes with their numbers.
    for percent in (0, 25, 50, 75, 100):
        x, y = at(0, percent / 100)
        draw.line([(x, y), at(len(RADII) - 1, percent / 100)], fill="#d0d7de", width=scale)
        draw.text((x - 8 * scale, y), f"{percent} %", INK, font, anchor="rm")
    for number, radius in enumerate(RADII):
        x, y = at(number, 0.0)
        draw.text((x, y + 12 * scale), f"{radius:g} m", INK, font, anchor="mm")
    middle = scale * (LEFT + WIDTH - RIGHT) / 2
    draw.text((middle, scale * (HEIGHT - 16)), "required_movement_radius", INK, font, anchor="mm")
    # Both shares, each named at its end.
    missed = [len(one.missed) / one.loops for one in results]
    interrupted = [len(one.interrupted) / one.arrivals for one in results]
    for shares, colour, name in (
        (missed, MISSED, "endless loops missed"),
        (interrupted, INTERRUPTED, "arrivals interrupted"),
    ):
        points = [at(number, share) for number, share in enumerate(shares)]
        draw.line(points, fill=colour, width=3 * scale, joint="curve")
        for x, y in points:
            draw.ellipse([x - 4 * scale, y - 4 * scale, x + 4 * scale, y + 4 * scale], fill=colour)
        x, y = points[-1]
        draw.text((x + 10 * scale, y), name, colour, font, anchor="lm")
    return image.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)


def main() -> None:
    """Run the checker over the shipped failures of some controllers, and draw what it does."""
    files = [
        file
        for name in CONTROLLERS
        for file in sorted((ROOT / "corpora" / "failures" / name).rglob("*.grid"))
    ]
    failures = ((str(file.relative_to(ROOT)), Failure.read(file)) for file in files)
    drives, _ = drives_of(failures, WORLDS)
    names = [f"simple-progress+required_movement_radius={radius:g}" for radius in RADII]
    chart(judge(names, drives)).save(ROOT / "docs" / "pictures" / "watchdogs.png", optimize=True)


if __name__ == "__main__":
    main()
