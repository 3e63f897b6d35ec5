"""How a tree grows: trunk, branches and the places of its leaf clumps, before any mesh.

A crown is grown towards puffs of foliage spread in the species' envelope, each joined by a curved
branch to the nearest limb below it: the silhouette is the species', the gaps are the tree's.
"""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import cross
from synthdepth.maps.vegetation.foliage import arcs, directions, unit
from synthdepth.maps.vegetation.species import Species, Tree, species_named
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wood:
    """Branches of one order: arguments of `tapers`."""

    path: np.ndarray
    radius_m: np.ndarray
    tint: np.ndarray


@dataclasses.dataclass(frozen=True, kw_only=True)
class Crown:
    """Leaf clumps or twigs: arguments of `clumps`, in an order that any stride thins evenly."""

    centre: np.ndarray
    along: np.ndarray
    normal: np.ndarray
    length_m: np.ndarray
    width_m: np.ndarray
    tint: np.ndarray
    skew: np.ndarray


def _trunk(rng: np.random.Generator, tree: Tree, kind: Species) -> Wood:
    top = kind.stem * tree.height_m
    r = tree.trunk_radius_m
    rows = np.linspace(0.12 * top, top, 12 if kind.peeling or kind.habit == "fronds" else 7)
    z = np.concatenate([[-0.35, 0.0, 0.6 * r, 1.8 * r], rows[rows > 3.0 * r]])
    up = np.clip(z / top, 0, 1)
    sway = (0.1 if kind.habit == "fronds" else 0.02) * tree.height_m * rng.normal(size=2)
    bend = np.sin(up * rng.uniform(1.5, 3.0)) ** 2 * up
    path = np.column_stack([sway[0] * bend, sway[1] * bend, z])
    thin = 0.8 if kind.habit == "fronds" else 0.15
    radius = r * (1 - (1 - thin) * up) * (1 + 0.55 * np.exp(-np.maximum(z, 0) / (0.9 * r)))
    tint = np.array(tree.bark_tint) * rng.uniform(0.85, 1.1, (len(z), 1))
    if kind.peeling:
        scar = rng.random((len(z), 1)) < np.where(z[:, None] < 0.7, 0.7, 0.3)
        tint = np.where(scar, tint * 0.35, tint)
    tint = tint * np.where(z < 0.3, 0.7, 1.0)[:, None]
    return Wood(path=path[None], radius_m=radius[None, :-1], tint=tint[None])


def _on_trunk(trunk: Wood, z: np.ndarray) -> np.ndarray:
    p = trunk.path[0]
    return np.column_stack([np.interp(z, p[:, 2], p[:, axis]) for axis in range(3)])


def _bark(rng: np.random.Generator, tree: Tree, kind: Species, count: int) -> np.ndarray:
    """Tints (count, 1, 3) of branches: darker than the trunk where that is white."""
    shade = rng.uniform(0.75, 1.05, (count, 1, 1)) * (0.3 if kind.peeling else 0.9)
    return np.array(tree.bark_tint) * shade


def _puffs(rng: np.random.Generator, tree: Tree, kind: Species) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) and radii (n,) of the puffs of a crown [m]."""
    n = kind.puffs
    depth = tree.height_m - tree.clear_m
    grid = np.linspace(0, 1, 65)
    outline = np.interp(grid, np.linspace(0, 1, 5), kind.profile)
    share = np.cumsum(outline**1.6)
    order = rng.permutation(n)
    h = np.interp((np.arange(n) + rng.uniform(0.2, 0.8, n)) / n, share / share[-1], grid)
    turn = 2.399963 * np.arange(n) + rng.normal(0, 0.35, n) + rng.uniform(0, 6.3)
    lobes = rng.uniform(0, 6.3, 3)
    uneven = 1 + 0.14 * np.sin(turn + lobes[0] + 2 * h) + 0.1 * np.sin(3 * turn + lobes[1] - 4 * h)
    edge = tree.crown_radius_m * np.interp(h, grid, outline) * uneven
    # A puff's share of the crown's volume, then room to overlap.
    volume = np.pi * tree.crown_radius_m**2 * depth * np.mean(outline**2)
    radius = 0.78 * (volume / n / 4.2 / kind.flat) ** (1 / 3) * rng.uniform(0.75, 1.35, n)
    radius = np.minimum(radius, 0.75 * tree.crown_radius_m)
    reach = np.maximum(edge - 0.75 * radius, 0) * np.sqrt(rng.uniform(0.12, 1.0, n))
    z = tree.clear_m + h * depth
    z = np.clip(z, tree.clear_m + 0.6 * radius * kind.flat, tree.height_m - radius * kind.flat)
    centre = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), z])
    return centre[order], radius[order]


def _branches(
    rng: np.random.Generator, tree: Tree, kind: Species, trunk: Wood, puff: np.ndarray
) -> list[Wood]:
    """Limbs to the first puffs, branches to the others from the nearest wood below them."""

    def curve(start, end, segments):
        reach = end - start
        control = start + 0.5 * reach + 0.1 * reach[:, :1] * rng.normal(size=(len(end), 3))
        control[:, 2] += kind.arch * np.linalg.norm(reach, axis=1)
        return arcs(start, control, end, segments)

    def wood(path, base):
        taper = np.linspace(1, 0.4, path.shape[1] - 1)
        return Wood(
            path=path, radius_m=base[:, None] * taper, tint=_bark(rng, tree, kind, len(path))
        )

    top = trunk.path[0, -1, 2]
    low = min(0.85 * tree.clear_m, 0.8 * top)

    def root(end):
        rise = kind.rise * rng.uniform(0.7, 1.3, len(end)) * np.hypot(end[:, 0], end[:, 1])
        return _on_trunk(trunk, np.clip(end[:, 2] - rise, low, 0.97 * top))

    end = puff[: kind.limbs]
    limbs = curve(root(end), end, 3)
    rest = puff[kind.limbs :]
    start = root(rest)
    if kind.limbs:
        fine = np.concatenate([limbs[:, 1:-1], (limbs[:, 1:-1] + limbs[:, 2:]) / 2], axis=1)
        fine = np.concatenate([fine.reshape(-1, 3), start])
        gap = rest[:, None] - fine[None]
        cost = np.linalg.norm(gap, axis=-1) + 1.5 * np.maximum(0, 0.3 - gap[..., 2])
        start = fine[np.argmin(cost, axis=1)]
    # What foliage hides may be straight.
    twigs = curve(start, rest, 2 if kind.leafless or kind.flat < 0.5 else 1)
    r = tree.trunk_radius_m
    length = np.linalg.norm(rest - start, axis=1)
    thick = np.minimum(0.35 * r, (0.022 if kind.leafless else 0.012) + 0.014 * length)
    return [
        wood(limbs, r * rng.uniform(0.38, 0.58, len(limbs))),
        wood(twigs, thick),
    ]


def _foliage(
    rng: np.random.Generator, tree: Tree, kind: Species, puff: np.ndarray, radius: np.ndarray
) -> Crown:
    weight = radius**2 * rng.uniform(0.7, 1.3, len(radius))
    count = np.maximum(np.round(kind.clumps * weight / weight.sum()), 1).astype(int)
    owner = np.repeat(np.arange(len(puff)), count)
    k = len(owner)
    out = unit(directions(rng, k) + [0, 0, 0.25])
    # Shoots end near the puff's surface; what is deep inside is never seen.
    far = rng.random(k) ** 0.4
    offset = out * (far * radius[owner])[:, None] * [1, 1, kind.flat]
    centre = puff[owner] + offset
    side = centre * [1, 1, 0] / tree.crown_radius_m
    normal = unit(0.8 * out + 0.5 * side + [0, 0, 0.35] + 0.65 * directions(rng, k))
    along = unit(kind.bristle * 1.6 * (out + [0, 0, 0.25]) + directions(rng, k) - [0, 0, 0.3])
    if kind.bristle:
        normal = directions(rng, k)
    if kind.hang_m:
        shoot = kind.hang_m * rng.random(k) * rng.uniform(0.5, 1.3, len(puff))[owner]
        drop = np.minimum(shoot, np.maximum(centre[:, 2] - 0.15 * tree.height_m, 0))
        centre[:, 2] -= drop
        limp = np.clip(drop / 1.0, 0, 1)[:, None]
        along = unit(along * (1 - 0.75 * limp) - limp * [0, 0, 1])
        normal = unit(normal - limp * [0, 0, 0.3])
    # Inside and underneath less light arrives than four bounces carry, and older leaves are dark.
    deep = np.hypot(centre[:, 0], centre[:, 1]) / tree.crown_radius_m
    high = (centre[:, 2] - tree.clear_m) / (tree.height_m - tree.clear_m)
    lit = np.clip(0.5 + 0.3 * far + 0.2 * np.maximum(deep, high), 0.5, 1.0)
    return _crown(rng, tree, kind, centre, along, normal, lit, owner, 1.7 - 0.85 * far)


def _twigs(rng: np.random.Generator, tree: Tree, kind: Species, branches: list[Wood]) -> Crown:
    """Bare twigs along the outer parts of all branches, and twigs on half of these."""
    roots, heads, owners = [], [], []
    count = kind.clumps // 2
    for wood in branches:
        b, s, _ = wood.path.shape
        pick = rng.integers(b, size=count // len(branches))
        at = rng.uniform(0.4, 1.0, len(pick)) ** 0.8 * (s - 1) * 0.999
        i, part = at.astype(int), (at % 1)[:, None]
        a, c = wood.path[pick, i], wood.path[pick, i + 1]
        roots.append(a + part * (c - a))
        heads.append(unit(c - a))
        owners.append(pick)
    root, head, owner = (np.concatenate(x) for x in (roots, heads, owners))
    along = unit(head + 0.8 * directions(rng, len(root)) + [0, 0, 0.1])
    fork = root + kind.clump_m[0] * rng.uniform(0.1, 0.6, (len(root), 1)) * along
    root, owner = np.concatenate([root, fork]), np.concatenate([owner, owner])
    along = np.concatenate([along, unit(along + 0.7 * directions(rng, len(fork)))])
    mixed = rng.permutation(len(root))
    root, along, owner = root[mixed], along[mixed], owner[mixed]
    # No gap at the root, however short the twig is drawn.
    centre = root + 0.35 * kind.clump_m[0] * along
    k = len(root)
    # A clump starts as a point: turned about, it is the twig's tip.
    return _crown(
        rng, tree, kind, centre, -along, directions(rng, k), np.ones(k), owner, np.ones(k)
    )


def _crown(rng, tree, kind, centre, along, normal, lit, owner, size) -> Crown:
    """Clumps with their sizes and shades; `lit` (k,) darkens, `owner` (k,) is the branch."""
    k = len(centre)
    branch = rng.normal(1.0, [0.1, 0.06, 0.1], (owner.max() + 1, 3))[owner]
    own = rng.normal(1.0, 0.13, (k, 1)) * rng.normal(1.0, [0.07, 0.03, 0.08], (k, 3))
    size = size * rng.uniform(0.7, 1.3, k)
    return Crown(
        centre=centre,
        along=along,
        normal=normal,
        length_m=kind.clump_m[0] * size,
        width_m=kind.clump_m[1] * size * rng.uniform(0.8, 1.2, k),
        tint=np.array(tree.leaf_tint) * np.clip(branch * own, 0.5, 1.6) * lit[:, None],
        skew=rng.uniform(-0.16, 0.16, k),
    )


def _whorls(rng: np.random.Generator, tree: Tree, kind: Species, trunk: Wood):
    """Tiers of branches that sag with age, tips turned up, sprays of needles along them."""
    n = kind.puffs
    depth = tree.height_m - tree.clear_m
    h = np.sort(rng.uniform(0.6, 1.4, n).cumsum() / n) * 0.985
    h = 1 - (1 - h / max(h[-1], 1) * 0.985) ** 0.85
    turn = 2.399963 * np.arange(n) + rng.normal(0, 0.25, n)
    reach = tree.crown_radius_m * np.interp(h, np.linspace(0, 1, 5), kind.profile)
    reach = np.maximum(reach * rng.uniform(0.78, 1.12, n), 0.12)
    heading = np.column_stack([np.cos(turn), np.sin(turn)])
    sag = reach * (0.42 * (1 - h) - 0.3 * h**2)
    # The lowest rest on the ground rather than grow into it.
    sag = np.minimum(sag, tree.clear_m + h * depth - 0.35)
    root = _on_trunk(trunk, tree.clear_m + h * depth)
    tip = root + np.column_stack([heading * reach[:, None], -sag])
    elbow = root + np.column_stack([heading * 0.6 * reach[:, None], -0.85 * sag - 0.08 * reach])
    path = arcs(root, elbow, tip, 1)
    base = np.minimum(0.012 + 0.012 * reach, 0.3 * tree.trunk_radius_m)
    wood = Wood(path=path, radius_m=base[:, None], tint=_bark(rng, tree, kind, n))

    count = np.maximum(np.round(kind.clumps * reach / reach.sum()), 2).astype(int)
    owner = np.repeat(np.arange(n), count)
    k = len(owner)
    t = np.clip(
        (np.arange(k) - np.repeat(count.cumsum() - count, count) + 0.7) / count[owner], 0, 1
    )
    t = 0.04 + 0.96 * t
    a, b = root[owner], tip[owner]
    c = elbow[owner]
    s = t[:, None]
    on = (1 - s) ** 2 * a + 2 * s * (1 - s) * c + s**2 * b
    ahead = unit((1 - s) * (c - a) + s * (b - c))
    across = np.column_stack([-heading[owner, 1], heading[owner, 0], np.zeros(k)])
    hand = rng.choice([-1.0, 1.0], k)[:, None] * rng.uniform(0.2, 1.0, (k, 1)) * (1.15 - 0.8 * s)
    along = unit(ahead + across * hand - [0, 0, 0.45] + 0.25 * directions(rng, k))
    length = kind.clump_m[0] * (0.45 + 0.55 * reach[owner] / tree.crown_radius_m)
    centre = on + 0.42 * length[:, None] * along * [1, 1, 0.6]
    centre[:, 2] = np.maximum(centre[:, 2], 0.35)
    normal = unit([0, 0, 0.8] + 0.9 * directions(rng, k) + 0.5 * heading[owner] @ np.eye(2, 3))
    lit = 0.55 + 0.45 * t
    size = length / kind.clump_m[0] * (1.35 - 0.35 * t)
    return wood, _crown(rng, tree, kind, centre, along, normal, lit, owner, size)


def _fronds(rng: np.random.Generator, tree: Tree, kind: Species, trunk: Wood):
    """Arching fronds with leaflets on both sides; the oldest hang dry against the trunk."""
    n = kind.puffs
    top = trunk.path[0, -1] - [0, 0, 0.15]
    age = np.linspace(0, 1, n)
    turn = 2.399963 * np.arange(n) + rng.normal(0, 0.15, n)
    length = 1.25 * tree.crown_radius_m * rng.uniform(0.85, 1.1, n) * (1 - 0.25 * age)
    pitch = np.radians(78 - 115 * age + rng.normal(0, 6, n))
    heading = np.column_stack([np.cos(turn), np.sin(turn)])
    lift = np.column_stack([heading * np.cos(pitch)[:, None], np.sin(pitch)])
    elbow = top + 0.55 * length[:, None] * lift
    fall = np.column_stack([heading * np.cos(pitch - 1.15)[:, None], np.sin(pitch - 1.15)])
    tip = elbow + 0.55 * length[:, None] * fall
    path = arcs(np.broadcast_to(top, (n, 3)), elbow, tip, 4)
    dry = age > 0.86
    green = np.array(tree.leaf_tint) * 1.25
    stalk = np.where(dry[:, None], [0.16, 0.12, 0.075], green)[:, None]
    wood = Wood(path=path, radius_m=np.full((n, 1), 0.035) * [1, 0.8, 0.6, 0.4], tint=stalk)

    each = kind.clumps // n
    owner = np.repeat(np.arange(n), each)
    k = len(owner)
    t = np.tile((np.arange(each) + 0.5) / each, n)
    t = 0.16 + 0.84 * t
    s = t[:, None]
    a, b, c = np.broadcast_to(top, (k, 3)), tip[owner], elbow[owner]
    on = (1 - s) ** 2 * a + 2 * s * (1 - s) * c + s**2 * b
    ahead = unit((1 - s) * (c - a) + s * (b - c))
    hand = np.tile(np.where(np.arange(each) % 2, -1.0, 1.0), n)[:, None]
    across = np.column_stack([-heading[owner, 1], heading[owner, 0], np.zeros(k)])
    along = unit(0.75 * ahead + across * hand - [0, 0, 0.35] + 0.12 * directions(rng, k))
    size = np.sin(np.pi * (0.12 + 0.8 * t)) ** 0.7 * (0.75 + 0.05 * tree.crown_radius_m)
    centre = on + 0.45 * (kind.clump_m[0] * size)[:, None] * along
    normal = unit(cross(ahead, across) + 0.3 * directions(rng, k))
    normal *= np.where(normal[:, 2:] < 0, -1, 1)
    lit = np.where(age[owner] < 0.3, 1.05, 1 - 0.35 * age[owner])
    crown = _crown(rng, tree, kind, centre, along, normal, lit, owner, size)
    brown = rng.uniform(0.7, 1.2, (k, 1)) * [0.2, 0.15, 0.09]
    return wood, dataclasses.replace(crown, tint=np.where(dry[owner][:, None], brown, crown.tint))


def grow(tree: Tree) -> tuple[list[Wood], Crown]:
    """Trunk and branches, coarsest first, and the leaf clumps."""
    kind = species_named(tree.species)
    rng = lane(tree.seed, "tree")
    trunk = _trunk(rng, tree, kind)
    if kind.habit == "whorls":
        branches, crown = _whorls(rng, tree, kind, trunk)
        return [trunk, branches], crown
    if kind.habit == "fronds":
        stalks, crown = _fronds(rng, tree, kind, trunk)
        return [trunk, stalks], crown
    puff, radius = _puffs(rng, tree, kind)
    branches = _branches(rng, tree, kind, trunk, puff)
    if kind.leafless:
        return [trunk, *branches], _twigs(rng, tree, kind, branches)
    return [trunk, *branches], _foliage(rng, tree, kind, puff, radius)
