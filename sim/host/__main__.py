"""Serve a Python controller as a program: ``python -m sim.host ./mine.py:Robot``.

Through ``cmd:``, a Python class runs like a program: in its own process, with a deadline for each
step and a memory limit. A class that never returns is then reported as a ``hang`` and no longer
blocks the simulator. In return, its loops can no longer be proved.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any, BinaryIO

from sim.controllers.base import (
    Command,
    CompiledController,
    Neighbour,
    Observation,
    PythonController,
    VectorController,
    wants_world,
)
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.contract import ContractBroken, no_memory
from sim.controllers.programs.process import ProcessController
from sim.controllers.vector import OneOfMany
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.support.results import only_results_on_stdout


def serve(controller: PythonController, lines: BinaryIO, answers: BinaryIO) -> None:
    """Answer observations until there are no more.

    Args:
        controller: The controller. An exception that it raises ends this process, as a crash
            would end any program.
        lines: The protocol's messages, one per line.
        answers: Receives the commands. Anything that the controller prints goes to stderr instead.
    """
    memory: tuple[float, ...] = ()
    with only_results_on_stdout():
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
    neighbours = tuple(
        Neighbour(**{**one, "message": tuple(one["message"])}) for one in seen.pop("neighbours", ())
    )
    return Observation(**seen, neighbours=neighbours)


def _answer(command: Command) -> bytes:
    """Encode a command unchanged, including nan and infinity; the reader judges it."""
    answer: dict[str, Any] = {"speed": float(command.speed), "turn_rate": float(command.turn_rate)}
    if command.used_random:
        answer["used_random"] = True
    if command.message:
        answer["message"] = [float(number) for number in command.message]
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
            "{controller} is not a Python class",
            "pass it to --controller unchanged",
            at_terminal=True,
            controller=arguments[0],
        )
    if wants_world(found):
        raise InvalidParameter(
            "plans-with-the-world",
            "{controller} plans with the world, which is not sent to programs",
            "pass it to --controller unchanged",
            at_terminal=True,
            controller=arguments[0],
        )
    return OneOfMany(found) if isinstance(found, VectorController) else found


def main() -> None:
    """Serve the controller named on the command line, in version 1 of the protocol."""
    # Keep the real stdout for answers; whatever else writes to stdout now reaches stderr.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    try:
        with only_results_on_stdout():
            controller = _load(sys.argv[1:])
    except WorldgenError as error:
        sys.exit(f"sim.host: {error}")
    try:
        serve(controller, sys.stdin.buffer, answers)
    except ContractBroken as broken:
        sys.exit(f"sim.host: {broken.error}: {broken.evidence.answer}; {broken.evidence.remedy}")


if __name__ == "__main__":
    main()
