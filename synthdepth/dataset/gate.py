"""The consistency gate: whether the parts of a pair agree with each other, from its files alone.

No shard takes its name before every pair of it has passed, and `verify` asks again. A check that
finds no evidence (no texture, no light, no motion, no edges) gives no verdict. What single pairs
cannot tell is asked of a shard's pairs together: most faults of a renderer or of a format are in
every pair.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from synthdepth.dataset.gate_check import Check, mean_and_sigmas
from synthdepth.dataset.gate_contract import contract_checks
from synthdepth.dataset.gate_edges import edge_checks
from synthdepth.dataset.gate_warp import warp_checks
from synthdepth.dataset.pair import Pair

# So many pairs of a shard speak together at least. A check is failed if what speaks against the
# pairs is larger in the mean than its limit, and than that many standard errors over the pairs.
_LEAST_PAIRS, _SHARD_SIGMAS = 8, 3.5


def gate_pair(pair: Pair, record: Mapping, manifest: Mapping) -> list[Check]:
    """Every check of one pair.

    Args:
        pair: decoded.
        record: its shard's entry in the manifest: split, scene_index, scene_seed.
        manifest: the dataset's. What is imported (`source`) is not asked whether its pictures agree
            with its depth and poses: a recording's poses are as good as its clock, and things move.
    """
    checks = contract_checks(pair, record, manifest)
    if any(check.fault for check in checks) or "source" in manifest:
        return checks
    return checks + warp_checks(pair) + edge_checks(pair)


def gate_shard(pairs: Iterable[Sequence[Check]]) -> list[Check]:
    """What many pairs of a dataset say together, those of a shard say.

    Args:
        pairs: the checks of each pair, from `gate_pair`.

    Returns:
        The checks that many pairs fail together, though it may be that no single one does.
    """
    many: dict[tuple[str, str], list[Check]] = {}
    for checks in pairs:
        for check in checks:
            if check.limit is not None and check.effect is not None:
                many.setdefault((check.subject, check.name), []).append(check)
    failed = []
    for (subject, name), checks in many.items():
        if len(checks) < _LEAST_PAIRS:
            continue
        effect, sigmas = mean_and_sigmas(np.array([check.effect for check in checks]))
        if effect > checks[0].limit and sigmas > _SHARD_SIGMAS:
            told = f"{len(checks)} pairs together: {checks[0].told}"
            failed.append(
                Check(subject=subject, name=name, effect=effect, sigmas=sigmas, fault=told)
            )
    return failed
