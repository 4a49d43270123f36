"""Serves a Python controller as a program: ``python -m sim.host ./mine.py:Robot``.

Behind ``cmd:`` it gives a Python class what a program has: a deadline for each step, a memory
limit, a process of its own. A class that hangs is then a ``hang``, where in our own process it
would hang us; its loops are no longer proved.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from typing import Any, BinaryIO

from sim.controllers import (
    CONTROLLERS,
    Command,
    CompiledController,
    Observation,
    ProcessController,
    PythonController,
    VectorController,
)
from sim.controllers.base import wants_world
from sim.controllers.contract import ContractBroken, no_memory
from sim.controllers.vector import OneOfMany
from worldgen.errors import InvalidParameter, WorldgenError

__all__ = ["serve"]


def serve(controller: PythonController, lines: BinaryIO, answers: BinaryIO) -> None:
    """Answers observations until there are no more.

    Args:
        controller: Whoever raises ends this process, as a program that crashes.
        lines: The protocol's lines.
        answers: Where the commands go; what the controller prints goes to stderr.
    """
    memory: tuple[float, ...] = ()
    with contextlib.redirect_stdout(sys.stderr):
        for line in lines:
            message = json.loads(line)
            if "reset" in message:
                memory = controller.reset()
                continue
            answer = controller.act(_observation(message), memory)
            try:
                command, memory = answer
            except (TypeError, ValueError):
                raise no_memory(answer) from None
            answers.write(_answer(Command(*command)))
            answers.flush()


def _observation(message: dict[str, Any]) -> Observation:
    seen: dict[str, Any] = {
        name: tuple(item) if isinstance(item, list) else item for name, item in message.items()
    }
    return Observation(**seen)


def _answer(command: Command) -> bytes:
    """As it is, nan and infinity included: what is wrong with it, the reader says."""
    answer: dict[str, Any] = {"speed": float(command.speed), "turn_rate": float(command.turn_rate)}
    if command.used_random:
        answer["used_random"] = True
    return json.dumps(answer).encode() + b"\n"


def _load(arguments: list[str]) -> PythonController:
    if len(arguments) != 1:
        raise InvalidParameter(
            "wrong-arguments",
            "python -m sim.host takes one controller, such as ./mine.py:Robot, not {arguments}",
            arguments=arguments,
        )
    found = CONTROLLERS.get(arguments[0])
    if isinstance(found, CompiledController | ProcessController):
        raise InvalidParameter(
            "not-a-python-class",
            "{controller} is no Python class",
            "give it to --controller as it is",
            at_terminal=True,
            controller=arguments[0],
        )
    if wants_world(found):
        raise InvalidParameter(
            "plans-with-the-world",
            "{controller} plans with the world, which a program is not told",
            "give it to --controller as it is",
            at_terminal=True,
            controller=arguments[0],
        )
    return OneOfMany(found) if isinstance(found, VectorController) else found


def main() -> None:
    """Serves the controller that the command line names, in version 1 of the protocol."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        with contextlib.redirect_stdout(sys.stderr):
            controller = _load(sys.argv[1:])
    except WorldgenError as error:
        sys.exit(f"sim.host: {error}")
    try:
        serve(controller, sys.stdin.buffer, answers)
    except ContractBroken as broken:
        sys.exit(
            f"sim.host: {broken.error}, it was {broken.evidence.answer}; {broken.evidence.remedy}"
        )


if __name__ == "__main__":
    main()
