"""Write the types of the studio's messages for its scripts: ``fuzz/studio/page/messages.d.ts``.

``python -m build_tools.page_types`` writes them from ``fuzz/studio/requests/protocol.py`` and from
the functions that answer; ``npm run check`` then checks the scripts against them.
"""

from __future__ import annotations

import enum
import inspect
import re
import types
import typing
from pathlib import Path
from typing import Annotated, Any, Literal, Union

import msgspec

from fuzz.campaign.store import Budget
from fuzz.overview.answer import Headline, RankedCause
from fuzz.studio.answers import ANSWERING, answer
from fuzz.studio.requests import protocol
from fuzz.unit.result import StrategyYield
from worldgen.parameters import argument_notes

FILE = Path(__file__).parents[1] / "fuzz/studio/page/messages.d.ts"
_HEAD = """\
// Written by `python -m build_tools.page_types` from fuzz/studio/requests/protocol.py; not edited.
"""
_PLAIN = {
    bool: "boolean",
    int: "number",
    float: "number",
    str: "string",
    bytes: "string",
    protocol.Seed: "string",
    type(None): "null",
    Any: "any",
    object: "never",
}
_IN_SERVER = {
    protocol.Edits: (list[protocol.CodeFile], type(None)),
    protocol.Watch: (protocol.CampaignState, protocol.CampaignState | None),
    protocol.Stop: (object, protocol.CampaignState | None),
    protocol.Cancel: (object, type(None)),
}
"""Parts and answer of the requests that have no function in ``ANSWERING``."""


def page_types() -> str:
    """Return the text of the file."""
    structs = [
        kind
        for kind in vars(protocol).values()
        if inspect.isclass(kind) and issubclass(kind, msgspec.Struct)
        if kind not in (msgspec.Struct, protocol.Request, protocol.Reply)
    ]
    others = [one for one in structs if not issubclass(one, protocol.Request)]
    tables = [
        _interface(kind)
        for kind in (*dict.fromkeys([*others, Headline, RankedCause, StrategyYield]), Budget)
    ]
    messages = [_message(name, kind) for name, kind in protocol.REQUESTS.items()]
    kinds = "/** Each kind of request: its fields, the parts of its answer, and the answer. */"
    return "\n".join([_HEAD, *tables, kinds, "interface Messages {", *messages, "}", ""])


def _message(name: str, kind: type[protocol.Request]) -> str:
    part, reply = _IN_SERVER.get(kind) or _answered(kind)
    fields = "".join(f" {line}" for line in _fields(kind, skip=("id",)))
    return (
        f"  /** {_summary(kind)} */\n"
        f"  {name}: {{ request: {{{fields} }}; part: {_text(part)}; answer: {_text(reply)} }};"
    )


def _answered(kind: type) -> tuple[Any, Any]:
    """Return the types of the parts and of the answer, as the function that answers has them."""
    function = answer.dispatch(kind)
    if function.__module__ not in {module.__name__ for module in ANSWERING}:
        raise TypeError(f"nothing answers {kind.__name__}")
    hints = typing.get_type_hints(function, include_extras=True)
    sends = typing.get_args(hints["part"])
    return sends[0][0] if sends else object, hints["return"]


def _interface(kind: type) -> str:
    notes = argument_notes(inspect.cleandoc(kind.__doc__ or ""))
    lines = []
    for line in _fields(kind):
        name = line.partition(":")[0].removesuffix("?")
        if name in notes:
            lines.append(f"  /** {_plain(notes[name])} */")
        lines.append(f"  {line}")
    return "\n".join([f"/** {_summary(kind)} */", f"interface {kind.__name__} {{", *lines, "}", ""])


def _summary(kind: type) -> str:
    return _plain((kind.__doc__ or "").partition("\n\n")[0])


def _plain(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("``", "`").strip()


def _fields(kind: type, skip: tuple[str, ...] = ()) -> list[str]:
    """Return the fields of a struct or a dataclass as members of an interface.

    In what the page sends, fields with a default may be omitted; in an answer, if it omits them.
    """
    hints = typing.get_type_hints(kind, include_extras=True)
    found = []
    for one in msgspec.inspect.type_info(kind).fields:  # type: ignore[attr-defined]
        if one.name not in skip:
            config = getattr(kind, "__struct_config__", None)
            may_lack = config and (config.omit_defaults or config.forbid_unknown_fields)
            mark = "?" if may_lack and not one.required else ""
            found.append(f"{one.name}{mark}: {_text(hints[one.name])};")
    return found


def _text(hint: Any) -> str:
    """Return a type in TypeScript."""
    origin = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin is Annotated:
        titles = [one.title for one in arguments[1:] if one.title]
        return titles[0] if titles else _text(arguments[0])
    if origin in (Union, types.UnionType):
        return " | ".join(dict.fromkeys(map(_text, arguments)))
    if origin is Literal:
        return " | ".join(f'"{one}"' for one in arguments)
    if origin is list:
        inner = _text(arguments[0])
        return f"({inner})[]" if " " in inner and not inner.startswith("[") else f"{inner}[]"
    if origin is tuple:
        return f"[{', '.join(map(_text, arguments))}]"
    if origin is dict:
        return f"Record<{_text(arguments[0])}, {_text(arguments[1])}>"
    if hint in _PLAIN:
        return _PLAIN[hint]
    if issubclass(hint, enum.StrEnum):
        return " | ".join(f'"{one.value}"' for one in hint)
    return str(hint.__name__)


if __name__ == "__main__":
    FILE.write_text(page_types(), encoding="utf-8")
