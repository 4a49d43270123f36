"""Find and load what users' code and other packages add by name, such as families."""
