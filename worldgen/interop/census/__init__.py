"""Judge the maps and generators of other projects.

A census finds what a disc can reach in them, and what only a point on the grid can reach.

Contents:
    take_census, Census, Question: Ask every map at every radius and keep the answers.
    CensusMap, Ends, Refused: A map that the census reads, and a file that it could not read.
    Radius: A radius in m, or in cells of each map.
    folder_maps: The maps in files and folders.
    generated_maps: The maps of a third-party generator, through a function.
    Tally, tally: Counts and intervals for each radius.
    as_csv, as_json, as_text: The forms in which the census is printed.
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
