"""What a drone can do, and the ranges that flights are drawn from."""

import dataclasses

from synthdepth.config import Config, number, span
from synthdepth.errors import RecipeError


@dataclasses.dataclass(frozen=True, kw_only=True)
class FlightLimits(Config):
    """The drone's limits and the ranges of a recipe's flights; ranges are (lowest, highest).

    Attributes:
        max_speed_mps: fastest motion (22.2: the paper's drones).
        max_acceleration_mps2: largest norm of the acceleration.
        max_jerk_mps3: largest norm of the jerk.
        max_tilt_deg: largest angle of the thrust from the vertical.
        max_yaw_rate_dps: fastest turn.
        max_yaw_acceleration_dps2: fastest change of the turn.
        drag_per_s: linear rotor drag; 0.15 tilts a drone by 19 deg at 22 m/s.
        drone_radius_m: radius of the sphere around the drone.
        margin_m: distance kept between that sphere and everything else.
        altitude_m: above ground, kept to at every moment.
        speed_mps: drawn cruise speed.
        distance_m: drawn horizontal distance from start to goal.
        clearance_m: drawn preferred clearance, log-uniform: how daring the flight is.
        look_deg: largest angle by which the drone looks beside its course.
        mount_pitch_deg: drawn pitch of the camera against the body; negative looks down.
        frame_interval_s: time between frames.
        duration_s: shortest and longest flight.
        max_draws: flights drawn before a scene is given up.
    """

    max_speed_mps: float = number(22.2, 0.1, 100)
    max_acceleration_mps2: float = number(8.0, 0.1, 100)
    max_jerk_mps3: float = number(40.0, 0.1, 1000)
    max_tilt_deg: float = number(35.0, 1, 80)
    max_yaw_rate_dps: float = number(90.0, 1, 720)
    max_yaw_acceleration_dps2: float = number(180.0, 1, 5000)
    drag_per_s: float = number(0.15, 0, 5)
    drone_radius_m: float = number(0.35, 0.01, 5)
    margin_m: float = number(0.5, 0.01, 20)
    altitude_m: tuple[float, float] = span((2.0, 40.0), 0.5, 300)
    speed_mps: tuple[float, float] = span((2.0, 22.2), 0.1, 100)
    distance_m: tuple[float, float] = span((60.0, 400.0), 1, 5000)
    clearance_m: tuple[float, float] = span((1.0, 25.0), 0.1, 200)
    look_deg: float = number(25.0, 0, 180)
    mount_pitch_deg: tuple[float, float] = span((-10.0, 15.0), -90, 45)
    frame_interval_s: float = number(0.1, 0.001, 10)
    duration_s: tuple[float, float] = span((5.0, 25.0), 0.1, 600)
    max_draws: int = number(40, 1, 10_000)

    def __post_init__(self):
        super().__post_init__()
        if self.speed_mps[1] > self.max_speed_mps:
            raise RecipeError(
                f"speed_mps = {list(self.speed_mps)}: allowed is up to max_speed_mps = "
                f"{self.max_speed_mps:g}"
            )

    @property
    def needed_m(self) -> float:
        """Distance that the drone's centre keeps from everything [m]."""
        return self.drone_radius_m + self.margin_m
