"""The thesis's simulator: its options, and runs in its C core."""
