"""The fuzzer: searches for worlds in which a controller fails, proves it, shrinks it, keeps it."""
