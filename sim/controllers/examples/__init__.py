"""Template controllers, one per kind; ``worldgen new-controller`` copies them.

Contents:
    python: A Python class.
    vector: A Python class that drives many robots at once, with NumPy.
    compiled: A function on arrays, compiled by numba.
    process: A program in any language, which needs nothing from this package.
    library: A function in C or C++, built as a shared library.
"""
