"""Text in pictures: its size, how wide it is, and lengths in words."""

from __future__ import annotations

import math

# Size of running text, units.
TEXT_SIZE = 12.5


def text_width(text: str, size: float) -> float:
    """Estimate the width of a line in a common sans-serif face, the same for every backend."""
    narrow = "iljtfrI.,:;'|!()[] "
    wide = "mwMW@%"
    ems = sum(
        0.30 if c in narrow else 0.88 if c in wide else 0.68 if c.isupper() else 0.58 for c in text
    )
    return ems * size


def scale_bar(most: float) -> float:
    """Return the longest round length up to a limit: 1, 2 or 5 times a power of ten.

    Args:
        most: The limit, m; above 0.
    """
    power = 10.0 ** math.floor(math.log10(most) + 1e-9)
    factor = next(one for one in (5.0, 2.0, 1.0) if one * power <= most * (1.0 + 1e-9))
    # Rounding hides the last digit of a power below 1.
    return float(f"{factor * power:.3g}")


def two_digits(value: float) -> str:
    """Return a number to two digits, without an exponent: ``0.031``, ``3.1``, ``310``."""
    return f"{float(f'{value:.2g}'):.15g}"


def length_words(metres: float) -> str:
    """Return a length to two digits, in the unit that needs the fewest, as the pages do."""
    for least, size, unit in ((1000.0, 1000.0, "km"), (0.1, 1.0, "m"), (0.01, 0.01, "cm")):
        if metres >= least:
            return f"{two_digits(metres / size)} {unit}"
    return f"{two_digits(metres / 0.001)} mm"
