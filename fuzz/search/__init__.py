"""Search strategies: each looks for runs that fail, and brings them to triage."""
