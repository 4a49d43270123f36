"""Judge the maps and generators of other projects.

It finds what a disc can reach in them, and what only a point on the grid can reach. Contents:
    take_census, Census, Question (``take``): asks every map at every radius and keeps the answers.
    CensusMap, Ends, Refused (``case``): a map that the census reads, and a file that it could not
    read. Radius (``case``): in m or in cells of whatever map comes.
    folder_maps (``folders``): the maps in files and folders.
    generated_maps (``generators``): the maps of a third-party generator, through a function.
    Tally, tally (``report``): counts and intervals for each radius.
    as_csv, as_json, as_text (``report``): what is printed.
"""

from worldgen.interop.census.case import CensusMap, Ends, Radius, Refused, cell_at
from worldgen.interop.census.folders import folder_maps
from worldgen.interop.census.generators import generated_maps
from worldgen.interop.census.report import Tally, as_csv, as_json, as_text, tally
from worldgen.interop.census.take import Census, CensusCase, CensusOptions, take_census

__all__ = [
    "Census",
    "CensusCase",
    "CensusMap",
    "CensusOptions",
    "Ends",
    "Radius",
    "Refused",
    "Tally",
    "as_csv",
    "as_json",
    "as_text",
    "cell_at",
    "folder_maps",
    "generated_maps",
    "take_census",
    "tally",
]
