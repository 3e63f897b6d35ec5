"""Path-traced synthetic data for long-range monocular depth from drones."""

__version__ = "0.1.0"
