"""Corpora: read, compare, merge, prune and export folders and archives of failures.

Contents (each name is imported on first use):
    Corpus, CorpusEntry, Selection, read_corpus: Contents of a folder or an archive, without worlds.
    Baseline: Known failures.
    differences, CauseDifference: Compare two corpora.
    distinct, places, smallest: Order entries, and choose the simplest of each cause.
    merge: Collect these in a folder.
    judge_all, Judgement, remove: Find failures that can be deleted, and why.
    export: Write one archive, or a table.
    contact_sheet: Draw a corpus as one picture.

The files themselves are the only source of truth. See ``docs/howto/keep-failures.md``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from worldgen.support.lazy import lazy_names

if TYPE_CHECKING:
    from fuzz.corpus.baseline import Baseline
    from fuzz.corpus.comparing import CauseDifference, differences
    from fuzz.corpus.entry import CorpusEntry
    from fuzz.corpus.exporting import export
    from fuzz.corpus.merging import distinct, merge, places, smallest
    from fuzz.corpus.pictures import contact_sheet
    from fuzz.corpus.pruning import Judgement, judge_all, remove
    from fuzz.corpus.reading import Corpus, Selection, read_corpus

__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "baseline": ("Baseline",),
        "comparing": ("CauseDifference", "differences"),
        "entry": ("CorpusEntry",),
        "exporting": ("export",),
        "merging": ("distinct", "merge", "places", "smallest"),
        "pictures": ("contact_sheet",),
        "pruning": ("Judgement", "judge_all", "remove"),
        "reading": ("Corpus", "Selection", "read_corpus"),
    },
)

__all__ = [
    "Baseline",
    "CauseDifference",
    "Corpus",
    "CorpusEntry",
    "Judgement",
    "Selection",
    "contact_sheet",
    "differences",
    "distinct",
    "export",
    "judge_all",
    "merge",
    "places",
    "read_corpus",
    "remove",
    "smallest",
]  # fmt: skip
