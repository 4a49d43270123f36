"""Define the families that come with worldgen, one module each.

:mod:`worldgen.families` lists them. They need a separate folder because ``worldgen.families.maze``
is the family that you call, so no module in that folder can have the same name.
"""
