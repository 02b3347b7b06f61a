"""Grasp detection from a depth image.

`detector` runs the pipeline: `network_input` crops the image, a network or another source of
`candidates` proposes grasps, `refinement` tests them on the `height_map` with `feasibility`, and
`ranking` orders them. `tracker` follows one grasp over frames.
"""
