"""What city buildings and streets are made of."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.world import Material

Rng = np.random.Generator

CITY: dict[str, Callable[[Rng], Material]] = {}
