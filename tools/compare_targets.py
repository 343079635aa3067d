#!/usr/bin/env python3
"""Compares synthesis on vertices with synthesis into an atlas: same surface, sample, scale and number of sites.

    tools/compare_targets.py MESH… --samples weave.sample cobbles.sample --program target/release/mesotex

NAME.space.npz and NAME.knn.npz must stand beside NAME.sample, which is a full product and tileable. Every mesh is unwrapped into an
atlas of `--resolution` (320) texels a side, and retiled to as many vertices as there are texels inside charts. Per mesh, sample and method
(`k-coherence`, `coherent`) both are synthesized; of their reports the table has coherence within one texel, the diagonal of drift and
χ² of the texton histograms.

The patch distance is that of tools/compare_texture.py between windows on the surface and windows of the sample: 7 × 7 texels 1, 2 and
4 apart, round `--windows` (4000) random sites, in the tangent plane along s and t. A point of a window has the colour at the coordinate of
the nearest site, continued to it. Colours are the means over lights of the view nearest to the normal, by the sRGB curve. Windows with a point
farther than two texels from every site are left out. Prints Markdown.

Needs: pip install numpy scipy pillow
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from compare_texture import sliced_wasserstein
from scipy.spatial import cKDTree

METHODS = ("k-coherence", "coherent")
SIDE, STEPS = 7, (1, 2, 4)


def run(args, *words):
    done = subprocess.run([str(word) for word in (args.program, *words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr}")
    return done.stdout


def picture(sample):
    """The sample from above, sRGB from 0 to about 1."""
    head = json.loads((sample / "btf.json").read_text())
    above = int(np.argmax(np.array(head["views"])[:, 2]))
    radiance = np.load(sample / "radiance.npy", mmap_mode="r")[above].astype(np.float64).mean(axis=0)
    return np.clip(radiance / radiance.max(), 0.0, 1.0) ** (1 / 2.4)


def sites_of_map(path):
    """Points, frames, coordinates and texel of a surface texton map whose scale is 1."""
    with open(path, "rb") as file:
        head, columns = [], []
        for line in iter(file.readline, b"end_header\n"):
            head.append(line.decode().split())
        for words in head:
            if words[0] == "property" and words[1] in ("float", "ushort"):
                columns.append((words[2], {"float": "<f4", "ushort": "<u2"}[words[1]]))
        count = next(int(words[2]) for words in head if words[:2] == ["element", "vertex"])
        texel = next(float(words[2]) for words in head if words[:2] == ["comment", "texel"])
        rows = np.frombuffer(file.read(count * np.dtype(columns).itemsize), columns)
    part = lambda *names: np.stack([rows[name] for name in names], 1).astype(np.float64)
    return part("x", "y", "z"), part("nx", "ny", "nz"), part("sx", "sy", "sz"), part("s", "t"), texel


def sites_of_atlas(folder):
    surface = np.load(folder / "surface.npz")
    inside = surface["chart"] >= 0
    parts = [surface[name][inside].astype(np.float64) for name in ("position", "normal", "orientation")]
    texel = json.loads((folder / "atlas.json").read_text())["texel"]
    return *parts, np.load(folder / "coords.npy")[inside].astype(np.float64), texel


def looked_up(image, coords):
    """Bilinear in a tileable picture; t upwards, texel centres at one half."""
    height, width = image.shape[:2]
    x, y = coords[..., 0] - 0.5, height - coords[..., 1] - 0.5
    col, row = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = (x - col)[..., None], (y - row)[..., None]
    at = lambda r, c: image[r % height, c % width]
    upper = (1 - u) * at(row, col) + u * at(row, col + 1)
    return (1 - v) * upper + v * ((1 - u) * at(row + 1, col) + u * at(row + 1, col + 1))


def offsets(step):
    along = step * (np.arange(SIDE) - SIDE // 2)
    return np.stack(np.meshgrid(along, -along), -1).reshape(-1, 2).astype(float)


def patch_distance(image, sites, windows, steps=STEPS):
    points, normals, axes, coords, texel = sites
    others = np.cross(normals, axes)
    tree = cKDTree(points)
    chosen = np.random.default_rng(0).choice(len(points), min(windows, len(points)), replace=False)
    height, width = image.shape[:2]
    centers = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), -1).reshape(-1, 1, 2)
    total = 0.0
    for step in steps:
        pattern = offsets(step)
        along = pattern[:, 0, None] * axes[chosen][:, None] + pattern[:, 1, None] * others[chosen][:, None]
        places = points[chosen][:, None] + texel * along
        far, nearest = tree.query(places)
        from_site = places - points[nearest]
        continued = coords[nearest] + np.stack([(from_site * of[nearest]).sum(-1) for of in (axes, others)], -1) / texel
        whole = (far < 2.0 * texel).all(axis=1)
        found = looked_up(image, continued[whole]).reshape(whole.sum(), -1)
        wanted = looked_up(image, centers + pattern).reshape(len(centers), -1)
        total += sliced_wasserstein(found, wanted) / len(steps)
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", type=Path, metavar="MESH")
    parser.add_argument("--samples", nargs="+", type=Path, required=True)
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--resolution", type=int, default=320)
    parser.add_argument("--windows", type=int, default=4000)
    args = parser.parse_args()
    print("| mesh | sample | method | onto | sites | coherence | drift s, t | χ² | patch distance |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for mesh in args.meshes:
            for sample in args.samples:
                image, name = picture(sample), str(sample.with_suffix(""))
                for method in METHODS:
                    words = ["synth", f"{name}.space.npz", f"{name}.knn.npz"]
                    onto = ["--onto", "atlas", "--unwrap", "--resolution", args.resolution, "-o", folder / "found.atlas"]
                    atlas = json.loads(run(args, *words, mesh, *onto, "--method", method, "--json"))
                    even = folder / f"{mesh.stem}-{atlas['vertices']}.ply"
                    if not even.exists():
                        run(args, "mesh", mesh, "--vertices", atlas["vertices"], "-o", even)
                    onto = ["-o", folder / "found.map.ply", "--method", method, "--json"]
                    vertices = json.loads(run(args, *words, even, *onto))
                    found = (("vertices", vertices, sites_of_map(folder / "found.map.ply")),
                             ("atlas", atlas, sites_of_atlas(folder / "found.atlas")))
                    for target, report, sites in found:
                        drift = f"{report['drift'][0][0]:.2f}, {report['drift'][1][1]:.2f}"
                        figures = f"{report['coherence_one']:.3f} | {drift} | {report['histogram_chi2']:.4f}"
                        away = patch_distance(image, sites, args.windows)
                        print(f"| {mesh.stem} | {sample.stem} | `{method}` | {target} | {report['vertices']:,} | {figures} "
                              f"| {away:.4f} |", flush=True)


if __name__ == "__main__":
    main()
