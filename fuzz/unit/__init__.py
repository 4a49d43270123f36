"""What the parts of a campaign share: its definition, a unit's result, deadlines, the answer."""
