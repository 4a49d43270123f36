"""A controller in each of the three ways; ``worldgen new-controller`` copies them.

Contents:
    compiled: a function on arrays. python: a class. process: a program of its own, which imports
        nothing of ours.
"""
