"""Benches of the controller and of the whole robot, as commands that anybody can repeat.

Motions are evaluated from their samples and from the simulated world, not from the controller's own
reports: joint and base limits, contacts, arrival, jerk.
"""
