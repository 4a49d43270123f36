"""Build the C cores: compile them, find a compiler, make wheels for other systems."""
