"""The wall clock: how long a controller takes, and when to stop waiting for it."""
