"""`croissant.json`: the dataset in the Croissant 1.0 vocabulary, for search engines and loaders.

Source: https://docs.mlcommons.org/croissant/docs/croissant-spec-1.0.html. Record sets are tables
with the same key: `pairs` has the metadata, and each modality has a table of its own, because
mlcroissant 1.1 joins two sources at most. Three more things to know of it: what it unpacks goes to
a cache keyed by the shards' names, not by what they hold; it reads a modality's table whole into
memory; and a `Dataset` yields it once: iterating again gives no rows, without an error.
"""

import json
from collections.abc import Mapping
from pathlib import Path

from synthdepth.dataset.card import LICENSE_URL, dataset_name, summary
from synthdepth.dataset.manifest import CROISSANT, INDEX, pair_files
from synthdepth.dataset.pair import META_FIELDS
from synthdepth.dataset.shard import sha256_of, write_whole

# The day that version 1 of the format was published. A dataset has no date of its own: the same
# command gives the same bytes on any day.
PUBLISHED = "2026-11-22"

# The context that the specification prescribes, word for word: another one is warned about.
_CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}

_SPLITS = {"train": "cr:TrainingSplit", "test": "cr:TestSplit"}
_TYPES = {int: "sc:Integer", float: "sc:Float", str: "sc:Text", list: "sc:Float"}
_MIME = {"png": "image/png", "exr": "image/x-exr"}

# What each modality is, for people; EXR is no picture to mlcroissant, but bytes.
_MODALITIES = {
    "rgb.png": "Frame t, 8-bit sRGB.",
    "prev.png": "Frame t-1 of the same flight, 8-bit sRGB.",
    "depth.exr": "Planar depth of frame t: bytes of an OpenEXR file, channel Z, float32 metres. "
    "Read it with OpenEXR or OpenImageIO; OpenCV returns zeros.",
    "flow.exr": "Flow from t to t-1: bytes of an OpenEXR file, channels u, v [px], visible.",
    "seg.png": "Class ids of frame t, 8-bit grey.",
    "normal.exr": "Surface normals of frame t: bytes of an OpenEXR file, channels X, Y, Z.",
}


def write_croissant(folder: Path, manifest: Mapping) -> None:
    """Write `croissant.json` of a dataset whose shards and index are there.

    Args:
        folder: the dataset folder.
        manifest: the dataset's, with its shards.
    """
    document = croissant(manifest, sha256_of(Path(folder) / INDEX))
    write_whole(Path(folder) / CROISSANT, json.dumps(document, indent=1).encode() + b"\n")


def croissant(manifest: Mapping, index_sha256: str) -> dict:
    """The JSON-LD document of a dataset: its files, and the tables that they make."""
    name = dataset_name(manifest)
    version = manifest["software"]["synthdepth"]
    files = [file for file in pair_files(manifest) if file in _MODALITIES]
    splits = [split for split in _SPLITS if manifest["splits"].get(split)]
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": name,
        "description": summary(manifest),
        "license": "unknown" if "source" in manifest else LICENSE_URL,
        "url": "README.md",
        "creator": {"@type": "sc:Organization", "name": "synthdepth"},
        "datePublished": PUBLISHED,
        "version": f"{manifest['schema_version']}.0.0",
        "citeAs": f"@misc{{{name}, title = {{{name}: drone frames with metric depth}}, "
        f"note = {{made with synthdepth {version}}}, year = {{{PUBLISHED[:4]}}}}}",
        "keywords": ["depth estimation", "synthetic data", "drone"],
        "distribution": [
            _file_object(INDEX, "application/x-parquet", index_sha256),
            *(
                _file_object(s["path"], "application/x-tar", s["sha256"], s["bytes"])
                for s in manifest["shards"]
            ),
            *(_file_set(file, manifest["shards"]) for file in files),
        ],
        "recordSet": [
            _splits_table(splits),
            _pairs_table(),
            *(_modality_table(file) for file in files),
        ],
    }


def _file_object(path: str, mime: str, sha256: str, size: int | None = None) -> dict:
    made = {
        "@type": "cr:FileObject",
        "@id": path,
        "name": path,
        "contentUrl": path,
        "encodingFormat": mime,
        "sha256": sha256,
    }
    return made if size is None else made | {"contentSize": f"{size} B"}


def _file_set(file: str, shards: list[Mapping]) -> dict:
    return {
        "@type": "cr:FileSet",
        "@id": file,
        "name": file,
        "description": _MODALITIES[file],
        "containedIn": [{"@id": shard["path"]} for shard in shards],
        "encodingFormat": _MIME[file.split(".")[1]],
        "includes": f"*.{file}",
    }


def _table(name: str, description: str, fields: list[dict], **more) -> dict:
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": description,
        "key": {"@id": fields[0]["@id"]},
        "field": fields,
        **more,
    }


def _field(name: str, kind: str, **more) -> dict:
    return {"@type": "cr:Field", "@id": name, "name": name, "dataType": kind, **more}


def _splits_table(splits: list[str]) -> dict:
    fields = [_field("splits/name", "sc:Text"), _field("splits/url", "sc:URL")]
    rows = [{"splits/name": split, "splits/url": _SPLITS[split]} for split in splits]
    told = "The values of pairs/split. No scene is in two splits."
    return _table("splits", told, fields, dataType="cr:Split", data=rows)


def _pairs_table() -> dict:
    fields = []
    for name, kind in {"key": str, "shard": str, **META_FIELDS}.items():
        source = {"fileObject": {"@id": INDEX}, "extract": {"column": name}}
        more = {"repeated": True} if kind is list else {}
        fields.append(_field(f"pairs/{name}", _TYPES[kind], source=source, **more))
    return _table("pairs", "A row a pair: all of its metadata, matrices row by row.", fields)


def _modality_table(file: str) -> dict:
    name, suffix = file.split(".")

    def source(file_property: str, **more) -> dict:
        return {"fileSet": {"@id": file}, "extract": {"fileProperty": file_property}, **more}

    key = source("filename", transform={"regex": r"^([^.]+)\."})
    kind = "sc:ImageObject" if suffix == "png" else "sc:Text"
    fields = [
        _field(f"{name}/key", "sc:Text", description="As in pairs/key.", source=key),
        _field(f"{name}/{name}", kind, source=source("content")),
    ]
    return _table(name, _MODALITIES[file], fields)
