"""Text as a stranger writes it to take over a terminal, a log or a page, and what it may become."""

import os
import pty
import re
import select
import sys

from worldgen.cli.main import main

MARK = "OWNED"
# Sets the clipboard, clears the screen, sets the title, colours; C1's own CSI; reorders and hides
# text; forges lines and the commands of CI services.
TEXT = (
    "x\x1b]52;c;T1dORUQ=\x07\x1b[2J\x1b]0;title\x07\x1b[35;7;9mred\x9b31m\x85\u202e\u2066\u200b"
    f"\ufeff\u3164[red]b\x08\r\n::error::{MARK}\n  ::set-output::{MARK}\n##[error]{MARK}"
    f"\n##vso[task.complete]{MARK}\x7f</script><img src=x>"
)
# The same as a file's name, which cannot hold a slash.
NAME = TEXT.replace("/", "|")[:180]
_OURS = re.compile(r"\x1b\[[0-9;]*m|\r\x1b\[K")
_FOREIGN_STYLE = "\x1b[35;7;9m"


def faults(output: str) -> list[str]:
    """Return what of the stranger's text reached a terminal as it was."""
    found = ["its style"] if _FOREIGN_STYLE in output else []
    plain = _OURS.sub("", output).replace("\r\n", "\n")
    strange = {
        sign
        for sign in plain
        if not (sign.isprintable() and sign != "\u3164") and sign not in "\n\t"
    }
    found += [f"{sign!r}" for sign in sorted(strange)]
    found += [
        f"a line {line.strip()[:60]!r}"
        for line in plain.split("\n")
        if line.lstrip().startswith("::") or re.search(r"##(vso|teamcity)?\[", line)
    ]
    # Our lines never begin with the mark: a line break of the stranger's came through.
    return found + [f"a line {line[:60]!r}" for line in plain.split("\n") if line.startswith(MARK)]


def on_a_terminal(*args: object, folder: str, columns: int = 200) -> tuple[int, str]:
    """Run ``worldgen ARGS`` on a terminal, in a child of this process; return code and output.

    The child has everything imported already, so this takes milliseconds.
    """
    sys.stdout.flush()
    child, terminal = pty.fork()
    if child == 0:
        _be_worldgen([str(arg) for arg in args], folder, columns)
    output = b""
    while True:
        if not select.select([terminal], [], [], 240)[0]:
            os.kill(child, 9)
            break
        try:
            part = os.read(terminal, 1 << 16)
        # Linux reports the end of a terminal this way.
        except OSError:
            break
        if not part:
            break
        output += part
    os.close(terminal)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), output.decode("utf-8", "surrogateescape")


def _be_worldgen(args: list[str], folder: str, columns: int) -> None:
    """Replace this process by the command line."""
    code = 70
    try:
        os.chdir(folder)
        os.environ.update(COLUMNS=str(columns), TERM="xterm", FORCE_COLOR="1")
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
        sys.argv = ["worldgen", *args]
        main()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 0
    finally:
        sys.stdout.flush()
        os._exit(code)
