"""Faults planted in a copy of the sources, to measure which test tier catches each."""
