"""What is true of a robot, once: its description, and the primitive shapes it is made of."""
