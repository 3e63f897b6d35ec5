"""Turf, seats and nets."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.world import Material

Rng = np.random.Generator

SPORTS: dict[str, Callable[[Rng], Material]] = {}
