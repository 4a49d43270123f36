"""What the loops ask of a controller, answered for each kind: how it begins, acts and fails.

No loop looks at a controller's class. It gets the controller's host from :func:`host_of`, and knows
only whether the core calls the controller, or else stops wherever it must act.
"""

from __future__ import annotations

import copy
import re
from bdb import BdbQuit
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from types import SimpleNamespace, TracebackType
from typing import Any

import numpy as np

from sim._core import ffi
from sim.clock.controller_time import count_differences, timed
from sim.clock.stopping import OutOfTime, breakable, in_time
from sim.controllers.answers import AnswersDiffer
from sim.controllers.base import CompiledController, Memory, VectorController, wants_world
from sim.controllers.catalogue.renewal import has_shared_state_changed, renew_and_reset
from sim.controllers.contract import flat_memory
from sim.controllers.controller_error import ControllerError
from sim.controllers.core_act import CoreAct, controller_error_of
from sim.controllers.crash_frames import crash_facts, crash_text
from sim.controllers.frozen_time import FrozenTime
from sim.controllers.hidden_state import HiddenState, hidden_state
from sim.controllers.instances import origin_of
from sim.controllers.programs.process import ProcessController
from sim.controllers.programs.program import WantsMemory
from sim.controllers.timeline_reads import world_to_read
from sim.controllers.vector import Asker
from sim.options.run import RunOptions
from sim.runners.core_calls import Driver, Workspace
from sim.runners.python_act import Stops, act_in_core
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter
from worldgen.plugins.user_modules import without_private_names
from worldgen.world import World

# Characters of a controller's exception that are kept.
_LONGEST_ERROR = 500


class ControllerHost:
    """The host of a Python object that acts for one robot, and the answers of any other kind.

    Attributes:
        controller: The controller; a new instance once runs have left something in the given one.
        plans: Whether its ``reset`` takes the world.
        in_core: Whether the core calls it; if not, a run stops wherever it must act.
        in_python: Whether its code runs in this process's Python, where its time is measured and a
            step can be interrupted.
        acts_for_many: Whether one call acts for many robots.
        shows_memory: Whether its memory can be seen, so that its loops can be found.
        start_speed: Speed during the first step, m/s.
        thesis_rule: See :class:`~sim.controllers.base.CompiledController`.
        sources: What it read in its last run with frozen time, or in the last that was watched, that
            differs from run to run.
        has_read_clock: Whether a step of that run read a clock, or made a generator without a seed.
        has_read_real: Whether a step of a run that proves a loop read a real clock, or the system's
            chance, from a place that cannot be frozen.
    """

    in_core = False
    in_python = True
    acts_for_many = False
    shows_memory = True
    start_speed = 0.0
    thesis_rule = 0

    def __init__(self, controller: Any) -> None:
        self.controller = controller
        self._frozen: FrozenTime | None = None
        self.sources: tuple[str, ...] = ()
        # Whether the latest run would have left no state, if its answers were reused.
        self._unchanged: bool | None = None
        self.has_read_clock = False
        self.has_read_real = False
        self.plans = not self.acts_for_many and wants_world(controller)

    def start(self) -> None:
        """Make sure that it can run; what this raises is not a fault of the controller."""

    def check(self, options: RunOptions) -> None:
        """Refuse options that cannot work with such a controller.

        Raises:
            InvalidParameter: If its time is to be frozen, and it isn't a Python class that acts for
                one robot. Compiled code reads no clock.
        """
        in_reach = self.in_core or (self.in_python and not self.acts_for_many)
        if options.frozen_time and not in_reach:
            raise InvalidParameter(
                "not-in-python",
                "frozen_time reaches only a Python class with act, and this controller is {what}",
                "leave +frozen_time out",
                what="a class with act_many" if self.acts_for_many else "a program",
            )

    @contextmanager
    def freezing(
        self, options: RunOptions, seed: int | None = None, *, watches: int | None = None
    ) -> Iterator[None]:
        """Let it see simulated time and seeded chance in this block, if the run's options say so.

        Args:
            options: Options of the run.
            seed: The run's seed, if it isn't the options'.
            watches: Number of steps after which to note in any case whether a step reads a clock,
                wherever it has it from; ``None`` if nobody needs to know.
        """
        is_watched = watches is not None and self.in_python and not self.acts_for_many
        if not (options.frozen_time or is_watched):
            yield
            return
        self._frozen = FrozenTime(
            options.seed if seed is None else seed,
            options.time_step,
            only_watches=not options.frozen_time,
            proves=watches if is_watched else None,
        )
        try:
            with self._frozen.run(self.controller):
                yield
        finally:
            self.sources = self._frozen.sources
            self.has_read_clock = self._frozen.was_read
            self.has_read_real = bool(self._frozen.out_of_reach)
            if options.frozen_time:
                count_differences(self._frozen.out_of_reach)
            self._frozen = None

    def begin(self, world: World | None, *, renew: bool = True) -> Memory:
        """Reset it for a run, and return its memory; call this inside :class:`Faults`.

        Args:
            world: The world of the run, for a controller that plans.
            renew: Whether to use a new instance if earlier runs have left something in this one.
        """
        shown = world if self.plans else None
        self._unchanged = None
        if self._frozen is not None and not self._frozen.only_watches:
            # Generators that ``__init__`` makes begin again with each run.
            origin = origin_of(self.controller)
            if origin is not None:
                self.controller = self._frozen.seen_by(origin.another)()
            memory: Memory = self._frozen.seen_by(_memory_at_start)(self.controller, shown)
            return memory
        if not renew:
            return _memory_at_start(self.controller, shown)
        self.controller, memory = renew_and_reset(
            self.controller, lambda one: _memory_at_start(one, shown), plans=shown is not None
        )
        return memory

    def hidden(self) -> HiddenState | None:
        """Return the state outside its memory, right after :meth:`begin`.

        ``None`` if not all of it can be seen, or earlier runs have changed it.
        """
        # A clock is a state, too. Its runs with one robot are compared by another clock instead.
        if self._frozen is not None and self._frozen.was_read:
            return None
        state = hidden_state(self.controller)
        return None if has_shared_state_changed(self.controller, state) else state

    def is_unchanged(self, begun: HiddenState) -> bool:
        """Return True if a run has left its state outside its memory as it was.

        Args:
            begun: That state, from :meth:`hidden`.
        """
        if self._unchanged is not None:
            return self._unchanged
        return hidden_state(self.controller) == begun

    def driver(self, memory: Memory, settings: Any) -> Driver:
        """Return it in the form in which the core calls it.

        Args:
            memory: Its memory, from :meth:`begin`.
            settings: WgSettings of the run.
        """
        return Driver(None, memory, settings)

    def drive(self, stops: Stops, memory: Memory) -> Memory:
        """Let it act wherever a run stops, and return its memory after the last step.

        Answers of a slow class are reused where they are known. A watched run proves a loop, so it
        reuses only what such a run has computed.

        Args:
            stops: The run.
            memory: Its memory, from :meth:`begin`.

        Raises:
            AnswersDiffer: If the run must be repeated.
        """
        frozen = self._frozen
        proves = frozen is not None and frozen.only_watches
        # Simulated time shows which step it is, and is the same in no two.
        is_reusable = self.in_python and (frozen is None or proves)

        def drive(act: Callable[..., Any], *, is_measured: bool) -> Memory:
            with nullcontext() if frozen is None else frozen.watching():
                return act_in_core(act, stops, memory, is_measured=is_measured)

        origin = origin_of(self.controller) if is_reusable else None
        if origin is None or origin.answers.is_off:
            act = self.act if frozen is None else frozen.seen_in_time(self.act)
            return drive(act, is_measured=self.in_python)
        try:
            after, self._unchanged = origin.answers.lend(
                self.controller,
                partial(drive, is_measured=False),
                proved_if=(lambda: not frozen.was_read) if frozen is not None else None,
            )
            return after
        except AnswersDiffer:
            # The next run must begin as this one did; the object itself is renewed then.
            kind = type(self.controller)
            if origin.loaded is not None and not origin.loaded.is_current(kind):
                origin.loaded.restore(kind)
            raise

    @property
    def act(self) -> Callable[..., Any]:
        """Its method, which sees simulated time if the run freezes it."""
        act: Callable[..., Any] = self.controller.act
        return act if self._frozen is None else self._frozen.seen_by(act, is_step=True)

    def fault_of(self, error: Any) -> ControllerError:
        """Return the fault that the core reports as ``WgCommand.error``."""
        act = self.controller.act
        if isinstance(act, CoreAct):
            return act.fault_of(error)
        return controller_error_of(ffi.string(error).decode("utf-8", "replace"))

    def another(self) -> ControllerHost:
        """Return the host for another robot of a fleet, which must share nothing with this one."""
        # Earlier runs may have left something in an instance, so a new one is better than a copy.
        if (origin := origin_of(self.controller)) is not None:
            return host_of(origin.another())
        try:
            return host_of(copy.deepcopy(self.controller))
        except Exception:  # noqa: BLE001 - an object that cannot be copied is shared
            return self


class CoreHost(ControllerHost):
    """The host of a compiled controller."""

    in_core = True
    in_python = False

    def __init__(self, controller: CompiledController) -> None:
        super().__init__(controller)
        self._memory = controller.memory
        self.start_speed = controller.start_speed
        self.thesis_rule = controller.thesis_rule

    def begin(self, world: World | None, *, renew: bool = True) -> Memory:
        """Return its memory at reset."""
        return self._memory

    def hidden(self) -> HiddenState:
        """Return nothing: all of its state is in its memory."""
        return HiddenState(b"", b"", b"")

    def driver(self, memory: Memory, settings: Any) -> Driver:
        """Return its function with its memory."""
        return Driver(self.controller, memory, settings)

    def another(self) -> ControllerHost:
        """Return this host, which has no state."""
        return self


class ManyHost(ControllerHost):
    """The host of a Python object that acts for many robots in one call."""

    acts_for_many = True

    def drive(self, stops: Stops, memory: Memory) -> Memory:
        """Let it act for the only robot, whose memory the core keeps."""
        workspace = Workspace(stops.episode, with_goal=True)
        seen = workspace.observation[np.newaxis]
        kept = workspace.memory[np.newaxis]
        after = kept.copy()
        asker = Asker(self.controller, seen, kept, workspace.command[np.newaxis])
        for _ in in_time(stops):
            asker.ask(1, after)
            kept[...] = after
        return memory

    def another(self) -> ControllerHost:
        """Return this host: it acts for all its robots in one call."""
        return self


class ProgramHost(ControllerHost):
    """The host of a program. The code that waits for its answers measures their time."""

    in_python = False
    shows_memory = False

    def start(self) -> None:
        """Start the program; if that is impossible, it has not crashed."""
        self.controller.start()

    def hidden(self) -> None:
        """Return ``None``: its state cannot be seen."""

    def another(self) -> ControllerHost:
        """Return the host of another process of the program."""
        return host_of(self.controller.another())


class OutsideHost(ControllerHost):
    """The host of nobody: the commands of an environment's robots are its actions.

    Args:
        senses: The senses that the core computes.
    """

    def __init__(self, senses: tuple[str, ...]) -> None:
        super().__init__(SimpleNamespace(senses=senses))

    def another(self) -> ControllerHost:
        """Return this host, which has no state."""
        return self


def host_of(controller: Any) -> ControllerHost:
    """Return the host of a controller; a host itself is returned unchanged."""
    if isinstance(controller, ControllerHost):
        return controller
    if isinstance(controller, CompiledController):
        return CoreHost(controller)
    if isinstance(controller, ProcessController):
        return ProgramHost(controller)
    return (ManyHost if isinstance(controller, VectorController) else ControllerHost)(controller)


class Faults:
    """A block in which a controller acts: whatever it raises becomes a :class:`ControllerError`.

    Even SystemExit does. Ctrl-C, leaving the debugger, the end of the time, a run that must be
    repeated and a program that cannot start within its memory limit say nothing about the
    controller, and pass.

    Args:
        host: The host of the controller.
    """

    def __init__(self, host: ControllerHost) -> None:
        self._host = host

    def __enter__(self) -> None:
        pass

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        if error is None or isinstance(
            error, AnswersDiffer | ControllerError | KeyboardInterrupt | OutOfTime | WantsMemory
        ):
            return
        if isinstance(error, BdbQuit):
            raise KeyboardInterrupt from None
        name = type(error).__name__
        facts = {"exception": _in_short(name), **crash_facts(error, self._host.controller)}
        raise ControllerError(Verdict.CRASH, _in_short(crash_text(error)), facts) from error


def _in_short(text: str) -> str:
    """Return a text on one line, and in every run the same: addresses differ from run to run."""
    text = re.sub(r"0x[0-9a-fA-F]+", "0x...", " ".join(without_private_names(text).split()))
    return text[:_LONGEST_ERROR].encode("utf-8", "replace").decode()


@breakable
def _memory_at_start(controller: Any, world: World | None) -> Memory:
    """Reset a controller and return its memory as floats.

    Args:
        controller: The controller.
        world: The world of the episode, for a controller that plans; it is passed without its
            certificate, which contains a solution.

    Raises:
        TypeError: If the memory is not a tuple of numbers.
    """
    if world is None:
        return flat_memory(timed(controller.reset)())
    return flat_memory(timed(controller.reset)(world_to_read(world.bare)))
