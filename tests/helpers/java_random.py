"""java.util.Random's nextDouble, from which the thesis's random rule drew."""


def java_doubles(seed: int, count: int) -> list[float]:
    """The first ``count`` values of ``new Random(seed).nextDouble()``."""
    mask = (1 << 48) - 1
    state = (seed ^ 0x5DEECE66D) & mask
    values = []
    for _ in range(count):
        high_low = []
        for bits in (26, 27):
            state = (state * 0x5DEECE66D + 0xB) & mask
            high_low.append(state >> (48 - bits))
        values.append(((high_low[0] << 27) + high_low[1]) * 2.0**-53)
    return values
