"""A campaign: units of search done by an executor, failures shrunk, everything kept in a store on disk."""
