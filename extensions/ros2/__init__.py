"""ROS 2 without ROS, and Foxglove: drivers by topics and actions, publishers, and bags.

Everything that speaks DDS or CDR is here.
"""
