"""Cars: robots whose turning circle has a least radius."""
