"""Draw a learning curve as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape

from sim.controllers.learning import Episodes
from worldgen.render.marks import hue

# Sizes in px.
_WIDTH = 640
_HEIGHT = 320
_LEFT = 56
_RIGHT = 76
_TOP = 44
_BOTTOM = 48

_PAPER = hue("paper")
_EDGE = hue("edge")
_STEPS = hue("burn")
_REACHED = hue("target")


def curve_svg(curve: Sequence[Episodes], title: str) -> str:
    """Return a chart of worlds reached, and of steps, over episodes.

    Args:
        curve: The points, in order.
        title: Heading.
    """
    last = max(curve[-1].episodes, 1)
    most_steps = max([1, *(point.steps for point in curve)])
    worlds = max(curve[0].worlds, 1)

    def x(point: Episodes) -> float:
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * point.episodes / last

    def y(share: float) -> float:
        return _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * share

    def line(shares: Sequence[float], colour: str) -> str:
        points = [(x(point), y(share)) for point, share in zip(curve, shares, strict=True)]
        path = " ".join(f"{at:.1f},{up:.1f}" for at, up in points)
        dots = "".join(
            f'<circle cx="{at:.1f}" cy="{up:.1f}" r="3" fill="{colour}"/>' for at, up in points
        )
        return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>{dots}'

    reached = [point.reached / worlds for point in curve]
    steps = [point.steps / most_steps for point in curve]
    right = _WIDTH - _RIGHT
    low = _HEIGHT - _BOTTOM
    parts = [
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="{hue("paper")}"/>',
        f'<text x="{_LEFT}" y="24" font-weight="600">{escape(title)}</text>',
        f'<path d="M{_LEFT} {_TOP}V{low}H{right}V{_TOP}" fill="none" stroke="{hue("edge")}"/>',
        line(steps, _STEPS),
        line(reached, _REACHED),
        _label(_LEFT - 8, y(1.0) + 4, str(worlds), "end", _REACHED),
        _label(_LEFT - 8, y(0.0) + 4, "0", "end", _REACHED),
        _label(_LEFT, _TOP - 8, "worlds reached", "start", _REACHED),
        _label(right + 8, y(1.0) + 4, f"{most_steps:,}", "start", _STEPS),
        _label(right + 8, y(0.0) + 4, "0", "start", _STEPS),
        _label(right, _TOP - 8, "steps, all worlds", "end", _STEPS),
        _label(_LEFT, low + 20, "0", "middle", hue("ink")),
        _label(right, low + 20, str(last), "middle", hue("ink")),
        _label((_LEFT + right) / 2, low + 36, "episodes of training", "middle", hue("ink")),
    ]
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
        f'width="{_WIDTH}" height="{_HEIGHT}" role="img" font-family="system-ui,sans-serif" '
        f'font-size="13">\n<title>{escape(title)}: learning curve</title>\n{body}\n</svg>\n'
    )


def _label(x: float, y: float, words: str, anchor: str, colour: str) -> str:
    return (
        f'<text x="{x:g}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(words)}</text>'
    )
