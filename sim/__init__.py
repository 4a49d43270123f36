"""The shared simulator: robots, motion models, controllers, runs and their traces."""
