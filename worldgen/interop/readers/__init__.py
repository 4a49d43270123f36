"""Parsers for the files of other programs."""
