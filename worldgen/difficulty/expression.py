"""Wishes about metrics: ``detour > 3 and bottleneck < 1.2r``, read by a parser of our own, never run as code.

Grammar, loosest first: ``or``, ``and``, ``not``, comparisons (``<  <=  >  >=  ==  !=``, also chained), ``+ -``,
``* /``, signs, parentheses, names of metrics, numbers. A number may carry a unit: ``m``, ``s``, or ``r``, the robot's
radius.
"""

from __future__ import annotations

import difflib
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple, NoReturn

from worldgen.difficulty.metrics import METRICS
from worldgen.errors import InvalidParameter, Message

__all__ = ["Expression", "parse"]

UNITS: Final = ("m", "s", "r")
MOST_CHARACTERS: Final = 2000
MOST_NESTED: Final = 50
_EMPTY: Final = 2.0  # violation of a comparison with a metric that the world does not have: more than any other

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[A-Za-z_]\w*)?|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark><=|>=|==|!=|[<>+\-*/()])|(?P<end>\Z)|(?P<wrong>.))",
    re.DOTALL | re.ASCII,
)
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_HOLDS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip

Values = Mapping[str, float]


class _Number(NamedTuple):
    """A number or what is worked out of numbers: its value, nan if a metric is missing."""

    value: Callable[[Values, float], float]


class _Wish(NamedTuple):
    """A condition: how far a world is from it, 0 exactly where it holds; and its opposite."""

    violation: Callable[[Values, float], float]
    opposite: Callable[[], _Wish]


@dataclass(frozen=True)
class Expression:
    """A parsed wish.

    Args:
        text: As it was written.
        names: The metrics that it asks for.
    """

    text: str
    names: frozenset[str]
    _wish: _Wish

    def violation(self, metrics: Values, robot_radius: float) -> float:
        """How far a world is from it: 0 if it holds, else more the farther; a metric left out fulfils nothing."""
        return self._wish.violation(metrics, robot_radius)

    def holds(self, metrics: Values, robot_radius: float) -> bool:
        """Whether the wish is fulfilled."""
        return self.violation(metrics, robot_radius) == 0.0


def parse(text: str) -> Expression:
    """The wish that a text says.

    Raises:
        InvalidParameter: If it is none, with a mark under the place.
    """
    if len(text) > MOST_CHARACTERS:
        raise InvalidParameter(
            "too-large",
            "the wish has {characters} characters",
            "give at most {most}",
            characters=len(text),
            most=MOST_CHARACTERS,
        )
    parser = _Parser(text)
    found = parser.either(0)
    if parser.kind != "end":
        parser.fail(Message("wrong-form", "{came} is too much here", "join wishes with and, or", came=parser.shown))
    return Expression(text, frozenset(parser.names), parser.wish(found, 0))


class _Parser:
    """Recursive descent over the tokens; ``at`` is where the current one begins."""

    def __init__(self, text: str) -> None:
        self.text, self.names = text, set[str]()
        self._tokens = self._scan()
        self._depth = 0
        self._next()

    def _scan(self) -> Iterator[re.Match[str]]:
        place = 0
        while True:
            token = _TOKEN.match(self.text, place)
            if token is None:  # the last alternative but one takes any character
                raise InvalidParameter("wrong-form", "the wish cannot be read", "write it on one line")
            yield token
            place = token.end()

    def _next(self) -> None:
        token = next(self._tokens)
        self.kind = "number" if token["number"] is not None else str(token.lastgroup)
        self.at = token.start(self.kind)
        self.word = token[self.kind]
        self.unit = token["unit"]
        if self.kind == "wrong":
            self.fail(Message("wrong-form", "{word!r} has no meaning here", word=self.word))

    @property
    def shown(self) -> str:
        """The current token for messages."""
        return "the end" if self.kind == "end" else repr(self.word)

    def fail(self, message: Message, at: int | None = None) -> NoReturn:
        """Raises the error with a mark under the place."""
        place = self.at if at is None else at
        line = "".join(c if c.isprintable() else " " for c in self.text)
        first = max(0, place - 60)
        piece = line[first : first + 100]
        marked = message.before("\n  {line}\n  {mark:>{column}}", line=piece, mark="^", column=place - first + 1)
        raise InvalidParameter.of(marked)

    def _takes(self, *words: str) -> str | None:
        if self.kind in ("mark", "word") and self.word in words:
            word = self.word
            self._next()
            return word
        return None

    def wish(self, part: _Number | _Wish, at: int) -> _Wish:
        """Refuses a number where a condition belongs."""
        if isinstance(part, _Number):
            self.fail(Message("wrong-form", "this is a number, not a condition", "compare it, as in detour > 3"), at)
        return part

    def number(self, part: _Number | _Wish, at: int) -> _Number:
        """Refuses a condition where a number belongs."""
        if isinstance(part, _Wish):
            self.fail(
                Message("wrong-form", "this is a condition, not a number; it cannot be compared or reckoned with"), at
            )
        return part

    def either(self, depth: int) -> _Number | _Wish:
        """``a or b``."""
        if depth > MOST_NESTED:
            self.fail(
                Message(
                    "nested-too-deep",
                    "nested deeper than {most} levels",
                    "take parentheses and signs away",
                    most=MOST_NESTED,
                )
            )
        at, found = self.at, self._both(depth)
        while self._takes("or"):
            one, second = self.wish(found, at), self.at
            found = _or(one, self.wish(self._both(depth), second))
        return found

    def _both(self, depth: int) -> _Number | _Wish:
        at, found = self.at, self._denial(depth)
        while self._takes("and"):
            one, second = self.wish(found, at), self.at
            found = _and(one, self.wish(self._denial(depth), second))
        return found

    def _denial(self, depth: int) -> _Number | _Wish:
        denied = 0
        while self._takes("not"):
            denied += 1
        at, found = self.at, self._comparison(depth)
        if denied:
            found = self.wish(found, at)
        return found.opposite() if denied % 2 and isinstance(found, _Wish) else found

    def _comparison(self, depth: int) -> _Number | _Wish:
        at, found = self.at, self._sum(depth)
        parts: list[_Wish] = []
        left = found
        while (mark := self._takes(*_OPPOSITE)) is not None:
            one, second = self.number(left, at), self.at
            left = self._sum(depth)
            parts.append(_compare(mark, one, self.number(left, second)))
            at = second
        for part in parts[1:]:
            parts[0] = _and(parts[0], part)
        return parts[0] if parts else found

    def _sum(self, depth: int) -> _Number | _Wish:
        at, found = self.at, self._product(depth)
        while (mark := self._takes("+", "-")) is not None:
            one, second = self.number(found, at), self.at
            found = _reckon(mark, one, self.number(self._product(depth), second))
        return found

    def _product(self, depth: int) -> _Number | _Wish:
        at, found = self.at, self._signed(depth)
        while (mark := self._takes("*", "/")) is not None:
            one, second = self.number(found, at), self.at
            found = _reckon(mark, one, self.number(self._signed(depth), second))
        return found

    def _signed(self, depth: int) -> _Number | _Wish:
        minus, signs = False, 0
        while (mark := self._takes("+", "-")) is not None:
            minus, signs = minus != (mark == "-"), signs + 1
        at, found = self.at, self._atom(depth)
        if not signs:
            return found
        value = self.number(found, at).value
        return _Number(lambda metrics, radius: -value(metrics, radius)) if minus else _Number(value)

    def _atom(self, depth: int) -> _Number | _Wish:
        if self._takes("("):
            found = self.either(depth + 1)
            if not self._takes(")"):
                self.fail(Message("wrong-form", "{came} where a closing parenthesis belongs", came=self.shown))
            return found
        if self.kind == "number":
            return self._constant()
        if self.kind == "word" and self.word not in ("and", "or", "not"):
            return self._metric()
        self.fail(Message("wrong-form", "{came} where a metric or a number belongs", came=self.shown))

    def _constant(self) -> _Number:
        value, unit = float(self.word), self.unit
        if not math.isfinite(value):
            self.fail(Message("too-large", "this number is beyond the range of a float64", "give a smaller one"))
        if unit is not None and unit not in UNITS:
            self.fail(
                Message("unknown-name", "{name!r} is no unit", "write m, s, or r for the robot's radius", name=unit),
                self.at + len(self.word),
            )
        self._next()
        return _Number(lambda _, radius: value * radius if unit == "r" else value)

    def _metric(self) -> _Number:
        name = self.word
        if name not in METRICS:
            near = "".join(difflib.get_close_matches(name, METRICS, n=1))
            message = Message(
                "unknown-name",
                "no metric is called {name!r}",
                "did you mean {near}? known: {known!l}" if near else "known: {known!l}",
                name=name[:40],
                near=near,
                known=list(METRICS),
            )
            self.fail(message)
        self.names.add(name)
        self._next()
        return _Number(lambda metrics, _: metrics.get(name, math.nan))


def _reckon(mark: str, one: _Number, other: _Number) -> _Number:
    def value(metrics: Values, radius: float) -> float:
        a, b = one.value(metrics, radius), other.value(metrics, radius)
        if mark == "/":
            return a / b if b else math.nan
        return a + b if mark == "+" else a - b if mark == "-" else a * b

    return _Number(value)


def _compare(mark: str, one: _Number, other: _Number) -> _Wish:
    def violation(metrics: Values, radius: float) -> float:
        a, b = one.value(metrics, radius), other.value(metrics, radius)
        if not (math.isfinite(a) and math.isfinite(b)):
            return _EMPTY
        if _HOLDS[mark](a, b):
            return 0.0
        size = abs(a) + abs(b)
        return max(abs(a - b) / size if 0.0 < size < math.inf else 0.0, 1e-9)  # 1e-9: equal, and should not be

    return _Wish(violation, lambda: _compare(_OPPOSITE[mark], one, other))


def _and(one: _Wish, other: _Wish) -> _Wish:
    return _Wish(
        lambda metrics, radius: one.violation(metrics, radius) + other.violation(metrics, radius),
        lambda: _or(one.opposite(), other.opposite()),
    )


def _or(one: _Wish, other: _Wish) -> _Wish:
    return _Wish(
        lambda metrics, radius: min(one.violation(metrics, radius), other.violation(metrics, radius)),
        lambda: _and(one.opposite(), other.opposite()),
    )
