"""What a check of the gate says: how much evidence there was, and the fault if it shows one."""

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True, kw_only=True)
class Check:
    """The outcome of one check of one pair.

    Attributes:
        subject: what is asked about: one of `SUBJECTS`.
        name: of the check, within its subject.
        effect: size of what speaks against the pair, in the check's own unit; negative where it
            speaks for it; None where the pair has no evidence.
        sigmas: the effect in standard errors, of checks that count.
        fault: what is wrong, in one line; None where nothing is.
        limit: the effect from which on many pairs together are at fault; None for a check that
            says nothing of many.
        told: the fault that the effect stands for.
    """

    subject: str
    name: str = ""
    effect: float | None = None
    sigmas: float | None = None
    fault: str | None = None
    limit: float | None = None
    told: str = ""


# What is asked about, in order.
SUBJECTS = ("contract", "poses", "depth", "pictures", "truth", "warp", "edges")


def mean_and_sigmas(values: np.ndarray) -> tuple[float, float]:
    """The mean of independent values (n,), n > 1, and that in its standard errors."""
    mean = float(np.mean(values))
    error = float(np.std(values, ddof=1)) / np.sqrt(len(values))
    # Values that agree to the last digit are no endless evidence.
    return mean, mean / max(error, 1e-6)
