"""What is known each tick: images, obstacles, where the base is, furniture that was moved."""
