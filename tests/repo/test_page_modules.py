"""The scripts and styles of studio, report and replay.

Modules have no cycles, and export nothing unused.
"""

import functools
import re
from pathlib import Path

import pytest

from sim.controllers.behaviours import chart

FUZZ = Path(__file__).parents[2] / "fuzz"
PAGES = {
    "#player": FUZZ / "player" / "page",
    "#replay": FUZZ / "player" / "replay_page",
    "#report": FUZZ / "report" / "page",
    "#studio": FUZZ / "studio" / "page",
}
MODULES = [module for folder in PAGES.values() for module in sorted(folder.rglob("*.js"))]

IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";', re.MULTILINE)
DECLARED = r"(?:async )?(?:function|class|const|let) (\w+)"
each_module = pytest.mark.parametrize("module", MODULES, ids=lambda path: "/".join(path.parts[-3:]))


@functools.cache
def code(path):
    """A script without its comments."""
    return re.sub(r"/\*.*?\*/|(?<![:\w\"'])//[^\n]*", "", path.read_text("utf-8"), flags=re.DOTALL)


def imported(path):
    """Pairs of a module and a name that comes from there."""
    for names, source in IMPORT.findall(code(path)):
        page, _, inner = source.partition("/")
        module = PAGES[page] / inner if page in PAGES else path.parent / source
        for name in re.findall(r"\w+", names):
            yield module.resolve(), name


def exported(path):
    """Return the names that others may import, from ``export const a = 1,`` and the lines that
    continue it.
    """
    for first, more in re.findall(
        rf"^export {DECLARED}((?: = [^,;]+,\n  \w+)*)", code(path), re.MULTILINE
    ):
        yield from [first, *re.findall(r"\n  (\w+)", more)]


def cycle_from(path, above=()):
    """Return a cycle of imports, if there is one."""
    if path in above:
        return [part.name for part in (*above[above.index(path) :], path)]
    for part in sorted({module for module, _ in imported(path)}):
        if found := cycle_from(part, (*above, path)):
            return found
    return []


def times(script, name):
    """Return how often a script contains a name as a whole word."""
    return len(re.findall(rf"(?:(?<=\.\.\.)|(?<![\w.])){name}(?!\w)", script))


def declared(script):
    return re.findall(rf"^(?:export )?{DECLARED}", script, re.MULTILINE)


@each_module
def test_a_module_imports_what_is_there_and_uses_it(module):
    rest = IMPORT.sub("", code(module))
    assert [name for source, name in imported(module) if name not in set(exported(source))] == []
    assert [name for _, name in imported(module) if times(rest, name) == 0] == []


@each_module
def test_no_module_leads_back_to_itself(module):
    assert cycle_from(module) == []


@each_module
def test_what_a_module_exports_is_used_elsewhere(module):
    used = {name for other in MODULES for source, name in imported(other) if source == module}
    assert [name for name in exported(module) if name not in used] == []


@each_module
def test_what_is_declared_is_used(module):
    script = code(module)
    kept = set(exported(module))
    assert [name for name in declared(script) if name not in kept and times(script, name) < 2] == []


@pytest.mark.gate
@pytest.mark.parametrize(
    "style", sorted(FUZZ.rglob("*.css")), ids=lambda path: f"{path.parts[-3]}/{path.name}"
)
def test_every_class_in_a_style_is_on_some_element(style):
    makers = [path for path in sorted(FUZZ.rglob("*")) if path.suffix in (".js", ".html")]
    pages = "\n".join(
        path.read_text("utf-8")
        # Kinds of marks, and shapes of a flow chart.
        for path in (*makers, FUZZ / "player" / "runs.py", Path(chart.__file__))
    )
    selectors = re.sub(r"\{[^{}]*\}|/\*.*?\*/", "", style.read_text("utf-8"), flags=re.DOTALL)
    names = {
        re.sub(r"^robot-\d$", "robot-", name)
        for name in re.findall(r"[.#]([a-zA-Z][\w-]*)", selectors)
    }
    assert [
        name for name in sorted(names) if not re.search(rf"(?<![\w-]){name}(?![\w-])", pages)
    ] == []
