"""Read XML as a tree of names and words, which remembers what a reader takes.

Document types, entities and excessive depth are refused, and every error has its line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from worldgen.errors import FormatError
from worldgen.interop.account import IsHarmless, NamedParts, Names, account_for

_MOST_DEPTH = 64
_MOST_ELEMENTS = 2_000_000
_CHUNK = 1 << 16
_LONGEST_ENTITY = 200
# Times that entities may lengthen a file.
_MOST_GROWN = 4


@dataclass
class XmlElement:
    """An element, and what a reader took of it.

    Args:
        name: Its name, with the prefix used in the file.
        line: Line where it begins.
        attributes: Values by name.
        inside: Its child elements. Only the parser uses this; readers call the methods.
        words: Its own text, without its children's. Only the parser uses this.
    """

    name: str
    line: int
    attributes: NamedParts = field(default_factory=NamedParts)
    inside: list[XmlElement] = field(default_factory=list)
    words: str = ""
    _is_taken: bool = False
    _has_text_taken: bool = False

    @property
    def text(self) -> str:
        """The text inside it, without its children's text."""
        self._has_text_taken = True
        return self.words

    @property
    def children(self) -> list[XmlElement]:
        """The elements inside it, all of which are taken."""
        for child in self.inside:
            child._is_taken = True
        return self.inside

    def all(self, *names: str) -> Iterator[XmlElement]:
        """Yield the elements at the end of a path of names."""
        for child in self.inside:
            if child.name == names[0]:
                child._is_taken = True
                yield from child.all(*names[1:]) if names[1:] else (child,)

    def pass_over(self) -> None:
        """State that nothing in here can be an obstacle, or that it is reported otherwise."""
        self.attributes.pass_over()
        self._has_text_taken = True
        for child in self.inside:
            child._is_taken = True
            child.pass_over()

    def left_over(self, path: Names, is_harmless: IsHarmless) -> Iterator[str]:
        """Yield a few words for each element and attribute that nobody took."""
        path = path or (self.name,)
        for name in self.attributes.untaken():
            # Namespaces and languages belong to XML itself.
            if not (name.startswith(("xmlns", "xml:")) or is_harmless((*path, name))):
                yield f"attributes {name} of <{path[-1]}>"
        if not (self._has_text_taken or is_harmless((*path, "text"))) and self.words.strip():
            yield f"texts in <{path[-1]}>"
        for child in self.inside:
            inner = (*path, child.name)
            if is_harmless(inner):
                continue
            if child._is_taken:
                yield from child.left_over(inner, is_harmless)
            else:
                yield f"elements <{child.name}> in <{path[-1]}>"

    def first(self, *names: str) -> XmlElement | None:
        """Return the first of the elements that :meth:`all` yields."""
        return next(self.all(*names), None)

    def word(self, *names: str, default: str = "") -> str:
        """Return the text of the first of them, stripped."""
        found = self.first(*names)
        return default if found is None else found.text.strip()


def read_xml(data: bytes) -> XmlElement:
    """Return the root of a file, whose elements are accounted for.

    Raises:
        FormatError: As :func:`parse_xml` does.
    """
    return account_for(parse_xml(data))


def parse_xml(data: bytes, *, plain_entities: bool = False) -> XmlElement:
    """Return the root of a file of which the caller itself reports what it does not read.

    Args:
        data: The file.
        plain_entities: True to accept a document type and short entities, as drawing programs
            write them.

    Raises:
        FormatError: If it isn't well-formed XML, declares a document type, or is nested too deeply.
    """
    reader = _TreeBuilder(_MOST_GROWN * len(data) + _CHUNK if plain_entities else None)
    try:
        for at in range(0, len(data), _CHUNK):
            reader.parser.Parse(data[at : at + _CHUNK], False)
        reader.parser.Parse(b"", True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise FormatError(
            "not-xml",
            "is not XML: {reason} in column {column}",
            "correct it there, or just before that",
            reason=reason,
            column=error.offset + 1,
            line=error.lineno,
        ) from error
    except FormatError:
        raise
    # Python does not know this encoding.
    except (ValueError, LookupError) as error:
        raise FormatError(
            "not-xml", "is not XML: {reason}", "save it as UTF-8", reason=str(error), line=1
        ) from error
    return reader.open[0].children[0]


class _TreeBuilder:
    """Build the tree, and refuse anything that could make a small file large when it appears."""

    def __init__(self, most_text: int | None = None) -> None:
        self._most_text = most_text
        self.open = [XmlElement("", 0)]
        self._count = 0
        self._texts: list[list[str]] = [[]]
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.EntityDeclHandler = self._entity
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters

    def _doctype(self, name: str, *_: object) -> None:
        if self._most_text is not None:
            return
        raise FormatError(
            "unsupported",
            "a document type ({name!q}) is declared; worlds have none, so delete the "
            "<!DOCTYPE ...>",
            name=name,
            line=self.parser.CurrentLineNumber,
        )

    def _entity(self, name: str, is_parameter: bool, value: str | None, *_: object) -> None:
        is_plain = not is_parameter and value is not None and "&" not in value
        if self._most_text is not None and is_plain and len(value or "") <= _LONGEST_ENTITY:
            return
        raise FormatError(
            "unsupported",
            "an entity ({name!q}) is declared",
            "write its text where it is used",
            name=name,
            line=self.parser.CurrentLineNumber,
        )

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        self._spend(sum(map(len, attributes.values())))
        if len(self.open) > _MOST_DEPTH or self._count > _MOST_ELEMENTS:
            raise FormatError(
                "too-large",
                "more than {most_depth} levels or {most_elements} elements",
                "cut out a smaller world",
                most_depth=_MOST_DEPTH,
                most_elements=_MOST_ELEMENTS,
                line=self.parser.CurrentLineNumber,
            )
        element = XmlElement(name, self.parser.CurrentLineNumber, NamedParts(attributes.items()))
        self.open[-1].inside.append(element)
        self.open.append(element)
        self._texts.append([])

    def _end(self, _: str) -> None:
        self.open.pop().words = "".join(self._texts.pop())

    def _spend(self, size: int) -> None:
        if self._most_text is not None:
            self._most_text -= size
            if self._most_text < 0:
                raise FormatError(
                    "too-large",
                    "entities make the file several times as long",
                    "write their text where they are used",
                    line=self.parser.CurrentLineNumber,
                )

    def _characters(self, text: str) -> None:
        self._spend(len(text))
        self._texts[-1].append(text)
