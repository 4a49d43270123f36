"""Short campaigns, started as by the studio's page."""

import time

HANGS = """
import pathlib, time

class Robot:
    def reset(self):
        return ()

    def act(self, observation, memory):
        pathlib.Path(__file__).with_name("acts").touch()
        while True:
            time.sleep(0.01)
"""
"""A controller that never returns, and writes a file ``acts`` next to it when it is called."""

SHORT = {
    "controller": "turn-right",
    "motion": "swept",
    "strategies": ["trap"],
    "seed": "1",
    "workers": 1,
    "examples": 8,
}


def acts(folder):
    """Wait until the hanging controller in this folder has been called."""
    until = time.monotonic() + 180
    while not (folder / "acts").exists():
        assert time.monotonic() < until, "it was never asked"
        time.sleep(0.05)


def begin(page, folder, **more):
    """Start a campaign; return the server's answer."""
    return page.ask("begin", folder=folder, **(SHORT | more))


def watch(page, folder):
    """Wait until a campaign has stopped; return its state."""
    return page.ask("watch", folder=folder)["answer"]
