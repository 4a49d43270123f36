"""Plan for several robots jointly: where each is at any time, clear of walls and of the others."""
