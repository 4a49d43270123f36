"""Find constructions that mark English as translated, in everything that users and developers read.

``python -m tests.repo.plain_english`` prints each mark with its file and line, then the number of
marks per 10,000 words. Arguments narrow it to files and folders. Hypothesis, click, NumPy, SciPy,
shapely, Gymnasium and trimesh have 0 to 2.2 by the same script.
"""

import ast
import io
import re
import subprocess
import sys
import tokenize
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
FOLDERS = (
    "worldgen",
    "sim",
    "fuzz",
    "worldgen_plugins",
    "docs",
    "examples",
    "build_tools",
    "benchmarks",
)
PAGES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")

_SUBJECT = r"(?:it|they|that|this|there|these|those|each|its|the|a|an|no|nothing|one|both|all)"
_VERB = r"(?:is|are|has|have|does|do|can|cannot|was|were|would|needs?|takes?|makes?|may|must|will)"
_OWNERS_OF_WAYS = (
    r"(?:its|his|robot's|longest|shortest|driven|sure|known|whole|recorded|found|free)"
)
_THINGS = (
    r"(?:controllers?|programs?|robots?|functions?|modules?|classes|files?|campaigns?|workers?"
    r"|process(?:es)?)"
)
_COUNTED = r"(?:cells|steps|seconds|worlds|bytes|times|units|as)"
_COMPARED = r"(?:longer|more|fewer|less|better|worse|larger|smaller|way to)"
_NAMELESS = r"(?:is|was|are|has|comes|lies|stands|goes|came|cannot|can|it|they|a|an|the)"

#: A pattern that marks a sentence as translated, and what a native speaker would write instead.
MARKS: dict[str, tuple[str, str]] = {
    "for ever": (r"\bfor ever\b", "forever, endlessly"),
    "beside": (r"\bbeside\b", "next to, in addition to"),
    "is no": (rf"(?<!there )\b(?:is|are|was|were|be) no (?!{_COMPARED}\b)", "isn't a, is not"),
    "is none": (r"(?<!there )\b(?:is|are|was|were) (?-i:none)\b", "isn't one, there are none"),
    "hangs on": (r"\bhangs? (?:on|from)\b", "depends on"),
    "goes on": (r"\b(?:go|goes|going|went) on\b(?! (?:to|a|the) )", "continues"),
    "likewise": (r"\blikewise\b", "also, same as above"),
    "anew": (r"\b(?:anew|afresh)\b", "again"),
    "left out": (r"\bwhere (?:it is |they are )?left out\b", "if omitted"),
    "that of": (r"(?<![`\w] )\b(?:is|are|as|than|from|with|to|by) (?:that|those) of\b", "X's"),
    "stands in": (r"\b(?:lies|stands) (?:in|on|at|there)\b", "is in"),
    "way": (
        rf"\b{_OWNERS_OF_WAYS} ways?\b(?! (?:to \w+ing|out|of \w+ing)\b)",
        "path, route, trajectory",
    ),
    "round": (r"\b(?:goes|go|going|drives?|driving|way|path|walks?|turns?) round\b", "around"),
    "for as because": (rf"[,;] for (?:{_SUBJECT}\b(?: \w+){{0,3}} {_VERB})\b", "because"),
    "who": (rf"\b{_THINGS} who\b", "which, that"),
    "Who does": (r"(?-i:(?:^|[.:] )Who \w+s\b)", "name the subject: a controller that"),
    "is told": (r"\b(?:is|are) told (?:as|by|apart|from|in)\b", "is reported as"),
    "is said": (r"\b(?:is|are|as|was|were) said\b", "is stated, as documented"),
    "what is": (rf"(?-i:(?:^|[.;:] )What {_NAMELESS}\b(?![^.]*\?))", "name it: 'files that ...'"),
    "whether first": (
        r"(?-i:(?:^|\. )Whether (?!to\b)(?:\w+ ){1,12}?"
        r"(?:is|are|has|can|was|does|do|may|must)\b(?![^.]*\?))",
        "Return True if",
    ),
    "come": (
        r"\b(?:comes?|came) (?:to be|of it|late|out as|about|in turn|amid|again|back as)\b",
        "a plain verb",
    ),
    "amid": (
        r"\b(?:amid|lest|whence|whither|thereof|therein|hitherto|save for|ere)\b",
        "a plain word",
    ),
    "may well": (r"\bmay (?:well )?not be so\b", "might not be"),
    "so many": (
        r"\b(?:so many|so much|so far as|as it were|as well as may be)\b"
        rf"(?= {_COUNTED}\b)",
        "this many, a number",
    ),
    "of its own": (r"\bof (?:our|its|their|his) own\b", "its own X"),
    "by itself": (r"\beach by itself\b", "individually"),
    "as ... says": (
        r"\bas (?:the |a |an )?\w+(?: \w+)? (?:says|tells|wants|has it)\b",
        "according to, as required by",
    ),
    "to be had": (r"\b(?:to be had|can be had|be got)\b", "is available"),
    "no more": (r"\b(?:and|but) no more\b", "only"),
    "not to": (r"\b(?:is|are) not to be\b", "must not be"),
    "in turn": (r"\bone after the other\b", "one after another, in turn"),
    "where": (r", where (?:it|they|there|none|nothing|one) (?:is|are|has|can)\b", "if"),
    "what": (
        r"\b(?:of|from|to|in|with|for|than) what "
        r"(?:is|was|are|has|comes|came|goes|lies|stands|it|they)\b",
        "name it",
    ),
    "all that": (
        r"\b(?:all|nothing|none|each) (?:that|of them that) (?:is|are|there is|it has|has|was)\b",
        "name it",
    ),
    "speaks of": (r"\b(?:speaks?|tells?|knows?|says?) of\b", "mentions, describes, reports"),
    "asked for": (r"\b(?:asked for|is asked|are asked|was asked)\b", "requested"),
    "round a": (
        r"(?<!to )\bround (?:an?|the|its?|them|each|every|which|walls?|corners?|obstacles?)\b"
        r"(?! (?:numbers?|values?|results?|trip|corners? of radius))",
        "around",
    ),
    "says that": (r"\b(?:says?|tells?|said|told) that\b", "reports, states"),
    "as said": (
        r"\b(?:is|are|was|were|be|there|not|file|world) as (?:said|asked|wanted|told|given)\b"
        r"|\bas wanted\b",
        "matches, as requested",
    ),
    "what is known": (r"\bwhat (?:is|was|are) (?:known|new|there|said|asked)\b", "name it"),
    "one who": (r"\b(?:one|those|he|him) who\b", "someone who, users who"),
    "fulfils": (r"\b(?:fulfil(?:s|led)?|grants?) (?:a|the|its|their) wish", "meets the condition"),
    "it takes": (r"\b[Ii]t (?:takes|wants) (?:gcc|a compiler|two|git|Docker)\b", "requires"),
    "for want of": (r"\bfor want of\b", "because there is no"),
    "such as are": (r"\bsuch as (?:is|are|have|has|can)\b", "those that"),
    "no sooner": (r"\b(?:no sooner|scarcely|in vain|henceforth|forthwith|as yet)\b", "plainly"),
    "be it": (r"\b(?:be it|be they|come what may|if need be)\b", "whether, if necessary"),
    "dear": (r"\b(?:dear(?:er)?|dearly)\b", "expensive"),
    "naught": (r"\bnothing else is\b|\bnaught\b", "only"),
    "reckon": (r"\b(?:reckon(?:s|ed|ing)?)\b", "compute"),
    "gone": (r"\b(?:is|are|be) gone\b", "no longer exists, was deleted"),
    "at once": (r"\ball at once\b|\bat one go\b|\bby and by\b", "together, gradually"),
}
_DIRECTIVE = re.compile(r"#\s*(?:type:|noqa|fmt:|pragma|!)")
_PATTERNS = {name: re.compile(pattern, re.IGNORECASE) for name, (pattern, _) in MARKS.items()}


class Text(NamedTuple):
    """A piece of prose and the line it begins in."""

    line: int
    words: str


class Mark(NamedTuple):
    """A construction that was found."""

    path: str
    line: int
    name: str
    sentence: str


def _python(source: str) -> list[Text]:
    """Return docstrings, comments, and the strings that are sentences."""
    return _strings(ast.parse(source)) + _python_comments(source)


def _strings(tree: ast.AST) -> list[Text]:
    texts = []
    docstrings = set()
    inside_f_strings = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.add(node.value)
        elif isinstance(node, ast.JoinedStr):
            inside_f_strings.update(node.values)
            parts = (str(v.value) if isinstance(v, ast.Constant) else "X" for v in node.values)
            words = "".join(parts)
            if _is_prose(words):
                texts.append(Text(node.lineno, words))
        elif (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and node not in inside_f_strings
            and (node in docstrings or _is_prose(node.value))
        ):
            texts.extend(_paragraphs(node.value, node.lineno))
    return texts


def _python_comments(source: str) -> list[Text]:
    texts = []
    block: list[str] = []
    first = last = 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type != tokenize.COMMENT or _DIRECTIVE.match(token.string):
            continue
        line = token.start[0]
        if block and line != last + 1:
            texts.append(Text(first, " ".join(block)))
            block = []
        if not block:
            first = line
        last = line
        block.append(token.string.lstrip("#: "))
    if block:
        texts.append(Text(first, " ".join(block)))
    return texts


def _is_prose(words: str) -> bool:
    return len(re.findall(r"[a-z]{2,}(?: |$|[.,;])", words)) >= 4


def _paragraphs(text: str, line: int) -> list[Text]:
    found = []
    at = line
    for paragraph in re.split(r"(\n\s*\n)", text):
        if paragraph.strip():
            found.append(Text(at, re.sub(r"\s+", " ", paragraph).strip()))
        at += paragraph.count("\n")
    return found


def _markdown(source: str) -> list[Text]:
    prose = re.sub(
        r"^(```|~~~).*?^\1[^\n]*$",
        lambda code: "\n" * code[0].count("\n"),
        source,
        flags=re.M | re.S,
    )
    prose = re.sub(r"<!--.*?-->", lambda code: "\n" * code[0].count("\n"), prose, flags=re.S)
    return _paragraphs(prose, 1)


def _comments(source: str) -> list[Text]:
    found = []
    for block in re.finditer(r"/\*.*?\*/|(?:^[ \t]*//[^\n]*\n)+|//[^\n]*", source, re.S | re.M):
        words = re.sub(r"^[ \t]*(?://+|/?\*+/?)", "", block[0], flags=re.M)
        found.extend(_paragraphs(words, source.count("\n", 0, block.start()) + 1))
    return found


_READERS = {
    ".py": _python,
    ".md": _markdown,
    ".c": _comments,
    ".h": _comments,
    ".js": _comments,
    ".css": _comments,
}


def _prose(path: Path) -> list[Text]:
    texts = _READERS[path.suffix](path.read_text("utf-8"))
    return [Text(line, re.sub(r"``[^`]*``|`[^`]*`", "X", words)) for line, words in texts]


def marks_of(path: Path) -> tuple[int, list[Mark]]:
    """Return how many words of prose a file has, and its marks."""
    count = 0
    found = []
    for line, words in _prose(path):
        count += len(re.findall(r"[A-Za-z][\w'-]*", words))
        for name, pattern in _PATTERNS.items():
            for hit in pattern.finditer(words):
                sentence = words[max(0, hit.start() - 50) : hit.end() + 40]
                found.append(Mark(str(path.relative_to(ROOT)), line, name, sentence))
    return count, found


def readable_files(paths: list[str]) -> list[Path]:
    """Return the tracked files with prose under these paths."""
    listed = subprocess.run(
        ["git", "ls-files", *paths], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\n")
    return [
        ROOT / name for name in listed if Path(name).suffix in _READERS and (ROOT / name).is_file()
    ]


def main() -> None:
    """Print every mark, and the rate."""
    words = 0
    marks: list[Mark] = []
    for path in readable_files(sys.argv[1:] or [*FOLDERS, *PAGES]):
        count, found = marks_of(path)
        words += count
        marks += found
    for mark in marks:
        print(f"{mark.path}:{mark.line}: {mark.name} ({MARKS[mark.name][1]}): {mark.sentence}")
    print(f"{len(marks)} marks in {words} words: {1e4 * len(marks) / max(words, 1):.1f} per 10,000")


if __name__ == "__main__":
    main()
