"""A dataset in the layouts of others."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from synthdepth.errors import SynthdepthError

if TYPE_CHECKING:
    from synthdepth.export.folder import ExportReport

# Each layout's module and function; imported when it is asked for, as each needs other libraries.
LAYOUTS = {
    "kitti": ("synthdepth.export.kitti", "export_kitti"),
    "tartanair": ("synthdepth.export.tartanair", "export_tartanair"),
    "hf": ("synthdepth.export.huggingface", "export_hf"),
    "nerfstudio": ("synthdepth.export.nerfstudio", "export_nerfstudio"),
}


def export(
    layout: str,
    folder: Path,
    out: Path,
    *,
    split: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    **options,
) -> "ExportReport":
    """Write a dataset in another layout.

    Args:
        layout: a name in `LAYOUTS`.
        folder: the dataset.
        out: a new or an empty folder; it is there whole or not at all.
        split: `train` or `test`; both without.
        on_progress: called with (pairs done, pairs in all).
        options: of the layout, e.g. `sky` of kitti.

    Raises:
        SynthdepthError: an unknown layout or option.
        DatasetError: the dataset cannot be read, or the folder not be written.
    """
    if layout not in LAYOUTS:
        raise SynthdepthError(f"layout {layout!r}: allowed are {', '.join(LAYOUTS)}")
    module, name = LAYOUTS[layout]
    function = getattr(importlib.import_module(module), name)
    if options and layout != "kitti":
        raise SynthdepthError(f"--{next(iter(options))} belongs to --to kitti, not to {layout}")
    return function(folder, out, split=split, on_progress=on_progress, **options)
