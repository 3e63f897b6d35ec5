"""Sand, rock, water and what lies on a beach."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.world import Material

Rng = np.random.Generator

COAST: dict[str, Callable[[Rng], Material]] = {}
