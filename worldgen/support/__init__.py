"""Small helpers that know nothing of worlds: text for terminals, progress, arrays, worker processes."""
