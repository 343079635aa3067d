#!/usr/bin/env python3
"""Compares geodesic distances with exact ones (pygeodesic, Mitchell 1987) and with the heat method (potpourri3d,
Crane 2013), in one run.

    tools/compare_geodesics.py MESH… --program target/release/examples/geodesic_distances

Four vertices of every mesh are sources. Prints Markdown: the median and the 95th percentile of the relative
difference over all vertices, and the seconds of each. Meshes should need no cleaning.

Needs: pip install numpy potpourri3d pygeodesic
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import potpourri3d
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

SOURCES = 4


def obj_or_off(path):
    """Vertices and triangles; polygons are cut into fans."""
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    if path.suffix == ".off":
        start = 2 if lines[0] == ["OFF"] else 1
        vertices = int(lines[start - 1][0]) if start == 2 else int(lines[0][1])
        positions = [line[:3] for line in lines[start : start + vertices]]
        faces = [[int(corner) for corner in line[1 : 1 + int(line[0])]] for line in lines[start + vertices :]]
    else:
        positions = [line[1:4] for line in lines if line[0] == "v"]
        corners = [line[1:] for line in lines if line[0] == "f"]
        faces = [[int(corner.split("/")[0]) - 1 for corner in face] for face in corners]
    fans = [[face[0], face[at], face[at + 1]] for face in faces for at in range(1, len(face) - 1)]
    return np.array(positions, dtype=float), np.array(fans)


class Timed:
    """Seconds that some calls took."""

    def __init__(self):
        self.seconds = 0.0

    def __call__(self, work, *inputs):
        begin = time.perf_counter()
        found = work(*inputs)
        self.seconds += time.perf_counter() - begin
        return found


def difference(pairs):
    """Median and 95th percentile of the relative difference of pairs of lists."""
    relative = np.concatenate([np.abs(a / b - 1) for a, b in pairs])
    return f"{100 * np.median(relative):.2f} % | {100 * np.quantile(relative, 0.95):.2f} %"


def compare(mesh, program, folder):
    positions, triangles = obj_or_off(mesh)
    of_exact, of_heat, own_seconds = Timed(), Timed(), 0.0
    solver = of_exact(PyGeodesicAlgorithmExact, positions, triangles)
    heat_solver = of_heat(potpourri3d.MeshHeatMethodDistanceSolver, positions, triangles)
    own_exact, own_heat, heat_exact = [], [], []
    for source in np.linspace(0, len(positions) - 1, SOURCES).astype(int):
        exact, _ = of_exact(solver.geodesicDistances, np.array([source]), None)
        heat = of_heat(heat_solver.compute_distance, source)
        output = folder / "distances.npy"
        words = [str(word) for word in (program, mesh, source, output)]
        own_seconds += float(subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()[0])
        own = np.load(output)
        away = np.isfinite(own) & (own > 0)
        own, exact, heat = own[away], exact[away], heat[away]
        own_exact.append((own, exact))
        own_heat.append((own, heat))
        heat_exact.append((heat, exact))
    differences = " | ".join(difference(pairs) for pairs in (own_exact, own_heat, heat_exact))
    seconds = f"{own_seconds:.2f} | {of_exact.seconds:.2f} | {of_heat.seconds:.2f}"
    return f"| {mesh.stem} | {len(positions):,} | {differences} | {seconds} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", type=Path, metavar="MESH")
    parser.add_argument("--program", default="target/release/examples/geodesic_distances")
    args = parser.parse_args()
    titles = "ours to exact | 95 % | ours to heat | 95 % | heat to exact | 95 % | ours, s | exact, s | heat, s"
    print(f"| mesh | vertices | {titles} |")
    print("| --- " * 11 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for mesh in args.meshes:
            print(compare(mesh, args.program, Path(folder)), flush=True)


if __name__ == "__main__":
    main()
