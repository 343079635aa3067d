#!/usr/bin/env python3
"""Compares mesotex's charts and orientation fields with independent ones.

Needs: pip install numpy scipy potpourri3d

    tools/compare_geometry.py field MESH REPORT.json    smallest eigenvalue by SciPy, on potpourri3d's
                                                        connection Laplacian, against the energy that
                                                        `mesotex mesh MESH -o OUT.ply --report` found
    tools/compare_geometry.py charts MESH CACHE.npz     geodesics shot by potpourri3d's GeodesicTracer
                                                        from vertices to known (s, t), against the
                                                        neighbour positions of a prepared surface
                                                        (MESH.mesotex-cache/*.surface.npz)
    tools/compare_geometry.py evenness MESH...          edge variation, smallest angles

MESH is a PLY that mesotex wrote, or an OFF. `--json` prints the figures as JSON.
"""
import argparse
import json
import sys
import zipfile

import numpy as np


def read_mesh(path):
    if path.endswith(".off"):
        with open(path) as file:
            words = file.read().split()
        vertices, faces = int(words[1]), int(words[2])
        numbers = np.array(words[4:], dtype=float)
        positions = numbers[: 3 * vertices].reshape(-1, 3)
        triangles = numbers[3 * vertices : 3 * vertices + 4 * faces].reshape(-1, 4)[:, 1:]
        return positions, triangles.astype(np.int64)
    types = {"float": "<f4", "uchar": "u1", "ushort": "<u2", "int": "<i4"}
    with open(path, "rb") as file:
        header, element, properties, counts = b"", "", [], {}
        while not header.endswith(b"end_header\n"):
            line = file.readline()
            header += line
            words = line.decode().split()
            if words[:1] == ["element"]:
                element = words[1]
                counts[element] = int(words[2])
            elif words[:1] == ["property"] and element == "vertex":
                properties.append((words[2], types[words[1]]))
        rows = np.frombuffer(file.read(counts["vertex"] * np.dtype(properties).itemsize), properties)
        row = np.dtype([("size", "u1"), ("corners", "<i4", 3)])
        triangles = np.frombuffer(file.read(counts["face"] * row.itemsize), row)["corners"]
    positions = np.stack([rows["x"], rows["y"], rows["z"]], 1).astype(float)
    return positions, triangles.astype(np.int64)


def corner_angles(positions, triangles):
    angles = np.empty(triangles.shape)
    for k in range(3):
        a, b, c = (positions[triangles[:, (k + j) % 3]] for j in range(3))
        u, v = b - a, c - a
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(1))
    return angles


def compare_field(mesh, report):
    import potpourri3d as pp3d
    import scipy.sparse as sparse
    import scipy.sparse.linalg as linalg

    positions, triangles = read_mesh(mesh)
    laplacian = pp3d.MeshVectorHeatSolver(positions, triangles).get_connection_laplacian().tocsc()
    mass = sparse.diags(pp3d.vertex_areas(positions, triangles)).tocsc()
    value = linalg.eigsh(laplacian, 1, mass, sigma=-1e-8 * laplacian.diagonal().real.max())[0][0]
    with open(report) as file:
        found = json.load(file)
    return {
        "smallest_eigenvalue": float(value),
        "field_energy": found["field_energy"],
        "ratio": found["field_energy"] / float(value),
        "singularity_index_sum": found["singularity_index_sum"],
        "euler_characteristic": found["euler_characteristic"],
    }


def compare_charts(mesh, cache, vertices, seed):
    """Shoots a geodesic to every neighbour's (s, t) and measures how far from it it ends."""
    import potpourri3d as pp3d

    arrays = np.load(cache)

    def level0(name, dtype, width=None):
        values = arrays[f"L0/{name}"].view(dtype)
        return values if width is None else values.reshape(-1, width)

    positions = level0("positions", "<f4", 3).astype(float)
    triangles = level0("triangles", "<u4", 3).astype(np.int64)
    normals = level0("normals", "<f4", 3).astype(float)
    s_axes = level0("orientations", "<f4", 3).astype(float)
    t_axes = np.cross(normals, s_axes)
    starts = level0("neighbor_starts", "<u4")
    neighbors = level0("neighbors", np.dtype([("site", "<u4"), ("x", "<f4"), ("y", "<f4")]))
    texel = json.loads(zipfile.ZipFile(cache).read("meta.json"))["texel"]
    tracer = pp3d.GeodesicTracer(positions, triangles)
    random = np.random.default_rng(seed)
    errors = []
    for vertex in random.choice(len(positions), min(vertices, len(positions)), replace=False):
        for entry in neighbors[starts[vertex] : starts[vertex + 1]]:
            s, t = entry["x"] * texel, entry["y"] * texel
            radius = np.hypot(s, t)
            if radius < 0.5 * texel:
                continue
            direction = s * s_axes[vertex] + t * t_axes[vertex]
            path = tracer.trace_geodesic_from_vertex(int(vertex), direction / np.linalg.norm(direction) * radius)
            errors.append(np.linalg.norm(path[-1] - positions[entry["site"]]) / radius)
    errors = np.array(errors)
    return {
        "geodesics": len(errors),
        "median_error_over_radius": float(np.median(errors)),
        "error_over_radius_90": float(np.quantile(errors, 0.9)),
    }


def evenness(mesh):
    positions, triangles = read_mesh(mesh)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.sort(edges, 1), axis=0)
    lengths = np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)
    smallest = np.degrees(corner_angles(positions, triangles).min(1))
    return {
        "mesh": mesh,
        "vertices": len(positions),
        "edge_variation": float(lengths.std() / lengths.mean()),
        "share_above_20_degrees": float((smallest > 20).mean()),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")
    commands = parser.add_subparsers(dest="command", required=True)
    field = commands.add_parser("field")
    field.add_argument("mesh")
    field.add_argument("report")
    charts = commands.add_parser("charts")
    charts.add_argument("mesh")
    charts.add_argument("cache")
    charts.add_argument("--vertices", type=int, default=200)
    charts.add_argument("--seed", type=int, default=0)
    even = commands.add_parser("evenness")
    even.add_argument("meshes", nargs="+")
    arguments = parser.parse_args()
    if arguments.command == "field":
        found = [compare_field(arguments.mesh, arguments.report)]
    elif arguments.command == "charts":
        found = [compare_charts(arguments.mesh, arguments.cache, arguments.vertices, arguments.seed)]
    else:
        found = [evenness(mesh) for mesh in arguments.meshes]
    for figures in found:
        if arguments.json:
            json.dump(figures, sys.stdout)
            print()
        else:
            print("  ".join(f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}" for name, value in figures.items()))


if __name__ == "__main__":
    main()
