"""What to do with runs that are over: list, explain, open."""
