"""Single facts about a run: its certificate, class, contacts, hazards, and runs in other worlds."""
