"""Import of robots from URDF files."""
