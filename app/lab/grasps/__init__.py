"""Where the grasp network's weights come from: rendered scenes, training, evaluation."""
