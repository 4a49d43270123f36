"""Small helpers that know nothing of worlds.

Text for terminals, progress, arrays, worker processes.
"""
