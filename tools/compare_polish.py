#!/usr/bin/env python3
"""Compares synthesis with and without `--polish` on structured samples and curved meshes.

    tools/compare_polish.py bunny.obj spot.obj … --mesotex target/release/mesotex -o FOLDER

Draws four tileable samples into FOLDER: `letters` (96 × 96 texels), rows of letters; `hexagons` (64 × 56), hexagons of eight greens with pale rims; `bumps`
(64 × 64), a few round bumps on a plain ground; `tiles` (64 × 64), tiles of three sizes in four colours. Every mesh is retiled to `--vertices` (40,000). Per sample and mesh
and seed both maps are synthesized. Of their reports the table has coherence within half a texel and one, energies and seconds. The patch distance is that
of tools/compare_targets.py, of windows with points 1 and 2 texels apart; smaller is closer. Prints Markdown.

Needs: pip install numpy scipy pillow
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np
from compare_targets import patch_distance, sites_of_map
from PIL import Image, ImageDraw

STEPS = (1, 2)
# Strokes in a box of 1 × 1, y downwards.
LETTERS = {
    "A": [[(0, 1), (0.5, 0), (1, 1)], [(0.22, 0.62), (0.78, 0.62)]],
    "E": [[(1, 0), (0, 0), (0, 1), (1, 1)], [(0, 0.5), (0.8, 0.5)]],
    "K": [[(0, 0), (0, 1)], [(1, 0), (0, 0.55)], [(0.3, 0.42), (1, 1)]],
    "M": [[(0, 1), (0, 0), (0.5, 0.6), (1, 0), (1, 1)]],
    "N": [[(0, 1), (0, 0), (1, 1), (1, 0)]],
    "O": [[(0.3, 0), (0.7, 0), (1, 0.3), (1, 0.7), (0.7, 1), (0.3, 1), (0, 0.7), (0, 0.3), (0.3, 0)]],
    "R": [[(0, 1), (0, 0), (0.7, 0), (1, 0.15), (1, 0.4), (0.7, 0.55), (0, 0.55)], [(0.45, 0.55), (1, 1)]],
    "S": [[(1, 0.1), (0.7, 0), (0.2, 0), (0, 0.25), (0.2, 0.48), (0.8, 0.52), (1, 0.75), (0.8, 1), (0.3, 1), (0, 0.9)]],
    "T": [[(0, 0), (1, 0)], [(0.5, 0), (0.5, 1)]],
    "X": [[(0, 0), (1, 1)], [(1, 0), (0, 1)]],
}
LINES = ("TEXMAS", "ONSEAT", "KRANEX", "STOMEN", "AXEROK")
FINER = 8


def letters(random):
    """Rows of letters, dark on pale."""
    size, pitch = 96, (16, 96 / len(LINES))
    image = Image.new("L", (size * FINER, size * FINER), 255)
    draw = ImageDraw.Draw(image)
    for row, line in enumerate(LINES):
        for col, letter in enumerate(line):
            for stroke in LETTERS[letter]:
                points = [((col * pitch[0] + 3.5 + 9 * x) * FINER, (row * pitch[1] + 4 + 11 * y) * FINER) for x, y in stroke]
                draw.line(points, fill=0, width=int(1.9 * FINER), joint="curve")
    grey = np.asarray(image, dtype=np.float64).reshape(size, FINER, size, FINER).mean(axis=(1, 3)) / 255
    return grey[..., None] * (0.80, 0.76, 0.66) + (1 - grey[..., None]) * (0.10, 0.11, 0.20)


def hexagons(random):
    """Hexagons 16 texels wide in rows 14 apart, nearly regular: pale rims round eight greens."""
    width, height = 64, 56
    y, x = np.mgrid[0:height, 0:width] + 0.5
    near = np.full((3, height, width), 1e9)
    colors = np.zeros((height, width, 3))
    palette = np.array([(0.10, 0.24 + 0.05 * k, 0.16 + 0.04 * (k * 3 % 8)) for k in range(8)])
    for row in range(4):
        for col in range(4):
            dx = (x - (16 * col + 8 * (row % 2)) + width / 2) % width - width / 2
            dy = (y - 14 * row + height / 2) % height - height / 2
            far = np.max([np.abs(dx), np.abs(dx / 2 + dy * 0.875), np.abs(dx / 2 - dy * 0.875)], axis=0)
            inside = far < near[0]
            near[0] = np.minimum(near[0], far)
            colors[inside] = palette[(row * 5 + col * 3) % 8]
    rim = np.clip((near[0] - 6.2) / 0.9, 0, 1)[..., None]
    return colors * (1 - rim) + rim * (0.78, 0.74, 0.58)


def bumps(random):
    """Five round bumps of two sizes on a ground with faint grain."""
    size = 64
    y, x = np.mgrid[0:size, 0:size] + 0.5
    k = np.fft.fftfreq(size, 1 / size)
    grain = np.fft.ifft2(np.fft.fft2(random.standard_normal((size, size))) * np.exp(-np.hypot(*np.meshgrid(k, k)) ** 2 / 200)).real
    shade = 0.42 + 0.02 * grain / grain.std()
    color = shade[..., None] * (1.0, 0.93, 0.80)
    for cx, cy, radius in ((13, 14, 8), (44, 10, 6), (29, 36, 8.5), (56, 40, 7), (10, 51, 6.5)):
        dx, dy = ((d + size / 2) % size - size / 2 for d in (x - cx, y - cy))
        r = np.hypot(dx, dy) / radius
        inside = np.clip((1 - r) * radius, 0, 1)[..., None]
        height = np.sqrt(np.clip(1 - r**2, 0.05, 1))
        light = np.clip((-dx * 0.5 - dy * 0.6) / radius + 0.65 * height, 0.08, 1)[..., None]
        color = color * (1 - inside) + inside * light * (0.85, 0.42, 0.22)
    return color


def tiles(random):
    """Tiles of 16 × 16, 32 × 16 and 32 × 32 texels with dark joints."""
    size = 64
    places = [(0, 0, 32, 32), (32, 0, 16, 16), (48, 0, 16, 16), (32, 16, 32, 16), (0, 32, 32, 16), (0, 48, 16, 16), (16, 48, 16, 16), (32, 32, 32, 32)]
    palette = [(0.62, 0.34, 0.22), (0.70, 0.62, 0.46), (0.30, 0.40, 0.46), (0.46, 0.24, 0.20)]
    color = np.zeros((size, size, 3)) + (0.12, 0.11, 0.10)
    for number, (left, top, wide, high) in enumerate(places):
        color[top + 1 : top + high - 1, left + 1 : left + wide - 1] = palette[number * 3 % 4]
    return color * (1 + 0.04 * random.standard_normal((size, size, 1)))


SAMPLES = (letters, hexagons, bumps, tiles)


def run(args, *words):
    done = subprocess.run([str(word) for word in (args.mesotex, *words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr}")
    return done.stdout


def sample(args, draw):
    """Draws a sample and makes its exemplar; returns its name and what it looks like, from 0 to 1."""
    name = args.output / draw.__name__
    image = np.clip(draw(np.random.default_rng(1)), 0, 1)
    coded = np.where(image > 0.0031308, 1.055 * image ** (1 / 2.4) - 0.055, 12.92 * image)
    pixels = np.round(coded * 255).astype(np.uint8)
    Image.fromarray(pixels).save(f"{name}.png")
    run(args, "exemplar", f"{name}.png", "-o", name, "--tile", "--quiet")
    return name, pixels / 255.0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", type=Path, metavar="MESH")
    parser.add_argument("--mesotex", default="target/release/mesotex")
    parser.add_argument("--vertices", type=int, default=40000)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--samples", nargs="+", default=[draw.__name__ for draw in SAMPLES])
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    print("| sample | mesh | patch distance | with polish | `coherence_half` | | `coherence_one` | | `energy` | | `energy_ratio_full` | | seconds | |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for draw in (draw for draw in SAMPLES if draw.__name__ in args.samples):
        name, image = sample(args, draw)
        for mesh in args.meshes:
            even = args.output / f"{mesh.stem}-{args.vertices}.ply"
            if not even.exists():
                run(args, "mesh", mesh, "--vertices", args.vertices, "-o", even)
            rows = []
            for rounds in (0, args.rounds):
                found = []
                for seed in range(args.seeds):
                    out = args.output / f"{draw.__name__}-{mesh.stem}-{seed}-{rounds}.map.ply"
                    words = ["synth", f"{name}.space.npz", f"{name}.knn.npz", even, "-o", out, "--seed", seed, "--json"]
                    report = json.loads(run(args, *words, *(("--polish", rounds) if rounds else ())))
                    keys = ("coherence_half", "coherence_one", "energy", "energy_ratio_full")
                    away = patch_distance(image, sites_of_map(out), 4000, STEPS)
                    found.append([away, *(report[key] for key in keys), report["seconds"]["synthesis"]])
                rows.append(np.mean(found, axis=0))
            pairs = " | ".join(f"{a:.{n}f} | {b:.{n}f}" for a, b, n in zip(*rows, (4, 3, 3, 3, 3, 2)))
            print(f"| {draw.__name__} | {mesh.stem} | {pairs} |", flush=True)


if __name__ == "__main__":
    main()
