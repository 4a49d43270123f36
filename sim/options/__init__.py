"""Options of a run and of its robot."""
