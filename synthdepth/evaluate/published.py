"""Published results, to set beside one's own: as printed, with where they are from.

No protocol is stated for the paper's KITTI row, so no difference to any other row can be read from
it alone.
"""

import dataclasses


@dataclasses.dataclass(frozen=True, kw_only=True)
class Published:
    """A row of a published table; None is not given.

    Attributes:
        method: as named there.
        rmse: [m].
        abs_rel, delta_1, delta_2, delta_3: as `METRICS` has them.
        protocol: name of the protocol that its authors' program follows; None: not stated.
        source: where it is printed.
        note: what one has to know.
    """

    method: str
    rmse: float
    abs_rel: float
    delta_1: float
    delta_2: float | None = None
    delta_3: float | None = None
    protocol: str | None = None
    source: str = ""
    note: str = ""


_PAPER = "Pix2Pix-Based Monocular Depth Estimation for Drones with Optical Flow on AirSim"


def _rows(source: str, *rows: tuple, note: str = "") -> tuple[Published, ...]:
    names = ("method", "rmse", "abs_rel", "delta_1", "delta_2", "delta_3")
    return tuple(
        Published(**dict(zip(names, row, strict=True)), source=source, note=note) for row in rows
    )


# Which density of embedded flow: pixels between embedded ones.
TABLE_2 = _rows(
    f"{_PAPER}, table 2",
    ("optical flow only", 7.6786, 0.3886, 0.7416, 0.8604, 0.9129),
    ("interval 1", 6.6258, 0.1675, 0.8634, 0.9376, 0.9621),
    ("interval 3", 6.0947, 0.1397, 0.8878, 0.9554, 0.9758),
    ("interval 5", 6.0050, 0.1230, 0.8923, 0.9608, 0.9797),
    ("interval 7", 6.5064, 0.1240, 0.8910, 0.9605, 0.9795),
    ("interval 9", 6.7068, 0.1335, 0.8947, 0.9573, 0.9762),
    note="AirSim, depth to 200 m",
)
# With and without flow.
TABLE_3 = _rows(
    f"{_PAPER}, table 3",
    ("Shimada et al.: RGB only", 5.942, 0.1338, 0.8871, 0.9562, 0.9772),
    ("the paper: embedded flow, interval 5", 6.005, 0.1230, 0.8923, 0.9608, 0.9796),
    note="AirSim, depth to 200 m",
)
# KITTI.
_TABLE_4 = f"{_PAPER}, table 4"
TABLE_4 = (
    Published(
        method="Eigen et al. 2014",
        rmse=7.156,
        abs_rel=1.515,
        delta_1=0.692,
        delta_2=0.899,
        delta_3=0.967,
        source=_TABLE_4,
        note="1.515 stands in the column of AbsRel; larger than any that fits such deltas",
    ),
    *_rows(
        _TABLE_4,
        ("Liu et al.", 6.986, 0.217, 0.647, 0.882, 0.961),
        ("Kuznetsov et al.", 4.621, 0.113, 0.862, 0.960, 0.986),
        ("the paper", 7.605, 0.154, 0.813, 0.958, 0.985),
        note="protocol not stated",
    ),
)

# KITTI, Eigen split, as their authors print them.
EIGEN_SPLIT = tuple(
    Published(
        method=method,
        rmse=rmse,
        abs_rel=abs_rel,
        delta_1=delta_1,
        protocol=protocol,
        source=source,
        note=note,
    )
    for method, delta_1, abs_rel, rmse, protocol, source, note in (
        ("BTS", 0.955, 0.060, 2.798, "eigen-garg-full-80", "Lee et al. 2019", ""),
        ("AdaBins", 0.964, 0.058, 2.360, "eigen-garg-kb-80", "Bhat et al. 2021", ""),
        ("ZoeDepth", 0.971, 0.054, 2.281, "eigen-garg-kb-80", "Bhat et al. 2023", ""),
        ("Depth Anything v1 L", 0.982, 0.046, 1.896, None, "Yang et al. 2024", "fine-tuned"),
        ("Metric3D v2 g", 0.989, 0.051, 2.403, None, "Hu et al. 2024", "never saw KITTI"),
        ("SfMLearner", 0.734, 0.183, 6.709, None, "Zhou et al. 2017", "median scaling"),
        ("monodepth2", 0.877, 0.115, 4.863, "monodepth2-eigen", "Godard et al. 2019", "mono"),
    )
)

# Seconds a picture, without and with flow.
TABLE_5_S = {
    "NVIDIA RTX 2070 SUPER": (0.031, 0.134),
    "Intel Core i7 9700K": (0.181, 0.273),
    "NVIDIA Jetson Xavier NX": (0.193, 0.297),
}

TABLES = {"2": TABLE_2, "3": TABLE_3, "4": TABLE_4, "eigen": EIGEN_SPLIT}
