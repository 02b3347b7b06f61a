"""Collision avoidance: shapes, distances, and the constraints of the QP made from them."""
