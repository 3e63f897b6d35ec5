"""Real KITTI and AirSim frames, for whoever has some: the folder that SYNTHDEPTH_REALDATA names."""

import os
from pathlib import Path

import pytest

REAL = Path(os.environ.get("SYNTHDEPTH_REALDATA") or "no-real-frames")


def needs_real(folder: str) -> pytest.MarkDecorator:
    """Skips a test where there is no such folder of real frames."""
    reason = f"set SYNTHDEPTH_REALDATA to a folder that holds {folder}"
    return pytest.mark.skipif(not (REAL / folder).is_dir(), reason=reason)
