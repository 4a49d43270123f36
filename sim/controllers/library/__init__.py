"""Controllers from the literature, one file each.

``docs/reference/library.md`` describes what each of them does and where it fails.
"""
