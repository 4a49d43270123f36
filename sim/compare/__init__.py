"""Controllers over worlds and seeds in one table."""
