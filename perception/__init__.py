"""From a depth frame to a tracked grasp.

`GraspDetector` turns one depth frame into ranked grasps in the world: a network proposes
candidates, which are refined and tested for feasibility on the measured depth. `GraspTracker`
tracks one grasp over frames. The networks and their training are in `perception.networks`, a room
with a face of its own, because it imports torch; this one does not.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from perception.agreement import agreed
    from perception.candidates import WITHOUT_NETWORK, Candidates, CandidateSource, Proposals
    from perception.colours import COLOURS, ColourName, colour_name
    from perception.cutting import SeamModel, logarithms, piece_of
    from perception.detector import GraspDetector
    from perception.footprint import Footprint
    from perception.frame import Workspace
    from perception.frame_mistakes import FrameJudge, mistake_in
    from perception.geometry import disc, seen_through, world_points
    from perception.grasp import Detection, GraspEstimate
    from perception.grasp_feasibility import assess
    from perception.grasp_patches import NUMBERS, GraspPatches, HoldProbability, joined_patches
    from perception.hand_dimensions import hand_sizes
    from perception.height_map import HeightMap, build_height_map
    from perception.kinds import SHAPE_KINDS, known_kinds, with_kinds
    from perception.network_io import (
        ANGLE_BINS,
        INPUT_SIZE,
        OUTPUT_STRIDE,
        WeightsError,
    )
    from perception.objects import ColourFrame, seen_objects, standing
    from perception.preprocess import METRES_PER_PIXEL, Crop, central_crop, prepare
    from perception.recogniser import Labelled, Recogniser, RecogniserError
    from perception.region_map import WALL_MARGIN, RegionMap, Segment
    from perception.samples import Labels, Sample, Shard
    from perception.scene_memory import SceneMemory
    from perception.seams import SEAM_MEASURES, measure_seam, seams_across
    from perception.seen_object import SeenObject, SeenObjects
    from perception.seen_surfaces import SeenSurfaces, SurfaceSettings, surface_cells
    from perception.table_plane import NoTableError, camera_above_table
    from perception.tracker import GraspTracker, TrackerSettings
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "ANGLE_BINS",
    "COLOURS",
    "INPUT_SIZE",
    "METRES_PER_PIXEL",
    "NUMBERS",
    "OUTPUT_STRIDE",
    "SEAM_MEASURES",
    "SHAPE_KINDS",
    "WALL_MARGIN",
    "WITHOUT_NETWORK",
    "CandidateSource",
    "Candidates",
    "ColourFrame",
    "ColourName",
    "Crop",
    "Detection",
    "Footprint",
    "FrameJudge",
    "GraspDetector",
    "GraspEstimate",
    "GraspPatches",
    "GraspTracker",
    "HeightMap",
    "HoldProbability",
    "Labelled",
    "Labels",
    "NoTableError",
    "Proposals",
    "Recogniser",
    "RecogniserError",
    "RegionMap",
    "Sample",
    "SceneMemory",
    "SeamModel",
    "SeenObject",
    "SeenObjects",
    "SeenSurfaces",
    "Segment",
    "Shard",
    "SurfaceSettings",
    "TrackerSettings",
    "WeightsError",
    "Workspace",
    "agreed",
    "assess",
    "build_height_map",
    "camera_above_table",
    "central_crop",
    "colour_name",
    "disc",
    "hand_sizes",
    "joined_patches",
    "known_kinds",
    "logarithms",
    "measure_seam",
    "mistake_in",
    "piece_of",
    "prepare",
    "seams_across",
    "seen_objects",
    "seen_through",
    "standing",
    "surface_cells",
    "with_kinds",
    "world_points",
]
