"""Short campaigns as the studio's page begins them."""

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
"""A controller that never returns, and a file ``acts`` next to it as soon as it was asked."""

SHORT = {
    "controller": "turn-right",
    "motion": "swept",
    "strategies": ["trap"],
    "seed": "1",
    "workers": 1,
    "examples": 8,
}


def acts(folder):
    """Waits until the controller that hangs was asked; it is in that folder."""
    until = time.monotonic() + 180
    while not (folder / "acts").exists():
        assert time.monotonic() < until, "it was never asked"
        time.sleep(0.05)


def begin(page, folder, **more):
    """Begins a campaign; gives what the server says."""
    return page.ask("begin", folder=folder, **(SHORT | more))


def watch(page, folder):
    """Waits until a campaign stands still; gives its state."""
    return page.ask("watch", folder=folder)["answer"]["state"]
