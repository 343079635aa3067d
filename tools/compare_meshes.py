#!/usr/bin/env python3
"""Compares what mesotex reads of mesh files with what trimesh reads.

Needs: pip install numpy pillow trimesh

    tools/compare_meshes.py MESH...          bounds, area, volume and number of distinct corners
    tools/compare_meshes.py --make DIR       the same for 36 meshes that are made in DIR: shapes near zero, at
                                             map coordinates and at the Earth's centre, in every format

Bounds are compared by the diagonal, area and volume by themselves; both programs must agree to 1e-6. Where
mesotex repaired a mesh, the repairs are printed beside the difference. The exit code counts differences without
one. `--mesotex PATH` names the program (default: target/release/mesotex); `--json` prints the figures as JSON.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import trimesh

TOLERANCE = 1e-6
PLACES = {"near": (0, 0, 0), "utm": (500_000.25, 5_000_000.5, 320.125), "ecef": (4_485_513.7, 651_341.2, 4_471_887.9)}


def shapes():
    """Closed and open shapes, of every size."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=1.5)
    ring = trimesh.creation.torus(major_radius=2.0, minor_radius=0.5)
    tube = trimesh.creation.cylinder(radius=0.3, height=2.0)
    open_box = trimesh.creation.box(extents=(1, 2, 3))
    open_box.update_faces(np.arange(len(open_box.faces)) > 1)
    tiny = trimesh.creation.capsule(radius=1e-3, height=4e-3)
    two = trimesh.util.concatenate([trimesh.creation.box(), trimesh.creation.icosphere().apply_translation((3, 0, 0))])
    return {"ball": ball, "ring": ring, "tube": tube, "open": open_box, "tiny": tiny, "two": two}


def obj_text(mesh):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]) + "\n"


def ply_doubles(mesh):
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(mesh.vertices)}\nproperty double x\n"
        f"property double y\nproperty double z\nelement face {len(mesh.faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(mesh.faces), [("size", "u1"), ("corners", "<i4", 3)])
    rows["size"], rows["corners"] = 3, mesh.faces
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + rows.tobytes()


def off_text(mesh):
    lines = [f"OFF\n{len(mesh.vertices)} {len(mesh.faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    return "\n".join(lines + [f"3 {a} {b} {c}" for a, b, c in mesh.faces.tolist()]) + "\n"


def make(folder):
    """Every shape in six formats, the formats with doubles in turn at the three places."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, (name, mesh) in enumerate(shapes().items()):
        for turn, extension in enumerate(["obj", "double.ply", "off", "ply", "stl", "glb"]):
            place = list(PLACES)[(number + turn) % 3] if turn < 3 else "near"
            moved = mesh.copy().apply_translation(PLACES[place])
            path = folder / f"{name}_{place}.{extension}"
            if extension == "obj":
                path.write_text(obj_text(moved))
            elif extension == "off":
                path.write_text(off_text(moved))
            elif extension == "double.ply":
                path.write_bytes(ply_doubles(moved))
            else:
                moved.export(path)
            paths.append(path)
    return paths


def by_trimesh(path):
    mesh = trimesh.load(path, process=False, force="mesh")
    corners = mesh.vertices[np.unique(mesh.faces)]
    closed = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    closed.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=12)
    # Volumes as sums about a corner of the mesh: about zero, far coordinates cancel.
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - mesh.bounds[0] for k in range(3))
    return {
        "bounds": [corners.min(0).tolist(), corners.max(0).tolist()],
        "area": float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()),
        "trimesh_area": float(mesh.area),
        "volume": float((a * np.cross(b, c)).sum() / 6) if closed.is_watertight else None,
        "corners": len(np.unique(corners, axis=0)),
    }


def by_mesotex(program, path):
    run = subprocess.run([program, "info", str(path), "--json"], capture_output=True, text=True)
    if run.returncode:
        return {"refused": run.stderr.strip()}
    told = json.loads(run.stdout)
    repairs = told["repairs"]
    return {
        "bounds": told["bounds"],
        "area": told["area"],
        "volume": told["volume"],
        "corners": told["vertices"] - repairs["unused_vertices"] - repairs["split_vertices"],
        "repairs": {name: value for name, value in repairs.items() if value and name not in ("unused", "welded_vertices", "notes")},
    }


def difference(ours, theirs):
    """The largest relative difference of each figure."""
    size = np.linalg.norm(np.subtract(*theirs["bounds"]))
    found = {
        "bounds": float(np.abs(np.subtract(ours["bounds"], theirs["bounds"])).max() / size),
        "area": abs(ours["area"] / theirs["area"] - 1),
        "corners": float(ours["corners"] != theirs["corners"]),
    }
    if (ours["volume"] is None) != (theirs["volume"] is None):
        found["volume"] = 1.0
    elif ours["volume"] is not None:
        # A folded shape can enclose next to nothing: its volume is small against size³.
        found["volume"] = abs(ours["volume"] - theirs["volume"]) / max(abs(theirs["volume"]), 1e-3 * size**3)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="*", type=Path)
    parser.add_argument("--make", type=Path, metavar="DIR")
    parser.add_argument("--mesotex", default="target/release/mesotex")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    paths = options.meshes + (make(options.make) if options.make else [])
    rows, unexplained = [], 0
    for path in paths:
        ours = by_mesotex(options.mesotex, path)
        try:
            theirs = by_trimesh(path)
        except Exception as error:  # trimesh raises whatever its parsers raise
            theirs = {"refused": repr(error)}
        row = {"file": str(path), "mesotex": ours, "trimesh": theirs}
        if "refused" in ours or "refused" in theirs:
            row["verdict"] = f"mesotex: {ours.get('refused', 'read')}; trimesh: {theirs.get('refused', 'read')}"
            unexplained += "refused" in ours and "refused" not in theirs
        else:
            row["difference"] = difference(ours, theirs)
            apart = [name for name, value in row["difference"].items() if value > TOLERANCE]
            if not apart:
                row["verdict"] = "equal"
            elif ours["repairs"]:
                row["verdict"] = f"{', '.join(apart)} differ by repair: {ours['repairs']}"
            else:
                row["verdict"] = f"{', '.join(apart)} DIFFER"
                unexplained += 1
        rows.append(row)
        if not options.json:
            worst = max(row["difference"].values()) if "difference" in row else float("nan")
            print(f"{path.name:34} {worst:9.1e}  {row['verdict']}")
    if options.json:
        json.dump(rows, sys.stdout, indent=1)
    else:
        print(f"{len(rows)} meshes, {unexplained} differences without a reason")
    return min(unexplained, 1)


if __name__ == "__main__":
    sys.exit(main())
