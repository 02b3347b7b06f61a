"""Looking at something: viewpoints, surveys of regions, objects, surfaces and grasp targets."""
