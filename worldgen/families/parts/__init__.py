"""Parts that families share or are built of."""
