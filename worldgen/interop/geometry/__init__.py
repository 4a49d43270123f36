"""Walls as boxes, polygons and rasters, for the formats that need them."""
