"""Settings of the documentation site: ``python -m sphinx -W --keep-going docs build/docs``."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
_ENTRY = 4  # columns before an entry of a docstring's section
sys.path.insert(0, str(HERE))

import generate_reference
import playground

from fuzz.player.live import live_core

project = "worldgen"
author = "The worldgen developers"
project_copyright = author
release = version_of("worldgen")
version = release

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
# The notes are for the authors: measurements and history. Other pages include the parts.
exclude_patterns = ["_build", "notes", "reference/generated/parts"]

# Headings get the anchors that they have on code hosts, so that one link works in both places.
myst_heading_anchors = 4
myst_enable_extensions = ["deflist"]
# Many JSON and Python snippets leave lines out with "...", which is not valid in either language.
suppress_warnings = ["misc.highlighting_failure"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"worldgen {release}"
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}


_LINK_OUT = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+(?!pictures/)[^)\s:]+)\)")


def mark_repository_files(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace a page's links to files of the repository by their names; the site has only pages.

    A link to a file that does not exist is left alone, so that Sphinx warns about it.
    """
    folder = (HERE / docname).parent

    def replaced(link: re.Match[str]) -> str:
        text, target = link.groups()
        file = (folder / target.partition("#")[0]).resolve()
        on_the_site = file.is_relative_to(HERE) and not file.is_relative_to(HERE / "notes")
        if on_the_site or not file.exists():
            return link[0]
        name = str(file.relative_to(HERE.parent))
        return f"`{name}`" if text.strip("`") == name else f"{text} (`{name}`)"

    source[0] = _LINK_OUT.sub(replaced, source[0])


_FIGURE = re.compile(
    r"```\{figure\} (?:\.\./)*pictures/([\w-]+)\.png\n(?::.*\n)*\n((?:.+\n)*)```\n"
)
_PICTURE = re.compile(r"!\[([^\]]*)\]\((?:\.\./)*pictures/([\w-]+)\.png\)")


def make_figures_live(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace or follow some pictures by figures of the playground, of which everything can be dragged.

    Without the cores for pages, which take ziglang, the pictures stay.
    """
    if app.builder.format != "html" or live_core() is None:
        return
    root = "../" * docname.count("/")

    def replaced(figure: re.Match[str]) -> str:
        name, caption = figure.groups()
        scene = playground.FIGURES.get(name)
        return f"{playground.frame(scene, name, root)}\n\n{caption}" if scene else figure[0]

    def live(picture: re.Match[str]) -> str:
        words, name = picture.groups()
        if name in playground.FIGURES:
            return playground.frame(playground.FIGURES[name], words, root)
        if name in playground.FOLLOWED:
            scene = playground.FOLLOWED[name]
            return f"{picture[0]}\n\n{playground.frame(scene, f'{scene}, live', root)}"
        return picture[0]

    source[0] = _PICTURE.sub(live, _FIGURE.sub(replaced, source[0]))


def write_playground(app: Sphinx, exception: Exception | None) -> None:
    """Write the playground next to the site's pages."""
    if exception is None and app.builder.format == "html" and live_core() is not None:
        (Path(app.outdir) / playground.NAME).write_bytes(playground.page())


def mend_wrapping(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Undo stray indentation inside a docstring's paragraph, which is not valid markup."""
    if what == "data" and lines and lines[0] in (type(thing).__doc__ or "").splitlines()[:1]:
        lines.clear()  # the docstring of a type such as dict, which explains nothing here
    if name.startswith("worldgen.families.") and "" in lines:
        del lines[lines.index("") :]  # the page about families has the rest
    above = 0
    for at, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if not line.strip() or above >= at or not lines[above].strip():
            above = at
            continue
        base = len(lines[above]) - len(lines[above].lstrip())
        # Sections such as "Args:" and their entries are indented on purpose, up to an empty line.
        below = lines[at + 1] if at + 1 < len(lines) else ""
        returns = bool(below.strip()) and len(below) - len(below.lstrip()) == base
        on_purpose = base == _ENTRY or (lines[above].rstrip().endswith(":") and not returns)
        if indent > base and not on_purpose:
            lines[at] = " " * base + line.lstrip()
        above = at


def skip_named_fields(
    app: Sphinx, what: str, name: str, thing: object, skip: bool, options: object
) -> bool | None:
    """Leave out the fields of named tuples, which their class explains already."""
    return True if str(getattr(thing, "__doc__", "")).startswith("Alias for field") else None


def setup(app: Sphinx) -> None:
    """Write the pages that come from the code before Sphinx looks for pages."""
    generate_reference.write_pages(HERE / "reference" / "generated")
    app.connect("source-read", mark_repository_files)
    app.connect("source-read", make_figures_live)
    app.connect("build-finished", write_playground)
    # Before napoleon reads the sections, which it does at priority 500.
    app.connect("autodoc-process-docstring", mend_wrapping, priority=100)
    app.connect("autodoc-skip-member", skip_named_fields)
