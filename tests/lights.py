"""Lights for worlds under test."""

from synthdepth.maps.world import Light

CLEAR = Light(
    condition="clear",
    sun_azimuth_deg=200.0,
    sun_elevation_deg=40.0,
    turbidity=3.0,
    visibility_m=2e4,
)
