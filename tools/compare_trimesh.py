#!/usr/bin/env python3
"""Opens the meshes that `mesotex` writes for other programs with trimesh, and compares counts and colours with the map.

    mesotex export A.map.ply --to ply -o A.ply --sample A.sample
    mesotex export A.map.ply --to obj -o A.obj --sample A.sample
    mesotex render A.sample A.map.ply -o frames --vertex-colors colored.ply
    tools/compare_trimesh.py A.map.ply A.ply A.obj colored.ply

The first file is the map; each other one must have its vertices, in their order and at their places, and its triangles. All files of
one command (here the two of `export`) must have the same colours: those of each are compared with the first one whose name has
the same stem. Prints a line per file. Exit code 1 where anything differs.

Needs: pip install trimesh numpy
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import trimesh

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

import mesotex  # noqa: E402


def opened(path):
    """Vertices, triangles and colours (bytes, [N, 3]; None without) as trimesh has them."""
    mesh = trimesh.load(path, process=False, maintain_order=True, force="mesh")
    if mesh.visual.kind == "vertex":
        return mesh.vertices, mesh.faces, np.asarray(mesh.visual.vertex_colors)[:, :3]
    # Beside texture coordinates, colours are an attribute.
    colors = getattr(mesh.visual, "vertex_attributes", {}).get("color", mesh.vertex_attributes.get("color"))
    if colors is None:
        return mesh.vertices, mesh.faces, None
    colors = np.asarray(colors)[:, :3]
    if colors.dtype.kind == "f":
        colors = np.round(255 * colors)
    return mesh.vertices, mesh.faces, colors.astype(np.uint8)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", type=Path)
    parser.add_argument("meshes", type=Path, nargs="+")
    arguments = parser.parse_args()
    surface = mesotex.read_map(arguments.map)
    places = surface.positions + surface.header.origin
    size = np.ptp(places, axis=0).max()
    known, failed = {}, False
    for path in arguments.meshes:
        vertices, faces, colors = opened(path)
        same_counts = len(vertices) == len(places) and len(faces) == len(surface.faces)
        same_mesh = same_counts and np.abs(vertices - places).max() < 1e-6 * size and (faces == surface.faces).all()
        said = "no colours"
        same_colors = colors is not None
        if colors is not None:
            first = known.setdefault(path.stem, (path, colors))
            same_colors = first[1].shape == colors.shape and (first[1] == colors).all()
            said = f"{len(np.unique(colors, axis=0))} colours"
            if first[0] != path:
                said += f", {'those' if same_colors else 'not those'} of {first[0].name}"
        failed |= not (same_mesh and same_colors)
        mesh = "the map's" if same_mesh else "not the map's"
        print(f"{path.name}: {len(vertices)} vertices, {len(faces)} triangles, {mesh}; {said}")
    sys.exit(int(failed))


if __name__ == "__main__":
    main()
