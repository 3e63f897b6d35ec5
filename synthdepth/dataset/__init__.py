"""The dataset contract: records, shards, manifest, checks, previews and loaders."""

import importlib

# Now, not on demand: loading the submodule `collate` would otherwise take the function's name.
from synthdepth.dataset.collate import Batch, collate

# On demand, as they load OpenCV, OpenEXR and pyarrow.
_MODULES = {
    "EmbedFlow": "transforms",
    "Pair": "pair",
    "PairDataset": "pairs",
    "PairStream": "stream",
    "RandomFlip": "transforms",
    "Resize": "transforms",
    "Sample": "sample",
    "sample_of": "sample",
}

__all__ = ["Batch", "collate", *_MODULES]


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
