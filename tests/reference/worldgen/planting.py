"""Planting in plain Python, like worldgen/core/making/planting.c."""


def put_down(barred, stands, places, kinds, cells, cell_ends, halos, ends):
    """Visits places in turn and puts a thing down wherever none of its cells is blocked.

    Args:
        barred: (n,) 1 where no cell of a thing may be; grows with every placed thing.
        stands: (m,) to be filled: 1 if the thing of that turn was placed.
        places: (m,) places to try.
        kinds: (m,) kinds to try there.
        cells: Offsets of the cells of all kinds, one kind after another.
        cell_ends: Where each kind's offsets end.
        halos: The offsets that a thing blocks, in the same form.
        ends: Where these end.
    """
    for turn in range(len(places)):
        at = places[turn]
        kind = kinds[turn]
        if barred[at] != 0:
            continue
        fits = True
        for k in range(cell_ends[kind - 1] if kind > 0 else 0, cell_ends[kind]):
            if barred[at + cells[k]] != 0:
                fits = False
                break
        if fits:
            stands[turn] = 1
            for k in range(ends[kind - 1] if kind > 0 else 0, ends[kind]):
                barred[at + halos[k]] = 1
