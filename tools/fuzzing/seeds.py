"""Small whole inputs of every kind, made once from a dataset; what is fed are broken copies."""

import dataclasses
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import torch

from fuzzing.mutations import toml_file
from synthdepth.airsim.pfm import write_pfm
from synthdepth.dataset.card import write_card
from synthdepth.dataset.checksums import with_files, write_checksums
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.exr import encode_channels
from synthdepth.dataset.manifest import read_manifest, write_index, write_manifest
from synthdepth.dataset.pair import encode_png
from synthdepth.dataset.pairs import PairDataset
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.shard import ShardWriter, read_members, shard_members
from synthdepth.export import export
from synthdepth.kitti.calibration import CAM_FROM_BODY
from synthdepth.kitti.png import encode_depth
from synthdepth.pix2pix.checkpoint import LAST, save_state
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.discriminator import DiscriminatorConfig
from synthdepth.pix2pix.generator import GeneratorConfig
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.pix2pix.onnx import export_onnx
from synthdepth.pix2pix.state import State
from synthdepth.production.recipe import load_recipe, scenes_folder
from synthdepth.seeding import lane
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.spent import Spent, spent_line
from synthdepth.simulate.store import FORMAT

_CAMERA = "width = 256\nheight = 144\nfov_deg = 90.0\nfocal_px = 200.5\ncx = 100.5\ncy = 70\n"
_SETTINGS = """{
  // a camera, as AirSim's documentation writes it
  "SettingsVersion": 1.2,
  "CameraDefaults": {"CaptureSettings": [{"ImageType": 0, "Width": %d, "Height": %d,
    "FOV_Degrees": 90}]},
  "Vehicles": {"Drone1": {"VehicleType": "SimpleFlight", "X": NaN, "Cameras": {
    "front": {"X": 0.5, "Y": -0.1, "Z": -0.2, "Pitch": -15, "Roll": 5.0, "Yaw": 20,},
  }}}
}"""
_RECORD = "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"


def make_seeds(root: Path, data: Path, model: Path | None) -> None:
    """Write all seeds below `root`; `data` is a dataset, `model` the folder of a training."""
    cut(data, root / "dataset")
    samples = list(PairDataset(root / "dataset"))
    shutil.copytree(scenes_folder(), root / "recipe")
    (root / "camera").mkdir()
    (root / "camera/camera.toml").write_text(_CAMERA)
    if model is None:
        _training(root / "training")
    else:
        shutil.copytree(model, root / "training")
    table = json.loads((root / "training/config.json").read_text())
    given = {name: value for name, value in table.items() if value is not None}
    (root / "training/config.toml").write_bytes(toml_file(given))
    (root / "onnx").mkdir()
    height, width = samples[0].rgb.shape[:2]
    export_onnx(root / "training", root / "onnx/model.onnx", size=(width, height))
    _predictions(root / "predictions", samples)
    _pictures(root / "pictures", samples)
    _kitti(root / "kitti", root / "dataset", samples[0])
    _airsim(root / "airsim", samples)
    _simulation(root / "simulation")


def cut(data: Path, out: Path, pairs: int = 2) -> None:
    """The first pairs of a shard of each split of a dataset, as a dataset."""
    manifest = read_manifest(data)
    records = {record["split"]: record for record in reversed(manifest["shards"])}
    for split, record in records.items():
        with ShardWriter(out / record["path"]) as writer:
            whole = shard_members(data / record["path"])
            for key in list(whole)[:pairs]:
                writer.add(key, read_members(data / record["path"], whole[key]))
        told = {"pairs": min(pairs, len(whole)), "bytes": writer.size, "sha256": writer.sha256}
        records[split] = record | told
    splits = {split: record["pairs"] for split, record in records.items()}
    manifest |= {"shards": list(records.values()), "splits": splits}
    manifest |= {"pairs_planned": sum(splits.values())}
    for write in (write_index, write_card, write_croissant):
        write(out, manifest)
    manifest = with_files(out, manifest)
    write_checksums(out, manifest)
    write_manifest(out, manifest)


def _training(out: Path) -> None:
    """A checkpoint of a tiny network, untrained."""
    out.mkdir()
    config = TrainConfig(
        input=InputConfig(kind="rgb"),
        generator=GeneratorConfig(ngf=1, depth=2),
        discriminator=DiscriminatorConfig(ndf=1, layers=1),
        ema=0.9,
    )
    facts = {"config": config.as_table(), "data": {"pairs": 2, "shards": ""}, "processes": 1}
    save_state(out / LAST, State(config, torch.device("cpu")), facts | {"folders": []})
    (out / "config.json").write_text(json.dumps(config.as_table(), indent=1))


def _predictions(out: Path, samples: Sequence[Sample]) -> None:
    """The same depth as each kind of file, in a folder a kind."""
    for kind in ("exr", "npy", "png"):
        (out / kind).mkdir(parents=True)
    for sample in samples:
        file = encode_channels({"depthUnit": "metre"}, {"Z": sample.depth_m})
        (out / "exr" / f"{sample.key}.depth.exr").write_bytes(file)
        np.save(out / "npy" / f"{sample.key}.npy", sample.depth_m)
        (out / "png" / f"{sample.key}.png").write_bytes(encode_depth(sample.depth_m))


def _pictures(out: Path, samples: Sequence[Sample]) -> None:
    """A folder of pictures of each suffix, and a video."""
    (out / "folder").mkdir(parents=True)
    for k, suffix in enumerate((".png", ".jpg", ".bmp", ".tif", ".webp")):
        cv2.imwrite(str(out / f"folder/{k}{suffix}"), samples[k % len(samples)].rgb)
    height, width = samples[0].rgb.shape[:2]
    code = cv2.VideoWriter.fourcc(*"MJPG")
    video = cv2.VideoWriter(str(out / "video.avi"), code, 10, (width, height))
    for k in range(4):
        video.write(samples[k % len(samples)].rgb)
    video.release()


def _kitti(out: Path, dataset: Path, sample: Sample) -> None:
    """Raw recordings and depth benchmark with scans, the selection and the object benchmark."""
    export("kitti", dataset, out / "depth")
    points = lane(0, "scan").uniform(-30, 30, (500, 4)).astype("<f4").tobytes()
    for drive in (out / "depth").glob("*/*_sync/oxts"):
        for oxts in (drive / "data").glob("*.txt"):
            _write(drive.parent / f"velodyne_points/data/{oxts.stem}.bin", points)
    rgb, depth = encode_png(sample.rgb), encode_depth(sample.depth_m)
    k = "40.0 0 31.5 0 40.0 23.5 0 0 1"
    for name in ("a", "b"):
        _write(out / f"selection/image/{name}.png", rgb)
        _write(out / f"selection/groundtruth_depth/{name}.png", depth)
        _write(out / f"selection/intrinsics/{name}.txt", k.encode())
    rigid = " ".join(" ".join(map(str, row)) + " 0.1" for row in CAM_FROM_BODY)
    lines = [f"P{c}: 40.0 0 31.5 2.0 0 40.0 23.5 0.1 0 0 1 0.005" for c in range(4)]
    lines += ["R0_rect: 1 0 0 0 1 0 0 0 1", f"Tr_velo_to_cam: {rigid}", f"Tr_imu_to_velo: {rigid}"]
    for name in ("000000", "000001"):
        _write(out / f"object/training/image_2/{name}.png", rgb)
        _write(out / f"object/training/prev_2/{name}_01.png", rgb)
        _write(out / f"object/training/velodyne/{name}.bin", points)
        _write(out / f"object/training/calib/{name}.txt", "\n".join(lines).encode())


def _airsim(out: Path, samples: Sequence[Sample]) -> None:
    """A recording and its settings.json."""
    (out / "rec/images").mkdir(parents=True)
    height, width = samples[0].rgb.shape[:2]
    (out / "settings.json").write_text(_SETTINGS % (width, height))
    text = _RECORD
    for k in range(4):
        sample = samples[k % len(samples)]
        names = [
            f"img_Drone1_front_{kind}_{1000 + k}{end}" for kind, end in ((0, ".png"), (1, ".pfm"))
        ]
        (out / "rec/images" / names[0]).write_bytes(encode_png(sample.rgb))
        write_pfm(out / "rec/images" / names[1], sample.depth_m, rows="top_first")
        text += f"Drone1\t{1000 + 100 * k}\t{0.5 * k}\t0\t-8\t1\t0\t0\t0\t{';'.join(names)}\n"
    (out / "rec/airsim_rec.txt").write_text(text)


def _simulation(out: Path) -> None:
    """What `simulate` leaves, as far as it is read again."""
    flight = {
        "map": "blocks",
        "scene_index": 0,
        "scene_seed": 7,
        "scenario": 0,
        "source": "blind",
        "end": "collision",
        "hit": "building",
        "hit_speed_mps": 10.5,
        "time_s": 3.5,
        "way_m": 35.0,
        "straight_m": 100.0,
        "shortest_m": 104.5,
        "left_m": 66.0,
        "goal_speed_mps": 9.0,
        "excess": None,
        "clearance_m": 0.0,
        "effort_m_s3": 12.5,
        "latency_s": 0.1,
        "speed_mps": 10.0,
        "blocked_by": "building",
        "start_m": [0.0, 0.0, 5.0],
        "goal_m": [100.0, 0.0, 5.0],
        "end_m": [35.0, 0.0, 5.0],
        "track_m": [[0.0, 0.0, 5.0], [35.0, 0.0, 5.0]],
    }
    lines = [json.dumps(flight | {"scenario": k}) for k in range(3)]
    _write(out / "scenes/blocks-s00000.jsonl", "".join(f"{line}\n" for line in lines).encode())
    _write(out / "flights.jsonl", "".join(f"{line}\n" for line in lines).encode())
    source = {"name": "blind", "what": "blind", "sha256": ""}
    settings = {"format": FORMAT, "map": "blocks", "seed": 0, "sources": {"blind": source}}
    settings |= {"rules": dataclasses.asdict(Rules()), "recipe": load_recipe("blocks").as_dict()}
    _write(out / "simulation.json", json.dumps(settings).encode())
    spent = spent_line("", Spent(build_s=1.5)) + spent_line("blind", Spent(flights=3, frames=10))
    _write(out / "times/blocks-s00000.jsonl", spent)
    facts = {
        "scene_index": 0,
        "condition": "clear",
        "low_m": [-10.0, -10.0],
        "high_m": [10.0, 10.0],
    }
    _write(out / "maps/blocks-s00000.json", json.dumps(facts).encode())
    picture = cv2.imencode(".jpg", np.full((20, 20, 3), 100, np.uint8))[1].tobytes()
    _write(out / "maps/blocks-s00000.jpg", picture)


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
