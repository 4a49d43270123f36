"""Declared options: keyword-only parameters of a function, or fields of a dataclass.

The type follows from the default. Families and formats declare their options as functions; the
robot, the thesis's simulator and campaigns as dataclasses. Command line, JSON and the studio's
forms come from the same :class:`Parameter` objects.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import inspect
import math
import re
import sys
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.parameters.bounds import Bounds, check_choice
from worldgen.parameters.known_names import unknown_name

# Files hold no larger integer.
_INT64 = 2**63
_PLAIN = (bool, int, float, str)
_KINDS = {int: "whole number", float: "number", str: "word", tuple: "list of numbers"}
_LIST_EXAMPLE = "0.25:0.5"

# ``./a+b/mine.py:Robot+noise`` has one option at its end; a ``+`` in a folder's name does not begin
# one.
_OPTION = r"\+[A-Za-z][A-Za-z0-9_-]*(?:=[^+/\\]*)?"
_WRITTEN = re.compile(rf"(?P<name>.+?)(?P<options>(?:{_OPTION})*)", re.DOTALL)
# After a registered name, which has no slash, a value may contain one: ``tiled+layer=walls/low``.
_REGISTERED = re.compile(
    r"(?P<name>[\w-]+)(?P<options>(?:\+[A-Za-z][A-Za-z0-9_-]*(?:=[^+]*)?)*)", re.DOTALL
)
# After a class in a file or module, too: ``./mine.py:Robot+learned=taught/today.json``.
_CLASS_IN_FILE = re.compile(
    r"(?P<name>(?:.+\.py|[\w.]+):[A-Za-z_]\w*)(?P<options>(?:\+[A-Za-z][A-Za-z0-9_-]*(?:=[^+]*)?)*)",
    re.DOTALL,
)
_SWITCH = {
    "on": True,
    "true": True,
    "yes": True,
    "1": True,
    "off": False,
    "false": False,
    "no": False,
    "0": False,
}


@dataclass(frozen=True)
class Group:
    """The heading under which a form shows an option.

    ``slip: Annotated[float, Bounds(0, 1), Group("Forces")]``.
    """

    heading: str


@dataclass(frozen=True)
class Written:
    """The spelling of an option on the command line, if it isn't just its name.

    Args:
        flag: Flag such as ``--family`` for ``families``; empty for the name with dashes.
        metavar: Placeholder of the value in help; empty for its type.
        path: ``file`` or ``folder`` if the value names one.
    """

    flag: str = ""
    metavar: str = ""
    path: str = ""


@dataclass(frozen=True)
class Parameter:
    """A declared option: a parameter of a family or a format, or a field of an options dataclass.

    Args:
        name: Name in Python; with dashes on the command line.
        default: Default value, which sets the type: bool, int, float or str; for a field also a
            tuple of floats or words, or None.
        choices: Allowed words, from a ``Literal`` annotation; empty if there are none.
        help: Its entry in the docstring's ``Args``, on one line.
        bounds: Limits of a number, from ``Annotated``; None if only the function knows them.
        group: Heading in a form, from ``Annotated``; empty if it has none.
        written: Spelling on the command line, from ``Annotated``.
        optional: The type of a value other than None; None if the default sets the type.
        item: The type of a tuple's items.
    """

    name: str
    default: Any
    choices: tuple[str, ...] = ()
    help: str = ""
    bounds: Bounds | None = None
    group: str = ""
    written: Written = Written()
    optional: type | None = None
    item: type = float

    @property
    def kind(self) -> type:
        """The type of a value."""
        return self.optional or type(self.default)

    @property
    def flag(self) -> str:
        """The option on the command line: ``--time-step``."""
        return self.written.flag or "--" + self.name.replace("_", "-")

    @property
    def example(self) -> str:
        """An example of a value as a user could write it."""
        if self.kind is tuple:
            return _LIST_EXAMPLE
        return self.choices[-1] if self.choices else str(self.default)

    @property
    def chosen(self) -> float | None:
        """The number in files that represents Python's ``None``, which lets the family choose."""
        return None if self.bounds is None else self.bounds.chosen

    @property
    def python_default(self) -> Any:
        """The default for Python callers: ``None`` if the family chooses the value."""
        return None if self.chosen is not None and self.default == self.chosen else self.default

    @property
    def annotation(self) -> Any:
        """The type as shown in a signature, with bounds and unit."""
        if self.choices:
            return typing.Literal.__getitem__(self.choices)
        kind: Any = self.kind
        if self.chosen is not None:
            kind = kind | None
        rule = "" if self.bounds is None else self.bounds.rule
        return typing.Annotated[kind, rule] if rule else kind

    @property
    def note(self) -> str:
        """Its help and limits on one line."""
        if self.bounds is None:
            return self.help
        rule = self.bounds.rule if self.python_default is None else self.bounds.words
        return f"{self.help}  [{rule}]" if rule else self.help

    def accept(self, value: Any, owner: str) -> Any:
        """Convert a value to the form used in files.

        It becomes a float if the default is one, and a number for ``None``. NumPy's numbers count
        as Python's.

        Raises:
            InvalidParameter: If it has a different type from the default, is out of bounds, or
                isn't one of the choices.
        """
        # None may mean that the family chooses, or be the default.
        kind = self.kind
        value = _plain(value)
        if value is None and self.chosen is not None:
            return kind(self.chosen)
        if value is None and self.default is None:
            return None
        # Convert and check the type.
        if kind is tuple:
            return self._accept_list(value, owner)
        if kind is float and type(value) is int:
            # Values that no float can hold are refused unchanged.
            with contextlib.suppress(OverflowError):
                value = float(value)
        if isinstance(value, int) and not -_INT64 <= value < _INT64:
            raise InvalidParameter(
                "too-large",
                "{owner}: {name} is a number of more than 64 bits",
                "use a smaller one",
                owner=owner,
                name=self.name,
            )
        if type(value) is not kind and not (kind is Path and isinstance(value, Path)):
            raise self._wrong_type(value, owner)
        if isinstance(value, float) and not math.isfinite(value):
            raise self._not_finite(value, owner)
        # Check choices and bounds.
        if self.choices:
            check_choice(self.name, str(value), self.choices)
        if self.bounds is not None and isinstance(value, int | float):
            self.bounds.check(self.name, value)
        return value

    def parse(self, text: str | None, owner: str) -> Any:
        """Parse a value from a word.

        Examples are ``+mode=scale``, ``+negate``, ``+negate=on`` and ``+draws=0.25:0.5``.

        Args:
            text: The word; None if only the name was given.
            owner: Owner of the parameter, for messages.

        Raises:
            InvalidParameter: If the word is missing,
                or is not a valid value of the parameter's type.
        """
        # A switch needs no value.
        kind = self.kind
        if kind is bool:
            if text is not None and text.lower() not in _SWITCH:
                raise InvalidParameter(
                    "not-a-truth-value",
                    "{owner}: {name}={text!r} is neither on nor off",
                    "write one of these",
                    owner=owner,
                    name=self.name,
                    text=text[:40],
                )
            return text is None or _SWITCH[text.lower()]
        if not text:
            raise InvalidParameter(
                "missing-value",
                "{owner}: {name} needs a value",
                "write {name}={example}",
                owner=owner,
                name=self.name,
                example=self.example,
            )
        try:
            # Convert the text, then check the value like any other.
            value = tuple(map(self.item, text.split(":"))) if kind is tuple else kind(text)
        except ValueError as error:
            raise InvalidParameter(
                "not-a-number",
                "{owner}: {name}={text!r} is not a {expected}",
                "write one such as {example}",
                owner=owner,
                name=self.name,
                text=text[:40],
                expected=_KINDS[kind],
                example=self.example,
            ) from error
        return self.accept(value, owner)

    def _accept_list(self, value: Any, owner: str) -> tuple[Any, ...]:
        # Items are all texts, or all finite numbers.
        if not isinstance(value, list | tuple):
            raise self._wrong_type(value, owner)
        items = tuple(map(_plain, value))
        if self.item is str:
            if not all(isinstance(item, str) for item in items):
                raise self._wrong_type(value, owner)
            return items
        if not all(isinstance(item, int | float) and not isinstance(item, bool) for item in items):
            raise self._wrong_type(value, owner)
        numbers = tuple(map(float, items))
        if not all(map(math.isfinite, numbers)):
            raise self._not_finite(value, owner)
        return numbers

    def _wrong_type(self, value: Any, owner: str) -> InvalidParameter:
        return InvalidParameter(
            "wrong-type",
            "{owner}: {name}={value!r} is a {kind}",
            "use a {expected}",
            owner=owner,
            name=self.name,
            value=value,
            kind=type(value).__name__,
            expected=self._expected(),
        )

    def _expected(self) -> str:
        if self.kind is not tuple:
            return self.kind.__name__
        return "list of words" if self.item is str else _KINDS[tuple]

    def _not_finite(self, value: Any, owner: str) -> InvalidParameter:
        return InvalidParameter(
            "not-finite",
            "{owner}: {name}={value} is not finite",
            "use a finite number",
            owner=owner,
            name=self.name,
            value=value,
        )


def split_options(
    text: str, example: str = "NAME+option=value"
) -> tuple[str, dict[str, str | None]]:
    """Split ``NAME+option=value+switch`` into name and options.

    Dashes in an option's name become underscores. Controllers, formats and families all share this
    grammar. A ``+`` inside a path does not begin an option.

    Args:
        text: Text as a user wrote it.
        example: A valid text, for messages: ``ros+mode=scale``.

    Returns:
        The name, and each option's value as text; None for an option without ``=``.

    Raises:
        InvalidParameter: If a name is missing, or an option is given twice.
    """
    # Split off the name.
    ways_to_read = (_REGISTERED, _CLASS_IN_FILE, _WRITTEN)
    parts = next(filter(None, (one.fullmatch(text.strip()) for one in ways_to_read)), None)
    if parts is None:
        raise InvalidParameter(
            "empty-name",
            "an empty text is not a name",
            "write one such as {example}",
            example=example,
        )
    if parts["name"].startswith("+") or re.search(r"\+(?:$|\+|=)", parts["name"]):
        raise InvalidParameter(
            "wrong-form",
            "{text!q} has a + without a name",
            "write one such as {example}",
            text=text,
            example=example,
        )
    # Read the options.
    options: dict[str, str | None] = {}
    for word in parts["options"].split("+")[1:]:
        option, equals, value = word.partition("=")
        option = option.replace("-", "_")
        if option in options:
            raise InvalidParameter(
                "twice", "{text!q} has {option} twice", "keep one", text=text, option=option
            )
        options[option] = value.strip() if equals else None
    return parts["name"], options


def with_options(name: str, options: Mapping[str, str | None]) -> str:
    """Return a name with options, which :func:`split_options` splits again."""
    words = [option if value is None else f"{option}={value}" for option, value in options.items()]
    return "+".join([name, *words])


def split_headed(text: str, word: str) -> tuple[str, str] | None:
    """Split ``cmd+deadline=1:./mine`` at its first colon.

    The options of such a name precede the colon, because a ``+`` after it belongs to the rest.

    Returns:
        The word with its options, for :func:`split_options`, and the rest; None if the text does
        not begin with the word.
    """
    head, colon, rest = text.partition(":")
    return (head, rest) if colon and head.partition("+")[0] == word else None


def without_class_options(text: str) -> str:
    """Return the name of a class in a file without its options, and any other text unchanged."""
    parts = _CLASS_IN_FILE.fullmatch(text)
    return text if parts is None else parts["name"]


def find_parameter(
    name: str, known: Iterable[Parameter], owner: str, also: Collection[str] = ()
) -> Parameter:
    """Return the option with that name.

    Args:
        name: Name with underscores.
        known: All options.
        owner: Their owner, for messages.
        also: Other names to suggest.

    Raises:
        InvalidParameter: If there is none.
    """
    by_name = {parameter.name: parameter for parameter in known}
    if name in by_name:
        return by_name[name]
    names = [*also, *by_name]
    remedy = "it has {known!l}" if names else "it has no options; omit it"
    raise InvalidParameter.of(
        unknown_name("{owner} has no option {name!r}", name, names, remedy, owner=owner)
    )


def parse_options(
    words: Mapping[str, str | None], known: Iterable[Parameter], owner: str
) -> dict[str, Any]:
    """Parse the values of options from :func:`split_options`.

    Raises:
        InvalidParameter: If an option is unknown, or its text is not a valid value.
    """
    known = tuple(known)
    found = {}
    for name, text in words.items():
        parameter = find_parameter(name, known, owner)
        found[parameter.name] = parameter.parse(text, owner)
    return found


def _plain(value: Any) -> Any:
    """Convert a NumPy number to Python's; NumPy itself is not imported for this."""
    numpy = sys.modules.get("numpy")
    return value.item() if numpy is not None and isinstance(value, numpy.generic) else value


@functools.cache
def parameters_of_fields(options: type) -> tuple[Parameter, ...]:
    """Return the fields of a dataclass of options as declared, in order of declaration.

    A field whose default is neither None nor a bool, number, word or tuple of numbers or words is
    not an option and is skipped. Help comes from the docstrings of the class and its bases.
    """
    hints = typing.get_type_hints(options, include_extras=True)
    notes: dict[str, str] = {}
    for base in reversed(options.__mro__):
        notes |= argument_notes(vars(base).get("__doc__") or "")
    return tuple(
        _declared(field.name, field.default, hints[field.name], notes)
        for field in dataclasses.fields(options)
        if field.default is None or isinstance(field.default, (*_PLAIN, tuple))
    )


def parameters_of_class(kind: type) -> tuple[Parameter, ...]:
    """Return the public numbers, switches and words of any class that have a default.

    These are the parameters of its ``__init__``, which are the fields of a dataclass, and then the
    attributes of the class. The class need not declare anything for this; annotations and entries
    of docstrings are used where there are some.
    """
    found: dict[str, Any] = {}
    notes: dict[str, str] = {}
    hints: dict[str, Any] = {}
    for base in reversed(kind.__mro__):
        notes |= argument_notes(vars(base).get("__doc__") or "")
        found |= {name: _plain(value) for name, value in vars(base).items()}
    for thing in (kind, *(vars(base).get("__init__") for base in reversed(kind.__mro__))):
        # A user's annotation may be anything, even a name that does not exist.
        with contextlib.suppress(Exception):
            hints |= typing.get_type_hints(thing, include_extras=True)
    initial = initial_values(kind)
    found = initial | {name: value for name, value in found.items() if name not in initial}
    for name, value in found.items():
        # ``lookahead: float = 1`` is a float.
        if type(value) is int and hints.get(name) is float:
            found[name] = float(value)
    return tuple(
        _declared(name, value, hints.get(name), notes)
        for name, value in found.items()
        if type(value) in _PLAIN and not name.startswith("_")
    )


def initial_values(kind: type) -> dict[str, Any]:
    """Return the parameters with which a class can be called by name, each with its default."""
    by_name = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    try:
        parameters = inspect.signature(kind).parameters.values()
    except (TypeError, ValueError):
        return {}
    return {one.name: _plain(one.default) for one in parameters if one.kind in by_name}


def parameters_of(function: Callable[..., Any], owner: str) -> tuple[Parameter, ...]:
    """Return the keyword-only parameters of a function, in order of declaration.

    Args:
        function: A function that :func:`check_declared` accepts.
        owner: Its owner, for messages.

    Raises:
        InvalidParameter: If an annotation names something that does not exist at run time.
    """
    try:
        hints = typing.get_type_hints(function, include_extras=True)
    except NameError as error:
        raise InvalidParameter(
            "wrong-declaration",
            "{owner}: {reason}",
            "move the imports that its annotations need out of TYPE_CHECKING",
            owner=owner,
            reason=str(error),
        ) from error
    notes = argument_notes(function.__doc__ or "")
    return tuple(
        _declared(name, parameter.default, hints.get(name), notes)
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    )


def check_declared(
    function: Callable[..., Any], owner: str, taken: Collection[str] = (), *, positional: int = 1
) -> None:
    """Reject a function unless all its parameters follow ``*`` and have plain defaults.

    Args:
        function: The function.
        owner: Its owner, for messages.
        taken: Reserved names.
        positional: Number of parameters before them.

    Raises:
        InvalidParameter: If a parameter is faulty; the error names the first one.
    """
    for parameter in list(inspect.signature(function).parameters.values())[positional:]:
        if parameter.kind is not inspect.Parameter.KEYWORD_ONLY or parameter.name in taken:
            but = f", and must not be called {', '.join(taken)}" if taken else ""
            raise InvalidParameter(
                "wrong-declaration",
                "{owner}: parameter {name!r} must come after *{arguments}",
                owner=owner,
                name=parameter.name,
                arguments=but,
            )
        if type(parameter.default) not in _PLAIN:
            raise InvalidParameter(
                "wrong-declaration",
                "{owner}: parameter {name!r} needs a default that is a bool, int, float or str",
                owner=owner,
                name=parameter.name,
            )


def _declared(name: str, default: Any, hint: Any, notes: Mapping[str, str]) -> Parameter:
    """Build one option from its default, its annotation and the docstring's entries."""
    details = getattr(hint, "__metadata__", ())
    plain = typing.get_args(hint)[0] if details else hint
    optional: type | None = None
    item: type = float
    if default is None:
        plain = next(kind for kind in typing.get_args(plain) if kind is not types.NoneType)
        # A Literal is made of words.
        optional = str if typing.get_origin(plain) is typing.Literal else plain
    if isinstance(default, tuple):
        item = typing.get_args(plain)[0]
    return Parameter(
        name,
        default,
        typing.get_args(plain) if typing.get_origin(plain) is typing.Literal else (),
        notes.get(name, ""),
        next((detail for detail in details if isinstance(detail, Bounds)), None),
        next((detail.heading for detail in details if isinstance(detail, Group)), ""),
        next((detail for detail in details if isinstance(detail, Written)), Written()),
        optional,
        item,
    )


def argument_notes(docstring: str) -> dict[str, str]:
    """Return the entries of a docstring's ``Args`` section, Google style, each on one line."""
    section = re.search(r"^Args:\n((?:[ ]+.*\n?|\n)+)", inspect.cleandoc(docstring), re.MULTILINE)
    if section is None:
        return {}
    entries = re.split(r"^ {4}(\w+): ", section.group(1), flags=re.MULTILINE)[1:]
    return {
        name: " ".join(note.split()) for name, note in zip(entries[::2], entries[1::2], strict=True)
    }
