"""Controllers that are separate programs: start them, talk to them, and report how they end."""
