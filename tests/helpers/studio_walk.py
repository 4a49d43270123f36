"""A walk through the studio, performed as documented.

Real commands, real mouse and keyboard. A document's commands are its ``console`` blocks; its
actions on the page are the sentences of its numbered steps. Each sentence has to be one of
``SENTENCES``: text between stars is a name or words on the page, text between backticks is typed,
and places are in metres. All other text of a document is outside its steps.
"""

import contextlib
import os
import re
import shlex
import signal
import subprocess
import sys

from tests.helpers.studio_page import place

PLACE = r"([\d.]+), ([\d.]+) m"
ROLES = ("button", "link", "tab", "radio", "checkbox")


class NotUnderstood(Exception):
    """A sentence that the walk cannot perform."""


class Walker:
    """Walks through a page."""

    def __init__(self, page):
        self.page = page

    def perform(self, sentence):
        """Perform a sentence."""
        for pattern, act in SENTENCES.items():
            if found := re.fullmatch(pattern, sentence):
                act(self, *found.groups())
                return
        raise NotUnderstood(
            f"{sentence!r}: no sentence that a step may have; say it outside the steps"
        )

    def click(self, role, name):
        roles = (role,) if role else ROLES
        named = [self.page.get_by_role(one, name=_named(name)) for one in roles]
        either = self.page.locator("summary").get_by_text(
            name, exact=True
        )  # the part that opens; it has no role
        for one in named:
            either = either.or_(one)
        either.click()  # more than one is an error

    def click_at(self, x, y):
        self.page.mouse.click(*self.pixel(x, y))

    def drag(self, *numbers):
        self.page.mouse.move(*self.pixel(*numbers[:2]))
        self.page.mouse.down()
        self.page.mouse.move(*self.pixel(*numbers[2:]), steps=8)
        self.page.mouse.up()

    def pixel(self, x, y):
        """Return where a place of the world, in metres, is on the screen."""
        cell = float(self.page.get_by_label("Cell size").first.input_value())
        return place(self.page, float(x) / cell, float(y) / cell)

    def press(self, key):
        self.page.keyboard.press(key.replace("Ctrl", "Control"))

    def type(self, words, name):
        field = self.page.get_by_role("spinbutton", name=name).or_(
            self.page.get_by_role("textbox", name=name)
        )
        field.click()  # which selects the contents of a number's field
        self.page.keyboard.type(words)

    def choose(self, option, name):
        self.page.get_by_role("combobox", name=_named(name)).select_option(option)

    def tick(self, name):
        self.page.get_by_role("checkbox", name=name, exact=True).click()

    def first_failure(self):
        self.page.get_by_role("list", name="Failures").get_by_role("button").first.click()

    def says(self, words):
        whole = re.compile(rf"(?<!\w){re.escape(words)}(?!\w)")  # Done is not Undone
        self.page.get_by_text(whole).locator("visible=true").first.wait_for()


SENTENCES = {
    r"Click (?:the (button|link|tab) )?\*\*(.+)\*\*": Walker.click,
    rf"Click at {PLACE}": Walker.click_at,
    rf"Drag from {PLACE} to {PLACE}": Walker.drag,
    r"Press `(.+)`": Walker.press,
    r"Type `(.+)` into \*\*(.+)\*\*": Walker.type,
    r"Choose `(.+)` in \*\*(.+)\*\*": Walker.choose,
    r"Tick \*\*(.+)\*\*": Walker.tick,
    r"Click the first picture of a failure": Walker.first_failure,
    r"The page says \*(.+)\*": Walker.says,
}


def _named(words):
    """Match an accessible name that begins with these words; a button may add more for screen
    readers.
    """
    return re.compile(f"^{re.escape(words)}(, .*)?$")


def sentences(text):
    """The sentences of the numbered steps, in order, with the step's number."""
    said = []
    for number, body in re.findall(
        r"^(\d+)\. (.*(?:\n {2,}.*)*)", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.M
    ):
        words = " ".join(body.split())
        said += [
            (int(number), one.removesuffix(".")) for one in re.split(r"(?<=\.) (?=[A-Z])", words)
        ]
    return said


def commands(text):
    """The commands of the ``console`` blocks, in order: each with the lines that it prints."""
    given = []
    for block in re.findall(r"```console\n(.*?)```", text, re.DOTALL):
        for line in block.splitlines():
            if line.startswith("$ "):
                given.append((line.removeprefix("$ "), []))
            else:
                given[-1][1].append(line)
    return given


def fits(line, said):
    """Return whether a line matches the document's, in which ``...`` stands for anything."""
    return re.fullmatch(re.escape(line).replace(r"\.\.\.", ".*"), said) is not None


def answered(command, folder):
    """Return what a command of the document prints, line by line."""
    words = shlex.split(command)
    if words[0] == "worldgen":
        words[:1] = [sys.executable, "-m", "worldgen"]
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, timeout=120, check=True
    )
    return done.stdout.splitlines()


@contextlib.contextmanager
def begun(command, folder):
    """Start the studio by its command, with a browser that opens nothing.

    Yield the address that it prints.
    """
    words = [sys.executable, "-m", "worldgen", *shlex.split(command)[1:]]
    environment = os.environ | {"BROWSER": "true"}
    with subprocess.Popen(
        words, cwd=folder, stderr=subprocess.PIPE, text=True, env=environment
    ) as server:
        try:
            for line in server.stderr:
                if found := re.search(r"http://\S+", line):
                    yield found[0]
                    break
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(timeout=20)
