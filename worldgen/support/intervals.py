"""Confidence intervals of proportions."""

from __future__ import annotations


def interval_95(count: int, total: int) -> tuple[float, float]:
    """Return the two-sided 95 % interval of a probability observed as ``count`` out of ``total``.

    Source: Charles Clopper and Egon Pearson, "The use of confidence or fiducial limits illustrated
        in the
    case of the binomial", Biometrika 1934.
    """
    from scipy.special import betaincinv  # noqa: PLC0415 - it takes longer to load than most commands to run

    low = float(betaincinv(count, total - count + 1, 0.025)) if count else 0.0
    high = float(betaincinv(count + 1, total - count, 0.975)) if count < total else 1.0
    return low, high
