"""Play the changes of a Gazebo world that worldgen wrote.

Cells become solid, free or burning. NAME_player.py is next to NAME.sdf and NAME_events.json. Start
Gazebo paused, and then the player:

    ign gazebo NAME.sdf        (Fortress; gz sim NAME.sdf from Garden on)
    python NAME_player.py

It runs the world to the time of a change, moves the models while time is stopped, and continues, so
every change happens at its own simulated time no matter how long the commands take. It needs only
the standard library and Gazebo's own command. Ctrl-C ends it; Gazebo is then paused until it is
told to continue.
"""

from __future__ import annotations

import itertools
import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

_TOO_LONG = 20_000  # characters of one request; a command line has room for six times that
_PATIENCE = 5000  # ms for the answer to a request
_SILENCE = 10  # s without a message about the time; Gazebo sends several per second


def _table() -> dict[str, Any]:
    here = Path(__file__)
    name = here.name.removesuffix("_player.py") + "_events.json"
    table: dict[str, Any] = json.loads(here.with_name(name).read_text(encoding="utf-8"))
    return table


class Gazebo:
    """A running Gazebo, controlled by its command: ``gz``, or ``ign`` up to Fortress."""

    def __init__(self, world: str) -> None:
        found = next((name for name in ("gz", "ign") if shutil.which(name)), None)
        if found is None:
            sys.exit("neither gz nor ign is on PATH; install Gazebo's command-line tools")
        self._command = found
        self._world = f"/world/{world}"
        self._messages = "gz.msgs" if found == "gz" else "ignition.msgs"

    def _ask(self, service: str, kind: str, request: str) -> None:
        words = [
            self._command, "service", "-s", f"{self._world}/{service}", "--reqtype", f"{self._messages}.{kind}",
            "--reptype", f"{self._messages}.Boolean", "--timeout", str(_PATIENCE), "--req", request,
        ]  # fmt: skip
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if "data: true" not in done.stdout:
            said = (done.stdout + done.stderr).strip() or "no answer"
            sys.exit(f"{self._world}/{service} refused: {said}; is Gazebo running this world?")

    def run_to(self, until: float) -> None:
        """Run to a simulated time, s, and pause there."""
        seconds, rest = divmod(round(until * 10**9), 10**9)
        self._ask("control", "WorldControl", f"run_to_sim_time {{ sec: {seconds} nsec: {rest} }}")
        while self.time() < until - 1e-9:
            time.sleep(0.01)

    def go_on(self) -> None:
        """Resume time."""
        self._ask("control", "WorldControl", "pause: false")

    def time(self) -> float:
        """Return the simulated time, s."""
        words = [self._command, "topic", "-e", "-n", "1", "-t", f"{self._world}/stats"]
        try:
            said = subprocess.run(
                words, capture_output=True, text=True, check=False, timeout=_SILENCE
            ).stdout
        except subprocess.TimeoutExpired:
            sys.exit(f"{self._world}/stats does not send anything; is Gazebo running this world?")
        block = re.search(r"sim_time\s*\{([^}]*)\}", said)
        numbers = dict(re.findall(r"(sec|nsec):\s*(\d+)", block[1] if block else ""))
        return int(numbers.get("sec", 0)) + int(numbers.get("nsec", 0)) / 10**9

    def place(self, poses: dict[str, tuple[float, float, float]]) -> None:
        """Move models: by name, x, y, z of their centres, m."""
        texts = [
            f'pose {{ name: "{name}" position {{ x: {x!r} y: {y!r} z: {z!r} }} orientation {{ w: 1 '
            f"}} }} "
            for name, (x, y, z) in poses.items()
        ]
        while texts:
            count = max(
                1, sum(1 for total in itertools.accumulate(map(len, texts)) if total <= _TOO_LONG)
            )
            self._ask("set_pose_vector", "Pose_V", "".join(texts[:count]))
            texts = texts[count:]


def main() -> None:
    """Play all remaining changes, then let the world continue."""
    table = _table()
    gazebo = Gazebo(table["world"])
    now = gazebo.time()
    for when, group in itertools.groupby(table["events"], key=lambda event: float(event[0])):
        if when > now:
            gazebo.run_to(when)
        poses = {
            name: (float(x), float(y), float(z))
            for _, name, z in group
            for x, y in [table["bodies"][name]]
        }
        gazebo.place(poses)
        sys.stderr.write(f"{when:g} s: {', '.join(poses)}"[:120] + "\n")
    gazebo.go_on()


if __name__ == "__main__":
    main()
