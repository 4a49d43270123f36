"""Controllers that are programs of their own: start them, talk to them, report how they die."""
