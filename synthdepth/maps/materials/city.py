"""What city buildings are made of: ashlar, cladding, coated glass, signs, far façades."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    courses,
    doubled,
    encode,
    encode_neutral,
    encode_with_mean,
    fractal_noise,
    smoothstep,
    texel_grid,
    tones,
    worley,
)
from synthdepth.maps.world import Material

Rng = np.random.Generator


def _stone(rng: Rng) -> Material:
    """Ashlar: blocks in courses of 0.4 m, fine joints, rain-washed; neutral."""
    shape, rows, columns = (512, 512), 12, 6
    course_m, block_m = float(rng.uniform(0.34, 0.45)), float(rng.uniform(0.8, 1.1))
    block = courses(rng, shape, rows, columns, 0.5 * (np.arange(rows) % 2), 0.25)
    stain = fractal_noise(rng, shape, (1, 40), 0.5)
    streak = fractal_noise(rng, shape, (3, 60), 0.4, stretch=(1, 9))
    grain = fractal_noise(rng, shape, (60, 256), 0.1)
    bed = fractal_noise(rng, shape, (6, 90), 0.3, stretch=(7, 1))
    up_m = np.minimum(block.up, 1 - block.up) * course_m
    joint_m = np.minimum(block.side * block_m, up_m) + 0.0012 * grain
    joint = smoothstep(joint_m, 0.011, 0.005)
    shades = tones(rng, rows * columns, rng.uniform(0.03, 0.07), 0.018).take(block.index, axis=0)
    soot = smoothstep(stain + 0.5 * streak, 0.5, 2.6) * rng.uniform(0.1, 0.4)
    light = (1 + 0.045 * stain + 0.03 * streak + 0.045 * grain + 0.025 * bed) * (1 - 0.42 * joint)
    relative = shades * light[..., None] * blend([1, 1, 1], [0.6, 0.58, 0.55], soot)
    size_m = (columns * block_m, rows * course_m)
    return Material(texture=encode_neutral(relative), size_m=size_m)


def _cladding(rng: Rng) -> Material:
    """Composite or sheet-metal panels with open joints; neutral."""
    shape, n = (512, 512), 6
    wide_m, high_m = float(rng.choice([0.9, 1.2, 1.5])), float(rng.choice([0.6, 0.8, 1.2]))
    panel = courses(rng, shape, n, n, 0.0)
    up_m = np.minimum(panel.up, 1 - panel.up) * high_m
    side_m = panel.side * wide_m
    joint = smoothstep(np.minimum(side_m, up_m), 0.013, 0.006)
    shades = tones(rng, n * n, rng.uniform(0.01, 0.035), 0.006).take(panel.index, axis=0)
    dent = fractal_noise(rng, shape, (2, 12), 0.6)
    film = fractal_noise(rng, shape, (2, 60), 0.4, stretch=(1, 8))
    grain = fractal_noise(rng, shape, (60, 200), 0.2)
    # Drips below each joint.
    drip = smoothstep(1 - panel.up, 0.5, 0.0) * smoothstep(film, 0.2, 2.4)
    light = 1 + 0.02 * dent + 0.02 * film + 0.012 * grain
    light *= (1 - 0.55 * joint) * (1 - 0.12 * drip)
    relative = shades * light[..., None]
    return Material(texture=encode_neutral(relative), size_m=(n * wide_m, n * high_m))


def _roof_felt(rng: Rng) -> Material:
    """Bitumen sheets a metre wide with lapped seams, ponding stains and patches."""
    shape, rows, size_m = (512, 512), 8, 8.0
    sheet = courses(rng, shape, rows, 1, shift=rng.random(rows), irregular=0.5)
    grit = fractal_noise(rng, shape, (90, 256), 0.0)
    stain = fractal_noise(rng, shape, (1, 50), 0.5)
    pond = fractal_noise(rng, shape, (2, 30), 0.6)
    wobble = 0.004 * fractal_noise(rng, shape, (3, 40), 0.4)
    seam_m = (1 - sheet.up) * (size_m / rows) + wobble
    end_m = sheet.side * size_m + wobble
    seam = smoothstep(np.abs(seam_m - 0.03), 0.022, 0.008)
    end = smoothstep(np.abs(end_m - 0.03), 0.03, 0.008)
    tar = np.maximum(seam, end) * rng.uniform(0.3, 0.6)
    # Dust dries in rings where puddles stood.
    ring = smoothstep(np.abs(pond - 0.9), 0.5, 0.02) * 0.09
    silt = smoothstep(pond, 0.5, 2.2) * 0.22
    shades = tones(rng, rows, 0.05, 0.01)[sheet.row[:, 0]][:, None]
    light = (1 + 0.06 * grit + 0.06 * stain + ring + silt) * (1 - tar)
    mean = rng.uniform(0.08, 0.2) * np.array([1.0, 1.0, 0.98 + rng.uniform(-0.04, 0.06)])
    texture = encode_with_mean(shades * light[..., None], mean)
    return Material(texture=texture, size_m=(size_m, size_m))


def _coated_glass(rng: Rng) -> Material:
    """Sun-control glass: what little light comes back from inside."""
    shape = (128, 128)
    room = fractal_noise(rng, shape, (1, 6), 0.5)
    mean = rng.uniform(0.018, 0.03) * np.array([0.92, 1.0, 1.05])
    texture = encode_with_mean(np.exp(0.25 * room), mean)
    return Material(texture=texture, size_m=(6.1, 5.3), kind="coated_glass", roughness=0.03)


def _curtained_glass(rng: Rng) -> Material:
    """A pane with a curtain or slats behind it; neutral."""
    shape = (256, 256)
    fold = fractal_noise(rng, shape, (6, 40), 0.3, stretch=(1, 14))
    cloth = fractal_noise(rng, shape, (1, 12), 0.4)
    relative = 1 + 0.1 * fold + 0.05 * cloth
    texture = encode_neutral(relative)
    return Material(texture=texture, size_m=(4.1, 4.1), kind="glass", roughness=0.02)


# The tile of a far façade: bays by storeys, each 3.15 m in texture space.
FAR_BAYS, FAR_STOREYS, FAR_CELL_M = 6, 6, 3.15


def _facade_windows(rng: Rng) -> Material:
    """Walls with windows seen from afar, one window a cell; neutral."""
    shape, rows, columns = (384, 384), FAR_STOREYS, FAR_BAYS
    u, v = texel_grid(shape)
    across, up = np.abs(u * columns % 1 - 0.5), v * rows % 1
    index = (v * rows).astype(int) * columns + (u * columns).astype(int)
    inside = smoothstep(across, 0.31, 0.28) * smoothstep(np.abs(up - 0.56), 0.3, 0.27)
    bar = smoothstep(across, 0.012, 0.03)
    sky = smoothstep(up, 0.3, 0.85)
    room = rng.uniform(0.06, 0.22, rows * columns).astype(np.float32)
    curtain = rng.random(rows * columns) < 0.22
    room[curtain] = rng.uniform(0.3, 0.6, curtain.sum())
    pane = (room.take(index) * (0.8 + 0.5 * sky))[..., None] * np.float32([0.9, 1.0, 1.1])
    stain = fractal_noise(rng, shape, (1, 40), 0.4)
    streak = fractal_noise(rng, shape, (3, 50), 0.4, stretch=(1, 7))
    wall = 1 + 0.05 * stain + 0.04 * streak
    sill = smoothstep(np.abs(up - 0.25), 0.03, 0.01) * smoothstep(across, 0.35, 0.31)
    wall = wall * (1 + 0.2 * sill) * (1 - 0.12 * smoothstep(np.abs(up - 0.02), 0.05, 0.01))
    relative = wall[..., None] + (pane - wall[..., None]) * (inside * bar)[..., None]
    size_m = (columns * FAR_CELL_M, rows * FAR_CELL_M)
    return Material(texture=encode(0.8 * relative), size_m=size_m)


def _facade_glass(rng: Rng) -> Material:
    """Curtain walls seen from afar, cells as in `facade_windows`: two panes and a spandrel."""
    shape, rows, columns = (384, 384), FAR_STOREYS, FAR_BAYS
    u, v = texel_grid(shape)
    across, up = u * columns * 2 % 1, v * rows % 1
    index = (v * rows).astype(int) * columns * 2 + (u * columns * 2).astype(int)
    spandrel = smoothstep(np.abs(up - 0.14), 0.15, 0.12)
    mullion = smoothstep(np.abs(across - 0.5), 0.4, 0.5)
    room = np.exp(0.35 * rng.standard_normal(2 * rows * columns, np.float32))
    blind = rng.random(2 * rows * columns) < 0.15
    room[blind] *= 4
    dirt = 1 + 0.05 * fractal_noise(rng, shape, (1, 30), 0.4)
    pane = 0.028 * room.take(index)
    value = pane + (0.05 - pane) * spandrel
    value = (value + (0.1 - value) * mullion) * dirt
    texture = encode(value[..., None] * np.float32([0.94, 1.0, 1.06]))
    size_m = (columns * FAR_CELL_M, rows * FAR_CELL_M)
    return Material(texture=texture, size_m=size_m, kind="coated_glass", roughness=0.03)


# Rows of the fascia boards' texture and their height [m]; posters in columns and rows of a square.
SIGN_ROWS, SIGN_ROW_M = 8, 0.8
POSTER_COLUMNS, POSTER_ROWS, POSTER_M = 4, 2, 3.2
_GROUNDS = np.float32(
    [
        [0.03, 0.035, 0.05], [0.5, 0.49, 0.46], [0.24, 0.035, 0.03], [0.03, 0.09, 0.06],
        [0.04, 0.07, 0.2], [0.42, 0.3, 0.06], [0.1, 0.09, 0.085], [0.3, 0.12, 0.04],
        [0.08, 0.16, 0.18], [0.36, 0.34, 0.3], [0.16, 0.05, 0.1], [0.55, 0.55, 0.55],
    ]
)  # fmt: skip


def _lettering(rng: Rng, width: int, height: int) -> np.ndarray:
    """(height, width) bool: a line of made-up letters, strokes on a 4 x 5 grid; rows from top."""
    line = np.zeros((height, width), bool)
    dot = max(2, height // 6 // 2 * 2)
    x = dot
    while x + 5 * dot < width:
        if rng.random() < 0.14:
            x += 3 * dot
            continue
        glyph = np.zeros((5, 4), bool)
        glyph[:, 0] = rng.random() < 0.75
        glyph[:, 3] = rng.random() < 0.5
        for row in (0, 2, 4):
            glyph[row, :] |= rng.random() < 0.6
        if glyph.sum() < 5:
            glyph[:, 1] = True
        letter = glyph.repeat(dot, axis=0).repeat(dot, axis=1)[: height - 1]
        line[: letter.shape[0], x : x + 4 * dot] = letter
        x += 5 * dot
    return line


def _signboard(rng: Rng) -> Material:
    """Fascia boards with lettering, one a row of 0.8 m."""
    row_px, width = 32, 512
    picture = np.empty((SIGN_ROWS * row_px, width, 3), np.float32)
    order = rng.permutation(len(_GROUNDS))
    for k in range(SIGN_ROWS):
        ground = _GROUNDS[order[k]]
        ink = np.float32([0.6, 0.59, 0.55] if ground.mean() < 0.25 else [0.04, 0.04, 0.05])
        row = np.broadcast_to(ground, (row_px, width, 3)).copy()
        row[8:24][_lettering(rng, width, 16)] = ink
        # Same rim on all, so that the tile closes.
        row[:2], row[-2:] = 0.06, 0.06
        picture[k * row_px : (k + 1) * row_px] = row
    dirt = 1 + 0.03 * fractal_noise(rng, picture.shape[:2], (2, 80), 0.4)
    return Material(
        texture=encode(picture * dirt[..., None]),
        size_m=(width * 0.025, SIGN_ROWS * SIGN_ROW_M),
    )


def _poster(rng: Rng) -> Material:
    """Advertising: blocks of colour, a soft picture and a few lines of lettering, 3.2 m square."""
    cell, rows, columns = 128, POSTER_ROWS, POSTER_COLUMNS
    picture = np.empty((rows * cell, columns * cell, 3), np.float32)
    order = rng.permutation(len(_GROUNDS))
    for k in range(rows * columns):
        ground = _GROUNDS[order[k % len(order)]]
        blob = doubled(fractal_noise(rng, (cell // 2, cell // 2), (1, 6), 0.6))
        other = _GROUNDS[int(rng.integers(len(_GROUNDS)))]
        page = blend(ground, other, smoothstep(blob, 0.1, 0.35))
        third = _GROUNDS[int(rng.integers(len(_GROUNDS)))]
        page = blend(page, third, smoothstep(blob, 1.0, 1.1))
        top = 2 * int(rng.integers(5, 25))
        band = page[top : top + 28, 10:118]
        ink = 0.6 if band.mean() < 0.25 else 0.05
        band[_lettering(rng, 108, 28)] = ink
        low = page[104:116, 10:118]
        low[_lettering(rng, 108, 12)] = 0.6 if low.mean() < 0.25 else 0.05
        page[:2], page[-2:], page[:, :2], page[:, -2:] = 0.4, 0.4, 0.4, 0.4
        r, c = divmod(k, columns)
        picture[r * cell : (r + 1) * cell, c * cell : (c + 1) * cell] = page
    fade = 1 + 0.03 * fractal_noise(rng, picture.shape[:2], (2, 60), 0.4)
    size_m = (columns * POSTER_M, rows * POSTER_M)
    return Material(texture=encode(picture * fade[..., None]), size_m=size_m)


def _netting(rng: Rng) -> Material:
    """Debris netting in sheets of 1.8 m, sagging, seamed and dusty; neutral."""
    shape, rows = (256, 256), 2
    _, v = texel_grid(shape)
    sag = 0.06 * fractal_noise(rng, shape, (1, 5), 0.4)
    seam = smoothstep(np.abs((v * rows + sag) % 1 - 0.5), 0.03, 0.01)
    fold = fractal_noise(rng, shape, (2, 20), 0.5, stretch=(1, 4))
    weave = fractal_noise(rng, shape, (60, 128), 0.0)
    hole = smoothstep(worley(rng, shape, (9, 9)).centre, 0.16, 0.08) * 0.15
    relative = (1 + 0.1 * fold + 0.05 * weave) * (1 - 0.3 * seam) * (1 - hole)
    return Material(texture=encode_neutral(relative), size_m=(3.6, 3.6))


CITY: dict[str, Callable[[Rng], Material]] = {
    "stone": _stone,
    "cladding": _cladding,
    "roof_felt": _roof_felt,
    "coated_glass": _coated_glass,
    "curtained_glass": _curtained_glass,
    "facade_windows": _facade_windows,
    "facade_glass": _facade_glass,
    "signboard": _signboard,
    "poster": _poster,
    "netting": _netting,
}
