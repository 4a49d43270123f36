"""Files: read and written whole and safely, archives, locks, and the ``.grid`` format."""
