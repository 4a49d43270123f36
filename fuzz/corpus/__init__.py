"""Corpora: folders and archives of failures, read, compared, merged, pruned, exported.

Contents:
    Corpus, Entry, Selection, read_corpus: what a folder or an archive holds, without its worlds.
    Baseline: classes that are known.
    differences, Difference: what one corpus has that another has not.
    merge, smallest: the smallest failure of each class, in a folder.
    judge_all, Judgement, remove: what may be dropped, and why.
    export: one archive, or a table.
    contact_sheet: a corpus as one picture.

The files are the truth. ``docs/howto/corpus.md`` is the description.
"""

from fuzz.corpus.baseline import Baseline
from fuzz.corpus.comparing import BucketDifference, differences
from fuzz.corpus.entry import CorpusEntry
from fuzz.corpus.exporting import export
from fuzz.corpus.merging import merge, smallest
from fuzz.corpus.pictures import contact_sheet
from fuzz.corpus.pruning import Judgement, judge_all, remove
from fuzz.corpus.reading import Corpus, Selection, read_corpus

__all__ = [
    "Baseline",
    "BucketDifference",
    "Corpus",
    "CorpusEntry",
    "Judgement",
    "Selection",
    "contact_sheet",
    "differences",
    "export",
    "judge_all",
    "merge",
    "read_corpus",
    "remove",
    "smallest",
]  # fmt: skip
