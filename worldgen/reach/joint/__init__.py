"""Joint plans of several robots: who is where at which time, clear of walls and of each other."""
