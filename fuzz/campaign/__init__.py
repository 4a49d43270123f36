"""A campaign: an executor runs units of search, failures are shrunk, a store keeps all on disk."""
