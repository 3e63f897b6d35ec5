"""Motion primitives of least jerk, in closed form, and trajectories put together from them.

M. W. Mueller, M. Hehn, R. D'Andrea, "A Computationally Efficient Motion Primitive for Quadrocopter
Trajectory Generation", IEEE Transactions on Robotics 31(6), 2015. Per axis, the jerk that minimises
the integral of its square is j(t) = alpha t^2 / 2 + beta t + gamma (section III). Where the
terminal position is free, alpha = 0 and beta, gamma follow from the terminal velocity and
acceleration (appendix A): positions are quartics of time.
"""

import dataclasses

import numpy as np


def minimum_jerk(position_m, velocity_mps, acceleration_mps2, terminal_velocity_mps, duration_s):
    """Coefficients (m, 5, 3) float64 of the primitives to terminal velocities, with no
    acceleration at the end; row k multiplies t^k.

    Args:
        position_m, velocity_mps, acceleration_mps2: (3,) each, the state at t = 0.
        terminal_velocity_mps: (m, 3).
        duration_s: (m,), T.
    """
    p0, v0, a0 = (np.asarray(x, np.float64) for x in (position_m, velocity_mps, acceleration_mps2))
    T = np.asarray(duration_s, np.float64)[:, None]
    dv = terminal_velocity_mps - v0 - a0 * T
    da = -a0
    beta = (6 * T * da - 12 * dv) / T**3
    gamma = (6 * T * dv - 2 * T**2 * da) / T**3
    fixed = np.broadcast_to(np.stack([p0, v0, a0 / 2]), (len(beta), 3, 3))
    return np.concatenate([fixed, gamma[:, None] / 6, beta[:, None] / 24], axis=1)


_DERIVATIVE = np.array(
    [[1, 1, 1, 1, 1], [1, 2, 3, 4, 0], [2, 6, 12, 0, 0], [6, 24, 0, 0, 0]], dtype=np.float64
)


def evaluate(coefficients: np.ndarray, t: np.ndarray, order: int = 0) -> np.ndarray:
    """Position (order 0), velocity (1), acceleration (2) or jerk (3) of primitives.

    Args:
        coefficients: (..., 5, 3).
        t: (..., k) time since the start of each primitive [s].
        order: of the derivative.

    Returns:
        (..., k, 3) float64.
    """
    powers = np.stack([np.ones_like(t), t, t**2, t**3, t**4][: 5 - order], axis=-1)
    factor = _DERIVATIVE[order, : 5 - order, None]
    return powers @ (coefficients[..., order:, :] * factor)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Primitives flown one after the other; position, velocity and acceleration are continuous.

    Attributes:
        start_s: (m,) float64, when each primitive begins; the first is 0.
        end_s: when the last one ends [s].
        coefficients: (m, 5, 3) float64, as from `minimum_jerk`.
    """

    start_s: np.ndarray
    end_s: float
    coefficients: np.ndarray

    def evaluate(self, t: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of this order of the position at times t (n,) [s]: (n, 3) float64."""
        t = np.asarray(t, np.float64)
        i = np.clip(np.searchsorted(self.start_s, t, side="right") - 1, 0, len(self.start_s) - 1)
        return evaluate(self.coefficients[i], (t - self.start_s[i])[:, None], order)[:, 0]
