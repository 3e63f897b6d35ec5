"""What protocols do to a prediction before they compare: cropping, resizing, filling, scaling."""

import numpy as np

from synthdepth.errors import SynthdepthError

# Top, bottom, left and right as shares of the height and width, cut to whole pixels.
CROPS = {
    "none": (0.0, 1.0, 0.0, 1.0),
    # Garg et al. 2016, as monodepth2, BTS and all who follow have it.
    "garg": (0.40810811, 0.99189189, 0.03594771, 0.96405229),
    # Eigen et al. 2014, as BTS has it.
    "eigen": (0.3324324, 0.91351351, 0.0359477, 0.96405229),
}
# The part of a KITTI picture that the depth benchmark shows ("KB crop"): bottom, middle.
KB_SHAPE = (352, 1216)


def crop_slices(shape: tuple[int, int], crop: str) -> tuple[slice, slice]:
    """Rows and columns of one of `CROPS` in an image of (height, width)."""
    top, bottom, left, right = CROPS[crop]
    height, width = shape
    return (
        slice(int(top * height), int(bottom * height)),
        slice(int(left * width), int(right * width)),
    )


def kb_slices(shape: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of the KITTI benchmark's part of an image of (height, width).

    Raises:
        SynthdepthError: the image is smaller than that part.
    """
    (rows, columns), (height, width) = KB_SHAPE, shape
    if height < rows or width < columns:
        raise SynthdepthError(
            f"ground truth of {width}x{height}: a protocol in the benchmark's frame needs at least "
            f"{columns}x{rows}"
        )
    top, left = height - rows, int((width - columns) / 2)
    return slice(top, top + rows), slice(left, left + columns)


def resize_linear(image: np.ndarray, shape: tuple[int, int], corners: bool) -> np.ndarray:
    """Bilinear resizing as PyTorch's `interpolate` and OpenCV's `resize` do it.

    Args:
        image: (h, w).
        shape: (H, W) wanted.
        corners: the centres of the corner pixels stay (`align_corners=True`); else the outer edges
            of the image do (`align_corners=False`, OpenCV).

    Returns:
        (H, W) float64.
    """
    image = np.asarray(image, np.float64)
    for axis, (size, wanted) in enumerate(zip(image.shape, shape, strict=True)):
        if size == wanted:
            continue
        if corners:
            at = np.arange(wanted) * ((size - 1) / max(wanted - 1, 1))
        else:
            at = np.clip((np.arange(wanted) + 0.5) * (size / wanted) - 0.5, 0, size - 1)
        low = np.minimum(at.astype(np.intp), max(size - 2, 0))
        share = (at - low).reshape((-1, 1) if axis == 0 else (1, -1))
        below, above = (np.take(image, low + k, axis, mode="clip") for k in (0, 1))
        image = below * (1 - share) + above * share
    return image


def fill_background(depth: np.ndarray) -> np.ndarray:
    """Missing predictions filled as KITTI's devkit fills them.

    A gap within a row takes the smaller of the depths at its ends; before the first and after the
    last of a row, the nearest counts; rows above the first and below the last that have any take
    those rows' depths. (The smaller one is the background for disparity, for which the rule was
    made.)

    Args:
        depth: (H, W) [m]; what is not finite and positive is missing.

    Returns:
        (H, W) float64; empty rows between others, and empty images, stay missing.
    """
    filled = np.array(depth, np.float64)
    missing = ~((filled > 0) & np.isfinite(filled))
    if not missing.any() or missing.all():
        return filled
    filled[missing] = np.nan
    column = np.arange(filled.shape[1])
    for row in np.flatnonzero(missing.any(axis=1) & ~missing.all(axis=1)):
        known = np.flatnonzero(~missing[row])
        after = np.searchsorted(known, column)
        left = filled[row, known[np.clip(after - 1, 0, None)]]
        right = filled[row, known[np.clip(after, None, len(known) - 1)]]
        filled[row] = np.where(missing[row], np.minimum(left, right), filled[row])
    rows = np.flatnonzero(~missing.all(axis=1))
    filled[: rows[0]], filled[rows[-1] + 1 :] = filled[rows[0]], filled[rows[-1]]
    return filled


def median_ratio(prediction: np.ndarray, truth: np.ndarray) -> float:
    """What a prediction is multiplied by so that its median is the truth's (Zhou et al. 2017).

    Args:
        prediction: (N,) [m], the pixels that count, before any clamp.
        truth: (N,) [m].

    Returns:
        median(g) / median(p) over predictions that are depths; 1 where there are none.
    """
    depths = (prediction > 0) & np.isfinite(prediction)
    return float(np.median(truth) / np.median(prediction[depths])) if depths.any() else 1.0
