"""Decide static worlds: a witness, or a cut."""
