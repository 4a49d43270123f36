"""Runs as pictures over their worlds."""
