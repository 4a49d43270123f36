"""Independent checkers of certificates; they share no code with the prover."""
