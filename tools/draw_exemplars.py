#!/usr/bin/env python3
"""Draws the exemplars and meshes of the gallery's texture maps: tileable images and three OBJ files.

    tools/draw_exemplars.py -o FOLDER

`zebra.png` is 64 × 64 texels of dark stripes that fork. `wicker.png` is 64 × 64 texels of woven rods with holes between them
(alpha) and `wicker-height.png` their height. `stones.png`, `stones-height.png` and `stones-normal.png` are 96 × 96
texels of round stones; normals have green up, and heights from 0 to 1 stand for STONE_DEPTH texels. `cross.obj` is
a rounded 3D cross three units wide, `ball.obj` a sphere of radius 1. With `--relit N`, `stones-relit/` is a capture of the
stones under N lights, each lit by its normals. Of progressively-variant textures these are the beginnings, 96 × 96 texels each:
`leopard.png`, rosettes with a brown inside; `giraffe.png`, brown patches in pale gaps; `pale.png` and `red.png`, two marbles with
veins, thin and dark in the first, wide and bright in the second. Isotropic textures, 96 × 96 texels each, are `rust.png`, pitted metal with
patches of rust; `water.png`, lines of light on the ground of a pool; `burl.png`, wood whose grain runs round eyes; and `candy.png`, sweets of six colours. `globe.obj` is a sphere of 2,048
triangles in two colours.

Needs: pip install numpy pillow
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

STONE_DEPTH = 6.0
# Quads along a cube's edge of the cross, and rounds of smoothing.
CROSS_CUTS, CROSS_ROUNDS = 12, 12
BALL_CUTS = 32
GLOBE_CUTS = 4


def smooth_step(low, high, value):
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def noise(size, keep, random):
    """Periodic noise of deviation 1 with the amplitudes keep(kx, ky) of its frequencies."""
    k = np.fft.fftfreq(size, 1.0 / size)
    spectrum = np.fft.fft2(random.standard_normal((size, size))) * keep(*np.meshgrid(k, k))
    values = np.fft.ifft2(spectrum).real
    return (values - values.mean()) / values.std()


def fine(size, width, random):
    """Periodic noise of features about `width` texels wide."""
    return noise(size, lambda x, y: np.exp(-((x**2 + y**2) * (width / size) ** 2) * 2.0), random)


def zebra(size, random):
    """Stripes along y about nine texels apart."""
    along = lambda x, y: np.exp(-(((np.hypot(x, y) - size / 9.0) / 1.6) ** 2) - (np.arctan2(y, np.abs(x)) / 0.42) ** 2)
    dark = smooth_step(-0.25, 0.25, noise(size, along, random))[..., None]
    tint = 1.0 + 0.05 * fine(size, 2.0, random)[..., None]
    return (dark * (0.035, 0.028, 0.022) + (1.0 - dark) * (0.80, 0.74, 0.62)) * tint


def wicker(size, random):
    """Colour, alpha and height of rods that pass over and under each other, eight texels apart."""
    count = size // 8
    y, x = (np.mgrid[0:size, 0:size] + 0.5) * count / size
    height, color, alpha = np.full((size, size), -1.0), np.zeros((size, size, 3)), np.zeros((size, size))
    for across, along, up in ((x, y, 1.0), (y, x, -1.0)):
        rod = np.floor(across).astype(int)
        from_axis = np.abs(2.0 * (across - rod) - 1.0)
        profile = np.sqrt(np.clip(1.0 - (from_axis / 0.68) ** 2, 0.0, 1.0))
        swing = up * np.where(rod % 2 == 0, 1.0, -1.0) * np.cos(np.pi * (along - 0.5))
        of_rod = 0.45 + 0.2 * swing + 0.35 * (profile - 1.0)
        tint = random.uniform(0.85, 1.15, count)[rod] * (0.3 + 0.7 * profile) * (0.85 + 0.3 * swing)
        of_color = np.array((0.56, 0.32, 0.12)) * (tint * (1.0 + 0.05 * fine(size, 2.0, random)))[..., None]
        # A texel's width of alpha between 0 and 1: the border of a hole lies where it is one half.
        alpha = np.maximum(alpha, np.clip(0.5 + (0.62 - from_axis) * 4.0, 0.0, 1.0))
        above = (from_axis < 0.68) & (of_rod > height)
        height[above], color[above] = of_rod[above], of_color[above]
    # Holes hold the colour of the rods' sides, which is mixed with theirs at the border.
    color[height < 0.0] = color[(height >= 0.0) & (alpha < 1.0)].mean(axis=0)
    return color, alpha, np.maximum(height, 0.0)


def stones(size, random):
    """Colour, height and normals of rounded stones in dark ground."""
    cells = size // 12
    jitter = random.uniform(0.15, 0.85, (cells, cells, 2))
    centers = (np.stack(np.meshgrid(*[np.arange(cells)] * 2, indexing="ij"), -1) + jitter).reshape(-1, 2) * size / cells
    tints = random.uniform(0.0, 1.0, len(centers))
    rows, columns = np.mgrid[0:size, 0:size] + 0.5
    away = np.stack([rows, columns], -1)[:, :, None, :] - centers
    away = np.linalg.norm(away - size * np.round(away / size), axis=-1)
    order = np.argsort(away, axis=-1)
    nearest, second = (np.take_along_axis(away, order[..., i : i + 1], -1)[..., 0] for i in (0, 1))
    from_joint = (second - nearest) / 2.0
    height = np.sqrt(np.clip(1.0 - (1.0 - np.clip((from_joint - 0.6) / 4.5, 0.0, 1.0)) ** 2, 0.0, 1.0))
    height = 0.95 * height + 0.02 * (fine(size, 2.0, random) + 1.0)
    height = np.clip(height, 0.0, 1.0)
    tint = tints[order[..., 0]][..., None]
    stone = (1.0 - tint) * (0.42, 0.36, 0.28) + tint * (0.20, 0.22, 0.25)
    color = stone * (0.85 + 0.12 * fine(size, 3.0, random)[..., None])
    color = np.where(from_joint[..., None] > 0.6, color, (0.05, 0.04, 0.03))
    slope = lambda axis: STONE_DEPTH * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) / 2.0
    # Rows run downwards, y upwards.
    normal = np.stack([-slope(1), slope(0), np.ones_like(height)], -1)
    return color, height, normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def scattered(size, pitch, jitter, random):
    """Staggered places about `pitch` texels apart, moved at random by at most `jitter` pitches: rows and columns."""
    cells = size // pitch
    row, column = np.mgrid[0:cells, 0:cells]
    places = np.stack([row, column + 0.5 * (row % 2)], -1) + 0.5 + random.uniform(-jitter, jitter, (cells, cells, 2))
    return places.reshape(-1, 2) * size / cells


def offsets(size, places):
    """From the nearest place to each texel on the torus: rows and columns, (size, size, 2) for every place."""
    grid = np.stack(np.mgrid[0:size, 0:size] + 0.5, -1)
    away = grid[:, :, None, :] - places
    return away - size * np.round(away / size)


def leopard(size, random):
    """Rosettes sixteen texels apart: a dark ring, broken at one or two places, round a brown inside."""
    places = scattered(size, 16, 0.12, random)
    away = offsets(size, places)
    radius, angle = np.linalg.norm(away, axis=-1), np.arctan2(away[..., 0], away[..., 1])
    phases = random.uniform(0.0, 2.0 * np.pi, (3, len(places)))
    outer = 5.8 + 0.5 * np.cos(2.0 * angle + phases[0]) + 0.4 * np.cos(3.0 * angle + phases[1])
    inside = 1.0 - smooth_step(-0.5, 0.5, radius - outer + 2.6)
    # A gap of the ring is a part of it that is as brown as its inside.
    gap = smooth_step(0.8, 0.9, np.cos(angle + phases[2]))
    disc = 1.0 - smooth_step(-0.5, 0.5, radius - outer)
    brown, disc = np.max(disc * np.maximum(inside, gap), axis=-1)[..., None], np.max(disc, axis=-1)[..., None]
    color = disc * (0.020, 0.014, 0.010) + (1.0 - disc) * (0.72, 0.46, 0.18)
    color = color * (1.0 - brown) + brown * np.array((0.40, 0.10, 0.02))
    return color * (1.0 + 0.05 * fine(size, 2.0, random)[..., None])


def giraffe(size, random):
    """Patches sixteen texels apart with straight sides, and gaps between them."""
    away = np.sort(np.linalg.norm(offsets(size, scattered(size, 16, 0.22, random)), axis=-1), axis=-1)
    from_gap = (away[..., 1] - away[..., 0]) / 2.0
    patch = smooth_step(1.1, 2.1, from_gap)[..., None]
    tint = 1.0 + 0.06 * fine(size, 2.0, random)[..., None] - 0.02 * from_gap[..., None]
    return (patch * (0.24, 0.085, 0.022) + (1.0 - patch) * (0.78, 0.58, 0.32)) * tint


def marble(size, ground, vein, width, apart, random):
    """Veins where noise of features `apart` texels wide is near 0."""
    band = lambda x, y: np.exp(-(((np.hypot(x, y) - size / apart) / 1.4) ** 2))
    from_vein = np.abs(noise(size, band, random))
    share = 1.0 - smooth_step(width, width + 0.25, from_vein)[..., None]
    tint = 1.0 + 0.05 * fine(size, 3.0, random)[..., None] + 0.04 * fine(size, 8.0, random)[..., None]
    return (share * np.array(vein) + (1.0 - share) * ground) * tint


def rust(size, random):
    """Metal with patches of rust of two shades, and pits in both."""
    patch = smooth_step(-0.35, 0.55, fine(size, 9.0, random) + 0.35 * fine(size, 3.0, random))[..., None]
    shade = smooth_step(-1.0, 1.0, fine(size, 4.0, random))[..., None]
    rusty = shade * (0.42, 0.145, 0.035) + (1.0 - shade) * (0.20, 0.060, 0.022)
    color = patch * rusty + (1.0 - patch) * (0.155, 0.140, 0.135)
    pits = smooth_step(1.0, 1.8, fine(size, 1.6, random))[..., None]
    return color * (1.0 - 0.65 * pits) * (1.0 + 0.10 * fine(size, 2.0, random)[..., None])


def water(size, random):
    """Bright lines that close round darker cells, as sunlight draws them on the ground of a pool."""
    band = lambda apart: lambda x, y: np.exp(-(((np.hypot(x, y) - size / apart) / 1.6) ** 2))
    from_line = np.minimum(np.abs(noise(size, band(26.0), random)), np.abs(noise(size, band(19.0), random)) + 0.12)
    glow, line = np.exp(-((from_line / 0.55) ** 2))[..., None], np.exp(-((from_line / 0.24) ** 2))[..., None]
    depth = 1.0 + 0.10 * fine(size, 10.0, random)[..., None]
    return np.array((0.03, 0.25, 0.36)) * depth + glow * (0.06, 0.18, 0.17) + line * (0.30, 0.34, 0.27)


def burl(size, random):
    """Grain along the contours of noise, so that it runs round eyes of dark wood."""
    height = 1.1 * fine(size, 15.0, random) + 0.15 * fine(size, 7.0, random)
    grain = (0.5 + 0.5 * np.sin(2.0 * np.pi * height))[..., None]
    eye = smooth_step(1.9, 2.5, np.abs(height))[..., None]
    wood = grain * (0.46, 0.21, 0.075) + (1.0 - grain) * (0.27, 0.100, 0.032)
    color = wood * (1.0 - eye) + eye * np.array((0.09, 0.032, 0.012))
    return color * (1.0 + 0.06 * fine(size, 1.8, random)[..., None])


def candy(size, random):
    """Round sweets of six colours, one over another."""
    shades = np.array([(0.75, 0.06, 0.08), (0.80, 0.55, 0.08), (0.15, 0.55, 0.22), (0.06, 0.36, 0.55), (0.50, 0.26, 0.58), (0.28, 0.12, 0.06)])
    color, y, x = np.full((size, size, 3), 0.03), *(np.mgrid[0:size, 0:size] + 0.5)
    for place in scattered(size, 6, 0.7, random):
        down, right = (along - at - size * np.round((along - at) / size) for along, at in zip((y, x), place))
        from_middle = np.hypot(down, right) / random.uniform(4.0, 5.5)
        dome = 0.35 + 0.65 * np.sqrt(np.clip(1.0 - from_middle**2, 0.0, 1.0))[..., None]
        shine = np.exp(-((down + 1.6) ** 2 + (right + 1.2) ** 2) / 1.5)[..., None]
        sweet = shades[random.integers(len(shades))] * dome + 0.45 * shine
        inside = (1.0 - smooth_step(0.9, 1.1, from_middle))[..., None]
        color = inside * sweet + (1.0 - inside) * color
    return color


def save_color(path, color, alpha=None):
    stored = np.where(color <= 0.0031308, 12.92 * color, 1.055 * np.maximum(color, 0.0031308) ** (1 / 2.4) - 0.055)
    channels = [stored] if alpha is None else [stored, alpha[..., None]]
    save_numbers(path, np.concatenate(channels, -1))


def save_numbers(path, numbers):
    Image.fromarray(np.round(255.0 * np.clip(numbers, 0.0, 1.0)).astype(np.uint8)).save(path)


def save_relit(folder, color, normal, lights):
    """Pictures of Lambertian stones under lights all over the hemisphere, without cast shadows, and their list."""
    folder.mkdir(exist_ok=True)
    z = (np.arange(lights) + 0.5) / lights
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(lights)
    towards = np.stack([np.sqrt(1.0 - z**2) * np.cos(turn), np.sqrt(1.0 - z**2) * np.sin(turn), z], -1)
    for number, light in enumerate(towards):
        save_color(folder / f"{number:04}.png", color * np.maximum(normal @ light, 0.0)[..., None])
    rows = ["{:04}.png {:.7f} {:.7f} {:.7f}\n".format(number, *light) for number, light in enumerate(towards)]
    (folder / "lights.lp").write_text(f"{lights}\n" + "".join(rows))


def cube_faces(cubes, cuts):
    """Quads of the surface of unit cubes at whole places, each side cut into cuts × cuts; welded vertices."""
    place, quads = {}, []
    vertex = lambda p: place.setdefault(tuple(int(c) for c in p), len(place))
    for cube in sorted(cubes):
        for axis in range(3):
            for side in (0, 1):
                step = np.eye(3, dtype=int)
                if tuple(np.array(cube) + (2 * side - 1) * step[axis]) in cubes:
                    continue
                u, v = step[(axis + 1) % 3], step[(axis + 2) % 3]
                corner = cuts * (np.array(cube) + side * step[axis])
                for i in range(cuts):
                    for j in range(cuts):
                        quad = [corner + a * u + b * v for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
                        quads.append([vertex(p) for p in (quad if side else quad[::-1])])
    return np.array(list(place), float) / cuts, np.array(quads)


def cross():
    cubes = {(0, 0, 0)} | {tuple(sign * row) for row in np.eye(3, dtype=int) for sign in (1, -1)}
    points, quads = cube_faces({tuple(map(int, cube)) for cube in cubes}, CROSS_CUTS)
    edges = np.unique(np.sort(np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]), 1), axis=0)
    ends = np.concatenate([edges, edges[:, ::-1]])
    neighbors = np.bincount(ends[:, 0])[:, None]
    for _ in range(CROSS_ROUNDS):
        sums = np.zeros_like(points)
        np.add.at(sums, ends[:, 0], points[ends[:, 1]])
        points = 0.5 * points + 0.5 * sums / neighbors
    return points - 0.5, quads


def ball():
    points, quads = cube_faces({(0, 0, 0)}, BALL_CUTS)
    # Equal angles: quads of a like size.
    points = np.tan((2.0 * points - 1.0) * np.pi / 4.0)
    return points / np.linalg.norm(points, axis=1, keepdims=True), quads


def globe():
    """An octahedron whose triangles are cut in four, again and again, on the sphere: at every vertex an even number meet."""
    points = [np.array(p, float) for p in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1))]
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    for _ in range(GLOBE_CUTS):
        middles = {}

        def middle(a, b):
            if (min(a, b), max(a, b)) not in middles:
                between = points[a] + points[b]
                middles[min(a, b), max(a, b)] = len(points)
                points.append(between / np.linalg.norm(between))
            return middles[min(a, b), max(a, b)]

        cut = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            cut += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = cut
    return np.array(points), np.array(faces)


def save_mesh(path, points, faces):
    lines = ["v {:.6f} {:.6f} {:.6f}\n".format(*p) for p in points]
    lines += ["f " + " ".join(map(str, face)) + "\n" for face in faces + 1]
    path.write_text("".join(lines))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--relit", type=int, default=0, metavar="LIGHTS", help="draw stones-relit/ under so many lights")
    args = parser.parse_args()
    folder = args.output
    folder.mkdir(parents=True, exist_ok=True)
    save_color(folder / "zebra.png", zebra(64, np.random.default_rng(7)))
    color, alpha, height = wicker(64, np.random.default_rng(2))
    save_color(folder / "wicker.png", color, alpha)
    save_numbers(folder / "wicker-height.png", height)
    color, height, normal = stones(96, np.random.default_rng(3))
    save_color(folder / "stones.png", color)
    save_numbers(folder / "stones-height.png", height)
    save_numbers(folder / "stones-normal.png", 0.5 + 0.5 * normal)
    save_color(folder / "leopard.png", leopard(96, np.random.default_rng(4)))
    save_color(folder / "giraffe.png", giraffe(96, np.random.default_rng(5)))
    pale, red = ((0.74, 0.72, 0.66), (0.10, 0.11, 0.12)), ((0.30, 0.055, 0.035), (0.80, 0.55, 0.36))
    save_color(folder / "pale.png", marble(96, *pale, 0.36, 19.0, np.random.default_rng(6)))
    save_color(folder / "red.png", marble(96, *red, 0.40, 16.0, np.random.default_rng(8)))
    save_color(folder / "rust.png", rust(96, np.random.default_rng(9)))
    save_color(folder / "water.png", water(96, np.random.default_rng(10)))
    save_color(folder / "burl.png", burl(96, np.random.default_rng(11)))
    save_color(folder / "candy.png", candy(96, np.random.default_rng(12)))
    if args.relit:
        save_relit(folder / "stones-relit", color, normal, args.relit)
    save_mesh(folder / "cross.obj", *cross())
    save_mesh(folder / "ball.obj", *ball())
    save_mesh(folder / "globe.obj", *globe())


if __name__ == "__main__":
    main()
