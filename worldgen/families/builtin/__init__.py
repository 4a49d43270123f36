"""The families that come with worldgen, one module each.

:mod:`worldgen.families` names them. They have a folder of their own because
``worldgen.families.maze`` is the family that you call, so no module there can have that name.
"""
