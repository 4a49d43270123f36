"""Account for every element of a map's file: read, harmless or unread.

Contents:
    Account, accounting: What the parsers of one file register.
    account_for, report_unread: Register a tree; report an element that is passed over.
    damage: Puts a parser's error into words.
    Tree, Names, IsHarmless: What a parser's tree must be able to do.
    NamedParts, parse_json: Trees of named parts, such as JSON's.
"""

from worldgen.interop.account.trees import (
    Account,
    IsHarmless,
    NamedParts,
    Names,
    Tree,
    account_for,
    accounting,
    damage,
    parse_json,
    report_unread,
)

__all__ = [
    "Account",
    "IsHarmless",
    "NamedParts",
    "Names",
    "Tree",
    "account_for",
    "accounting",
    "damage",
    "parse_json",
    "report_unread",
]
