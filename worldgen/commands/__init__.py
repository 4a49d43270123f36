"""The commands of ``worldgen``, one module each."""
