#!/usr/bin/env python3
"""Measures whether a map of `synth --method progressive` has, where the transition has a value, the scale its exemplar has there.

    tools/measure_transition.py MAP.ply NAME [--bands 4]

NAME is that of the exemplar: NAME.mask.png and NAME.transition.png, from `mesotex vary`. The transition is cut into bands. In each
band, of the map and of the exemplar:

- the share that elements cover; elements are connected parts of the mask with any label but 0;
- their size: the median of their areas, in texels, fragments left out, and so are elements that the exemplar's border cuts. An
  element counts in each band by its share there. Fifths of a band weigh alike, in the map and in the exemplar;
- their spacing: the square root of size over share, in texels;
- of the map, the drift (rows s, t): the matrix M with the least Σ|Δ − M o|² over edges whose ends hold texels not farther apart than
  two more than their own distance, where o is the edge and Δ the way between its texels;
- fragments and merged elements: those smaller than a tenth or larger than 2.5 times the exemplar's size in that band, as shares of
  the area that elements cover.

Prints Markdown; ratios are those of the map to the exemplar.

Needs: pip install numpy scipy pillow
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

KINDS = {"float": "<f4", "double": "<f8", "uchar": "u1", "ushort": "<u2", "int": "<i4", "uint": "<u4"}
FRAGMENT, MERGED = 0.1, 2.5
# Of each band, so that map and exemplar have the same mixture of transitions in it.
PARTS = 5


def read_map(path):
    """Comments, vertices and triangles of a map."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    comments = {line[1]: line[2:] for line in lines if line[0] == "comment"}
    count = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
    fields = [(line[2], KINDS[line[1]]) for line in lines if line[0] == "property" and line[1] != "list"]
    vertices = np.frombuffer(body, fields, count["vertex"])
    faces = np.frombuffer(body, [("corners", "u1"), ("at", "<i4", 3)], count["face"], vertices.nbytes)
    if not (faces["corners"] == 3).all():
        raise SystemExit(f"{path}: a map of triangles is needed")
    return comments, vertices, faces["at"]


def elements(covered, pairs, areas):
    """The element of every site (−1 for none), and the areas of elements."""
    kept = pairs[covered[pairs].all(axis=1)]
    links = coo_matrix((np.ones(len(kept)), kept.T), shape=(len(covered),) * 2)
    found = connected_components(links, directed=False)[1]
    found = np.where(covered, found, -1)
    found[covered] = np.unique(found[covered], return_inverse=True)[1]
    return found, np.bincount(found[covered], areas[covered])


def median(values, weights):
    order = np.argsort(values)
    sums = np.cumsum(weights[order])
    return values[order][np.searchsorted(sums, sums[-1] / 2.0)]


class Texture:
    """Mask, transition and elements of some sites, and their areas in texels."""

    def __init__(self, mask, transition, pairs, areas, cut=()):
        self.covered, self.transition, self.areas = mask > 0, transition, areas
        self.element, self.size = elements(self.covered, pairs, areas)
        self.cut = np.isin(self.element, np.setdiff1d(self.element[list(cut)], [-1])) if len(cut) else np.zeros(len(mask), bool)

    def weights(self, low, high):
        """Areas of the sites of a band, 0 elsewhere, each of PARTS parts of the band made as heavy as the others."""
        part = np.floor((self.transition - low) / (high - low) * PARTS).astype(int)
        inside = (part >= 0) & (part < PARTS)
        total = np.bincount(part[inside], self.areas[inside], PARTS)
        weights = np.zeros(len(part))
        weights[inside] = self.areas[inside] / total[part[inside]]
        return weights

    def band(self, low, high):
        """Share, size and spacing where the transition is from low to high."""
        weights = self.weights(low, high)
        share = weights[self.covered].sum() / weights.sum()
        whole = (weights > 0.0) & self.covered & ~self.cut
        sizes, weights = self.size[self.element[whole]], weights[whole]
        kept = sizes >= FRAGMENT * median(sizes, weights)
        size = median(sizes[kept], weights[kept] / sizes[kept])
        return share, size, np.sqrt(size / share)

    def outside(self, low, high, size):
        """Shares of covered area in fragments, and in merged elements, of those that should be so large."""
        inside = (self.transition >= low) & (self.transition < high) & self.covered & ~self.cut
        sizes, areas = self.size[self.element[inside]], self.areas[inside]
        return areas[sizes < FRAGMENT * size].sum() / areas.sum(), areas[sizes > MERGED * size].sum() / areas.sum()


def surface(path):
    """The texture of a map, and its drift in a range of transitions."""
    comments, vertices, faces = read_map(path)
    texel = float(comments["texel"][0])
    place = np.stack([vertices[axis] for axis in "xyz"], -1).astype(float) / texel
    corner = place[faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 2.0
    areas = np.bincount(faces.ravel(), np.repeat(area / 3.0, 3), len(vertices))
    edges = np.unique(np.sort(np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)]), 1), axis=0)
    texture = Texture(vertices["mask"], vertices["transition"], edges, areas)
    normal, right = (np.stack([vertices[a] for a in axes], -1).astype(float) for axes in (("nx", "ny", "nz"), ("sx", "sy", "sz")))
    up = np.cross(normal, right)
    begin, end = np.concatenate([edges, edges[:, ::-1]]).T
    way = place[end] - place[begin]
    offset = np.stack([(way * right[begin]).sum(1), (way * up[begin]).sum(1)], -1)
    coords = np.stack([vertices["s"], vertices["t"]], -1).astype(float)
    moved = coords[end] - coords[begin]
    near = np.abs(moved).max(1) <= 2.0 + np.abs(offset).max(1)

    def drift(low, high):
        used = near & (vertices["transition"][begin] >= low) & (vertices["transition"][begin] < high)
        return np.linalg.lstsq(offset[used], moved[used], rcond=None)[0].T

    return texture, drift


def exemplar(name):
    mask, transition = (np.asarray(Image.open(f"{name}.{part}.png")) for part in ("mask", "transition"))
    at = np.arange(mask.size).reshape(mask.shape)
    # Six neighbours, as many as a vertex has on the average.
    steps = ((at[:, :-1], at[:, 1:]), (at[:-1], at[1:]), (at[:-1, :-1], at[1:, 1:]))
    pairs = np.concatenate([np.stack([a.ravel(), b.ravel()], -1) for a, b in steps])
    border = np.concatenate([at[0], at[-1], at[:, 0], at[:, -1]])
    return Texture(mask.ravel(), transition.ravel() / (65535.0 if transition.max() > 255 else 255.0), pairs, np.ones(mask.size), border)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", type=Path, metavar="MAP.ply")
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--bands", type=int, default=4)
    args = parser.parse_args()
    (texture, drift), source = surface(args.map), exemplar(args.name)
    print("| transition | share | size | spacing | linear scale | spacing's ratio | drift | fragments | merged |\n" + "| --- " * 9 + "|")
    limits = np.linspace(0.0, 1.0, args.bands + 1)
    for low, high in zip(limits, limits[1:]):
        top = high + 1e-6 if high == 1.0 else high
        found, wanted = texture.band(low, top), source.band(low, top)
        pairs = " | ".join(f"{a:.{digits}f} / {b:.{digits}f}" for a, b, digits in zip(found, wanted, (2, 0, 1)))
        ratios = f"{np.sqrt(found[1] / wanted[1]):.2f} | {found[2] / wanted[2]:.2f}"
        m = drift(low, top)
        matrix = f"{m[0, 0]:.2f}, {m[0, 1]:.2f}; {m[1, 0]:.2f}, {m[1, 1]:.2f}"
        # Of the map, and of the exemplar.
        odd = [texture.outside(low, top, wanted[1]), source.outside(low, top, wanted[1])]
        odd = " | ".join(f"{100 * a:.1f} / {100 * b:.1f} %" for a, b in zip(*odd))
        print(f"| {low:.2f} to {high:.2f} | {pairs} | {ratios} | {matrix} | {odd} |")


if __name__ == "__main__":
    main()
