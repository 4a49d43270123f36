"""Twelve controllers of real kinds, and how soon a campaign finds the fault planted in each."""
