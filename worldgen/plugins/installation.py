"""Find where this copy of worldgen was installed from, for messages and CI files."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import dataclass
from importlib.metadata import distributions
from pathlib import Path
from urllib.parse import unquote, urlsplit

_GITHUB = re.compile(r"https://github\.com/([\w.-]+/[\w.-]+?)(?:\.git)?/?")


@dataclass(frozen=True)
class Origin:
    """Describe where an installed distribution came from.

    Args:
        url: URL of a repository, an archive or a folder; empty for a package index.
        commit: Commit of the repository; empty for anything else.
        folder: The folder it was installed from, if that still exists.
        editable: True if Python runs the code in the folder itself (``pip install -e``).
    """

    url: str = ""
    commit: str = ""
    folder: Path | None = None
    editable: bool = False

    @property
    def github(self) -> str:
        """Return ``owner/name`` of a repository on GitHub, or an empty string."""
        found = _GITHUB.fullmatch(self.url) if self.commit else None
        return found[1] if found else ""


def origin() -> Origin:
    """Return where the installed worldgen came from.

    Source: PEP 610, "Recording the Direct URL Origin of installed distributions".
    """
    try:
        # A checkout on the path may have its own metadata, which lacks this record. Take the first
        # distribution that has one.
        texts = [found.read_text("direct_url.json") for found in distributions(name="worldgen")]
        record = json.loads(next(filter(None, texts), "{}"))
        url = str(record.get("url", ""))
        if "vcs_info" in record:
            return Origin(url, str(record["vcs_info"].get("commit_id", "")))
        if "dir_info" in record:
            folder = Path(unquote(urlsplit(url).path))
            editable = record["dir_info"].get("editable") is True
            return Origin(url, folder=folder if folder.is_dir() else None, editable=editable)
    except (OSError, ValueError, AttributeError, TypeError):
        return Origin()
    return Origin(url)


def requirement(extra: str = "") -> str:
    """Return the requirement that makes pip install this worldgen again.

    worldgen may come from a package index, a repository or a checkout. With a plain
    ``worldgen[studio]``, pip would look only in the index, which may not contain worldgen.

    Args:
        extra: Name of an extra, such as ``studio``; no extra if omitted.
    """
    extras = f"[{extra}]" if extra else ""
    found = origin()
    if found.folder is not None:
        return f"{found.folder}{extras}"
    if found.commit:
        return f"worldgen{extras} @ git+{found.url}@{found.commit}"
    if found.url and not found.url.startswith("file:"):
        return f"worldgen{extras} @ {found.url}"
    return f"worldgen{extras}"


def pip_install(extra: str) -> str:
    """Return the command that adds an extra to this installation, to be pasted into a shell."""
    return f"pip install {'-e ' if origin().editable else ''}{shlex.quote(requirement(extra))}"
