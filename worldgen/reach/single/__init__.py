"""Proofs for one robot, in worlds that are static or change."""
