"""Compare controllers over worlds and seeds in one table."""
