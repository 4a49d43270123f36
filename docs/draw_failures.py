"""Draws the failures of the library and lists them: ``python docs/draw_failures.py``.

Writes the table of ``corpora/failures/README.md`` and its picture, the smallest failure of each
controller.
"""

from __future__ import annotations

import statistics
from collections import Counter, defaultdict
from pathlib import Path

from fuzz.corpus import CorpusEntry, contact_sheet, read_corpus

ROOT = Path(__file__).parents[1]
FAILURES = ROOT / "corpora" / "failures"
BEGIN, END = "<!-- table: python docs/draw_failures.py -->\n", "<!-- end of table -->\n"
HEAD = (
    "| controller | motion | failures | verdicts | solid cells, median and most | cells, median |\n"
)


def failures() -> dict[tuple[str, str], list[CorpusEntry]]:
    """Return all that ships, by controller and motion model."""
    found: dict[tuple[str, str], list[CorpusEntry]] = defaultdict(list)
    for entry in read_corpus([FAILURES]).entries:
        found[entry.facts.controller, entry.facts.motion].append(entry)
    return dict(sorted(found.items()))


def row(controller: str, motion: str, entries: list[CorpusEntry]) -> str:
    """Return a line of the table."""
    verdicts = Counter(entry.facts.verdict for entry in entries)
    solid = [entry.facts.solid for entry in entries]
    cells = [entry.facts.width * entry.facts.height for entry in entries]
    said = ", ".join(f"{verdict} {count}" for verdict, count in verdicts.most_common())
    return (
        f"| `{controller}` | {motion} | {len(entries)} | {said} | "
        f"{statistics.median(solid):g}, {max(solid)} | {statistics.median(cells):g} |\n"
    )


def smallest(entries: list[CorpusEntry]) -> CorpusEntry:
    """Return the smallest failure: a loop if there is one, for that says more than a fire."""
    return min(entries, key=lambda entry: (entry.facts.verdict != "loop", entry.facts.order))


def main() -> None:
    """Write both."""
    found = failures()
    table = (
        HEAD
        + "| --- | --- | ---: | --- | ---: | ---: |\n"
        + "".join(row(*key, some) for key, some in found.items())
    )
    readme = FAILURES / "README.md"
    before, _, rest = readme.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    readme.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8", newline="\n")
    picture = Path(__file__).with_name("pictures") / "library-failures.png"
    picture.write_bytes(contact_sheet([smallest(entries) for entries in found.values()]))


if __name__ == "__main__":
    main()
