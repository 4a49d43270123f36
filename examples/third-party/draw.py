"""Draw the stored failures next to each other.

Run ``python examples/third-party/draw.py`` with the packages installed.
"""

from pathlib import Path

from fuzz.corpus import contact_sheet, read_corpus

HERE = Path(__file__).parent


def main() -> None:
    """Write failures.png.

    Run it from the repository's root: the files name their controllers relative to it.
    """
    entries = read_corpus([HERE / "failures"]).entries
    ordered = sorted(entries, key=lambda entry: (entry.facts.controller, entry.facts.order))
    sheet = contact_sheet(ordered)
    (HERE / "failures.png").write_bytes(sheet)


if __name__ == "__main__":
    main()
