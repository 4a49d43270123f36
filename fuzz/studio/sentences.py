"""Sentences of the library in the words of the page: what they name can be done there.

The library tells the command line's users the way out, by options. On the page most of these are fields and buttons.
"""

from __future__ import annotations

import re

__all__ = ["on_the_page"]

_NAME = "name another folder"
_SAID = (  # what is said, and what the page says instead; the first that fit are taken, one after the other
    (r"say which with --from", "say which in Options of the import"),
    (r"`worldgen formats` lists those that are", "Options of the import lists those that are"),
    (r", as `worldgen formats` lists them", ""),
    (r"this one with --scen", "this one with it"),
    (r"; say one with --from (\w+)\+(\w+)=NAME", r"; name one in Options of the import, \2"),
    (r"; --cell-size says another", "; Cell size, under World, says another"),
    (r"--seed looks", "Seed of places looks"),
    (r"; say which with --to(: \S+)?", "; choose one under Export as"),
    (r"; --to (\w+) has", r"; export as \1 has"),
    (r" by --to (\w+)", r" by exporting as \1"),
    (r"export --to (\w+)", r"export as \1"),
    (r"give --at 0 for", "give the time 0 under Options of the format for"),
    (r"give --origin (\S+)", r"give the origin \1 under Options of the format"),
    (r"; `worldgen maze (.+?)` makes such a maze", "; Generate makes mazes of any size"),
    (r"give --force to overwrite it, or another name", "overwrite it, or give another name"),
    (r"give --force to add to them and replace those of the same name, or name another folder", _NAME),
    (r"worldgen fuzz --resume (\S+) goes on with that one, --force begins anew, or", r"choose it above and go on, or"),
    (r"--force begins anew, or ", ""),
    (r"name another folder, or begin anew with --force", _NAME),
    (r"--force begins a new campaign", _NAME),
    (r"give --units (\S+) or more, or --force to begin anew", rf"give \1 units or more, or {_NAME}"),
    (r"worldgen fuzz --controller NAME --out \S+ begins one", "Begin begins one"),
    (r"worldgen fuzz --resume (.+?) goes on", "Resume goes on"),
    (r"worldgen fuzz --resume \S+ --units \S+ does the rest", "Go on does the rest"),
    (r"take --motion (\S+) without \+keep_going", r"take another motion model than stepped+keep_going"),
    (r"take --motion (\w+) or (\w+) for", r"take the motion model \1 or \2 for"),
    (r"(take|with) --motion (\w+)", r"\1 the motion model \2"),
    (r"give a smaller --steps", "give fewer steps"),
    (r"give a larger --budget", "give more seconds"),
    (r"; --count-hazards makes failures of them", ""),  # on the page they hang on the wall with the failures
    (r"--time-step", "time step"),
    (r"write --oracle (\S+)", r"write \1"),
    (r"--vary (\S+)", r"\1"),
    (r"give it to --controller as it is", "name it as it is when the studio is started"),
    (r"; give --worldgen-controller", "; open it on the page Play, and choose one there"),
)
_LONGEST = 4_000  # characters; what is longer quotes a file, and looking through that takes minutes
_ASIDE = re.compile(r"(?<![\w-])--[a-z](?!\S*[/.]\w)")  # an option that is left over, and no part of a file's name


def on_the_page(sentence: str) -> str:
    """A sentence whose way out can be gone on the page; one that only a terminal has says so.

    Args:
        sentence: Of the library, an error's or a note's.
    """
    sentence = sentence if len(sentence) <= _LONGEST else f"{sentence[:_LONGEST]}..."
    for said, instead in _SAID:
        sentence = re.sub(said, instead, sentence)
    left = _ASIDE.search(sentence) and "terminal" not in sentence and "worldgen studio" not in sentence
    return f"{sentence} (at a terminal)" if left else sentence
