"""Faults that are planted into a copy of the sources, to see which tier of the tests catches each."""
