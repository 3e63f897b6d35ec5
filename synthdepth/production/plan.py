"""The plan of a run: which scene gives which shard, and how many pairs of it are wanted."""

import dataclasses
import math
from collections.abc import Mapping

from synthdepth.errors import SynthdepthError
from synthdepth.seeding import derive_seed


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShardJob:
    """One scene to render into one shard.

    Attributes:
        scene_index: number of the scene within the dataset.
        scene_seed: what the scene is drawn from.
        split: "train" or "test".
        path: of the shard, relative to the dataset folder.
        pairs: how many of the scene's pairs are wanted, from its first.
        extends: the manifest's record of a shorter shard that is there already, if there is one.
    """

    scene_index: int
    scene_seed: int
    split: str
    path: str
    pairs: int
    extends: Mapping | None = None


def plan_shards(
    *, map_name: str, seed: int, pairs: int, pairs_per_scene: int, train_share: float
) -> list[ShardJob]:
    """The shards of a dataset of `pairs` pairs, in order.

    A longer plan with the same other arguments begins with the shorter one; only the last shard of
    the shorter one may hold fewer pairs. Whole scenes go to one split, spread evenly: with a train
    share of one half they alternate.

    Raises:
        SynthdepthError: the counts or the share cannot be.
    """
    if not 1 <= pairs <= 10_000_000:
        raise SynthdepthError(f"--pairs {pairs}: allowed is a whole number from 1 to 10000000")
    if not 0 <= train_share <= 1:
        raise SynthdepthError(f"--train-share {train_share}: allowed is a number from 0 to 1")
    if not 0 <= seed < 2**63:
        raise SynthdepthError(f"--seed {seed}: allowed is a whole number from 0 to 2^63 - 1")
    jobs, numbers = [], {"train": 0, "test": 0}
    for scene in range(math.ceil(pairs / pairs_per_scene)):
        is_train = math.ceil((scene + 1) * train_share) > math.ceil(scene * train_share)
        split = "train" if is_train else "test"
        jobs.append(
            ShardJob(
                scene_index=scene,
                scene_seed=derive_seed(seed, map_name, scene),
                split=split,
                path=f"{split}/{map_name}-{split}-{numbers[split]:06d}.tar",
                pairs=min(pairs_per_scene, pairs - scene * pairs_per_scene),
            )
        )
        numbers[split] += 1
    return jobs
