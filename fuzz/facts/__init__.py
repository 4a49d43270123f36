"""Single facts about a run: its certificate, signature, contacts, hazards, and runs in other worlds."""
