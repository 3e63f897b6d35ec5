"""People: skeletons in poses, dressed, and copied into crowds."""

from synthdepth.maps.people.crowd import people
from synthdepth.maps.people.skeleton import POSES

__all__ = ["POSES", "people"]
