"""``worldgen help``: what verdicts, causes and proofs are, a screen each; or a command's help."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import click

from worldgen.cli.output import say
from worldgen.support.plain_text import joined

EXAMPLES = "\b\n  worldgen help verdicts\n  worldgen help proofs\n  worldgen help fuzz"

PROVED = (
    (
        "The target can be reached",
        "The file holds a witness: a timed path on which the body touches nothing. A checker that "
        "shares no code with the prover accepts it.",
    ),
    (
        "The target is `blocked`",
        "The file holds a cut: a chain of walls, with gaps too narrow for the robot, between start "
        "and target. For a body it can be a set of poses that must overlap a wall.",
    ),
    (
        "`loop`, `deadlock`, `livelock`",
        "The complete state recurred: robot, controller and random numbers. So the run repeats "
        "itself forever.",
    ),
    (
        "`tunnel`, `overlap`, `contact`, `burned`",
        "The recorded path shows it, and a separate check confirms it.",
    ),
    (
        "The same run everywhere",
        "Poses are integers on a lattice (1/1024 of a cell, 1/65536 of a turn).",
    ),
    (
        "A failure is small",
        "Freeing any one cell, row or column loses the failure or its proof. `shrinking` says "
        "`done` if that was checked.",
    ),
)
"""Claims that are proved, and why one can rely on each, in Markdown."""

NOT_PROVED = (
    (
        "`stalled`",
        "The robot entered no new cell in the second half of a budget of 50 times the witness's "
        "time, or 20 times where each step is slow; the record says it. It may arrive later.",
    ),
    ("`timeout`", "The budget ran out."),
    (
        "a campaign that is `clean`",
        "Nothing was found in what was tried. No search proves that a controller never fails.",
    ),
    (
        "the share of natural worlds",
        "An estimate for worldgen's families, with its 95 % interval. Your building may differ.",
    ),
    ("a cause's name and advice", "A description of the motion, and a guess at the mistake."),
    (
        "`undecided`",
        "Neither a path nor a cut was found: a footprint that fits exactly, a car, several robots, "
        "or timed paths.",
    ),
    (
        "a loop of a program, a node, or a robot with noise (`+slip`)",
        "It is `stalled` at most, because its state is hidden or drawn at random. So is a loop of a "
        "class that reads a clock.",
    ),
)
"""Results that are not proved, and what each means, in Markdown."""


@click.command(epilog=EXAMPLES)
@click.argument("topic", required=False)
@click.pass_context
def help(context: click.Context, topic: str | None) -> None:  # noqa: A001 - the command's name
    """Explain verdicts, causes or proofs, or show a command's help.

    TOPIC is one of these three words, or a command. Without it, all commands are listed.
    """
    root = context.find_root()
    if topic in TOPICS:
        formatter = root.make_formatter()
        TOPICS[topic](formatter)
        say(joined(formatter.getvalue().rstrip("\n")))
        return
    if topic is None:
        say(joined(root.get_help()))
        return
    assert isinstance(root.command, click.Group)
    # An unknown word is answered like an unknown command.
    _, command, _ = root.command.resolve_command(root, [topic])
    assert command is not None
    with click.Context(command, parent=root, info_name=topic) as inner:
        say(joined(inner.get_help()))


def _verdicts(formatter: click.HelpFormatter) -> None:
    from sim.verdict import ARRIVALS, FAILURES, MEANINGS

    formatter.write_text("A run ends with a verdict: what happened.")
    _section(formatter, "Success", ((verdict, MEANINGS[verdict]) for verdict in ARRIVALS))
    failures = ((verdict, MEANINGS[verdict]) for verdict in FAILURES)
    _section(formatter, "Failures, if the target can be reached", failures)
    formatter.write_paragraph()
    formatter.write_text("`worldgen help proofs` says how far to rely on each.")


def _causes(formatter: click.HelpFormatter) -> None:
    from fuzz.cause import Cause, Severity

    formatter.write_text(
        "A failure has a cause: what the robot does wrong. The worst come first; `worldgen explain` "
        "says what a failure depends on."
    )
    for severity in Severity:
        causes = ((one, one.sentence) for one in Cause if one.severity == severity)
        _section(formatter, f"It {severity.phrase}".replace("It its", "Its"), causes)


def _proofs(formatter: click.HelpFormatter) -> None:
    formatter.write_text("A result is a claim about a model of your robot.")
    for title, rows in (("Proved", PROVED), ("Not proved", NOT_PROVED)):
        _section(formatter, title, ((name.replace("`", ""), why) for name, why in rows))


def _section(formatter: click.HelpFormatter, title: str, rows: Iterable[tuple[str, str]]) -> None:
    with formatter.section(title):
        formatter.write_dl([(str(name), text) for name, text in rows])


TOPICS: dict[str, Callable[[click.HelpFormatter], None]] = {
    "verdicts": _verdicts,
    "causes": _causes,
    "proofs": _proofs,
}
"""What writes each topic."""
