"""Paints and floors of the obstacle arena."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.world import Material

Rng = np.random.Generator

ARENA: dict[str, Callable[[Rng], Material]] = {}
