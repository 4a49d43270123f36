"""``worldgen check-family``: check that a family keeps the promises of every family."""

from __future__ import annotations

import click

from worldgen.cli.output import emit_json, json_option, say

EXAMPLES = (
    "\b\n  worldgen check-family warehouse\n  worldgen check-family ./mine.py:my_family\n"
    "  worldgen check-family ./mine.py:hall --except different-seeds-give-different-worlds"
)


@click.command("check-family", epilog=EXAMPLES)
@click.argument("name")
@click.option(
    "--except", "left_out", metavar="CHECK", multiple=True, help="Skip a check; may be repeated."
)
@click.option(
    "--digests", is_flag=True, help="Print the digest of seed 7 of each case, to pin it in a test."
)
@json_option
def check_family(name: str, left_out: tuple[str, ...], digests: bool, as_json: bool) -> None:
    """Check that your own family keeps the promises that every family makes.

    NAME is a registered family, ./file.py:name or package.module:name. If a
    parameter has a fixed set of words, each word of the first such parameter is a case. Exit code 1
    means that a promise is broken.
    """
    from worldgen import testing
    from worldgen.errors import InvalidParameter
    from worldgen.family import FAMILIES
    from worldgen.support.progress import working

    # Refuse names of checks that do not exist.
    known = [check.name for check in (*testing.FAMILY_CHECKS, *testing.CHECKS)]
    for word in left_out:
        if word not in known:
            raise InvalidParameter(
                "unknown-name",
                "except {name}: there is no such check",
                "known: {known!l}",
                name=word,
                known=known,
            )
    # Run the checks.
    family = FAMILIES.get(name)
    pinned = {}
    results = []
    with working(f"checking {name}") as work:
        if digests:
            for case in testing.family_cases(family):
                pinned[str(next(iter(case.values()), ""))] = testing.layout_digest(family, case)
        for found in testing.run_checks(family, without=left_out):
            results.append(found)
            work.count(len(results), noun="checks done")
    # Print the broken promises and the digests.
    broken = [found for found in results if found.fault]
    if as_json:
        checks = [
            {"check": found.check, "case": found.case, "fault": found.fault or None}
            for found in results
        ]
        emit_json(
            {"family": family.name, "version": family.version, "checks": checks, "digests": pinned}
        )
    else:
        for found in broken:
            say(f"BROKEN {testing.shown(found)}")
        for key, digest in pinned.items():
            say(f'"{key}": "{digest}",')
        say(
            f"{family.name} version {family.version}: {len(results) - len(broken)} of "
            f"{len(results)} checks hold"
        )
    if broken:
        raise click.exceptions.Exit(1)
