"""Where the base is: laser scan and depth image against the surfaces of the map."""

from perception.registration.localisation import LocalisationFilter, Update, smoothed
from perception.registration.matching import DISPLACED
from perception.registration.placing import UNKNOWN_COVER, Place, place_in_image
from perception.registration.registering import (
    Displacement,
    Judge,
    Registration,
    register,
    rivals,
)
from perception.registration.sensors import LASER, Cloud, depth_cloud, scan_cloud
from perception.registration.surfaces import Surfaces
