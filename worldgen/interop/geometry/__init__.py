"""Turn walls into boxes, polygons and rasters, for the formats that need them."""
