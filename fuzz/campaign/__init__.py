"""A campaign: an executor does units of search, failures are shrunk, a store keeps it all on disk."""
