"""Build the C cores and wheels for other systems, and write the types of the studio's messages."""
