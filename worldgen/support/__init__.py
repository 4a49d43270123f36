"""Small helpers that know nothing about worlds.

They handle text for terminals, progress, arrays and worker processes.
"""
