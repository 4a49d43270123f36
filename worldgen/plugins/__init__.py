"""Named things that users' code and other packages add: the registry, and how it loads them."""
