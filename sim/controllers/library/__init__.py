"""Controllers from the literature, one file each.

``docs/library.md`` says what each does and where it fails.
"""
