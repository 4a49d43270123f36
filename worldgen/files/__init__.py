"""Files: read and write them safely, archives, locks, and the ``.grid`` format."""
