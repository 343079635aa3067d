#!/usr/bin/env python3
"""Measures whether a decorated atlas shows its charts: colours one texel apart across borders and inside charts.

    tools/measure_seams.py NAME.atlas…

A pair is two texels whose points on the surface lie 0.75 to 1.25 texels apart (the mean spacing inside charts).
Pairs across a border have texels of different charts, the others texels of one chart. Differences are means of
|a − b| over the channels of color.png, linear. Prints Markdown; a ratio of 1 means that borders cannot be told.

Needs: pip install numpy scipy pillow
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial import cKDTree


def linear(stored):
    return np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)


def measured(folder):
    surface = np.load(folder / "surface.npz")
    chart, position, normal = surface["chart"], surface["position"], surface["normal"]
    color = linear(np.asarray(Image.open(folder / "color.png").convert("RGB"), dtype=float) / 255.0)
    inside = chart >= 0
    charts, points, normals, colors = chart[inside], position[inside], normal[inside], color[inside]
    tree = cKDTree(points)
    spacing = np.median(tree.query(points, k=2)[0][:, 1])
    pairs = tree.query_pairs(1.25 * spacing, output_type="ndarray")
    far = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    facing = np.sum(normals[pairs[:, 0]] * normals[pairs[:, 1]], axis=1)
    pairs = pairs[(far >= 0.75 * spacing) & (facing > 0.8)]
    differences = np.abs(colors[pairs[:, 0]] - colors[pairs[:, 1]]).mean(axis=1)
    across = charts[pairs[:, 0]] != charts[pairs[:, 1]]
    return across.sum(), differences[across].mean(), differences[~across].mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="NAME.atlas")
    args = parser.parse_args()
    print("| atlas | pairs across | difference across | inside | ratio |\n| --- | --- | --- | --- | --- |")
    for folder in args.folders:
        pairs, across, inside = measured(folder)
        print(f"| {folder.stem} | {pairs:,} | {across:.4f} | {inside:.4f} | {across / inside:.2f} |")


if __name__ == "__main__":
    main()
