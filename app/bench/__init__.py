"""What the controller is worth, measured: time of a step, the poses of Experiment 1, 1000 goals.

Motions are integrated without error; what happened is judged by measures of its own, independent of
those that the controller keeps: joint and base limits, contacts, arrival, jerk.
"""
