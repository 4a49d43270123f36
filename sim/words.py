"""Verdicts in words."""

from __future__ import annotations

from collections.abc import Mapping

from sim.episode import Episode
from sim.outcome import BY_THE_CONTROLLER
from worldgen.world import Value

__all__ = ["evidence_in_words", "frames_in_words"]


def evidence_in_words(episode: Episode) -> str:
    """What the evidence says, to stand behind the verdict; starts with a blank, or is empty."""
    evidence = episode.evidence
    verdict = episode.verdict
    if verdict == "loop":
        period = evidence["period"]
        often = "in every step" if period == 1 else f"every {period} steps"
        return f" for ever (the state after step {evidence['entry']} comes back {often})"
    if verdict in ("tunnel", "overlap") and "cell" in evidence:
        since = f", since a {evidence['cause']} in step {evidence['since']}" if "cause" in evidence else ""
        return f" (step {evidence['step']}, wall cell {tuple(_list(evidence['cell']))}{since})"
    if verdict == "burned":
        cause = "fire" if evidence.get("state") == "burning" else "debris"
        return f" ({cause} in step {evidence['step']}, cell {tuple(_list(evidence['cell']))})"
    if verdict == "stalled":
        seen = f"no new cell after step {evidence['last_new_cell']} of {episode.steps}"
        return f" ({_manner(episode)}{seen}{_multiple(episode)})"
    if verdict == "timeout":
        return f" (still reaching new cells when its {episode.steps} steps were over{_multiple(episode)})"
    if verdict in BY_THE_CONTROLLER:
        return f" ({_fault(episode)})"
    return ""


def frames_in_words(evidence: Mapping[str, Value]) -> str:
    """Return where a controller crashed, a line such as ``  mine.py:12 in act: gap = 1 / free`` for each frame.

    The innermost frame comes last, as in Python's tracebacks; each line ends with a newline.
    """
    frames = evidence.get("frames")
    known = [frame for frame in frames if isinstance(frame, dict)] if isinstance(frames, list) else []
    return "".join(f"  {_frame(frame)}\n" for frame in known)


def _frame(frame: Mapping[str, Value]) -> str:
    line = f":{frame['line']}" if "line" in frame else ""
    place = f"{frame.get('file', '')}{line}"
    inside = f"in {frame['function']}" if "function" in frame else ""
    code = f": {frame['code']}" if "code" in frame else ""
    return f"{place}{' ' if place and inside else ''}{inside}{code}"


def _multiple(episode: Episode) -> str:
    """The budget in times of the witness, with a comma before it; empty where there is none."""
    multiple = episode.evidence.get("witness_multiple")
    return "" if multiple is None else f", {multiple} times the witness's time"


def _fault(episode: Episode) -> str:
    """What the controller did wrong, with a program's last line on stderr."""
    evidence = episode.evidence
    within = f" within {evidence['deadline']} s" if "deadline" in evidence else ""
    where = f" in step {evidence['step']}" if episode.verdict != "crash" or "stderr" in evidence else ""
    answer = f", answer {evidence['answer']!r}" if "answer" in evidence else ""
    partly = f", but {evidence['unfinished']!r} without newline" if "unfinished" in evidence else ""
    last = _list(evidence.get("stderr"))
    said = f"; stderr: {last[-1]}" if last else ""
    flush = "; does it flush its output?" if episode.verdict == "hang" and evidence["step"] == 1 else ""
    error = evidence.get("error", "speed or turn rate is no finite number")  # that is all that the core judges
    at = f", {evidence['at']}" if "at" in evidence else ""
    remedy = f"; {evidence['remedy']}" if "remedy" in evidence else ""
    return f"{error}{at}{within}{where}{answer}{partly}{said}{flush}{remedy}"


def _manner(episode: Episode) -> str:
    """In what manner a run stalls, with a comma behind it; empty where that is not known."""
    evidence = episode.evidence
    if "kind" not in evidence:
        return ""
    columns, rows = _list(evidence["box"])
    how = f"drifting every {evidence['period']} steps in" if evidence["kind"] == "drifting" else "confined to"
    return f"{how} {columns} x {rows} cells, "


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else []
