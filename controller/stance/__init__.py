"""Stances of base and arm for a goal: search, approach, and following of moving goals."""
