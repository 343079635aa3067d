#!/usr/bin/env python3
"""Compares a frame of `mesotex render` with Mitsuba 3 on the same mesh, camera and light.

Depth, normals and shadows of a frame are set against rays traced by Mitsuba through the pixels'
centres, with the camera and the light read from the frame's header.

    pip install mitsuba numpy OpenEXR
    mesotex render A.sample A.map.ply -o frames --shadows pixel \
        --layers rgba,depth,normal,uv,texton,shadow
    tools/compare_mitsuba.py A.map.ply frames/frame.0001.exr

Prints, over the pixels that both cover: the share whose depths differ by less than 1e-3 of the
scene's size (the diagonal of its bounding box), the share whose normals differ by less than 1
degree, and the share whose shadow is the same (frames with shadow.Y and a directional light;
rays to it start where `render` starts them).
Exit code 1 when one is below 99.9 %, 99.9 %, 99.5 %.
"""

import argparse
import sys

import mitsuba as mi
import numpy as np
import OpenEXR

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")


def read_map(path):
    """Positions, normals and triangles of a binary little-endian map."""
    with open(path, "rb") as file:
        counts, properties, element = {}, [], None
        for line in iter(file.readline, b"end_header\n"):
            words = line.split()
            if words[0] == b"element":
                element = words[1].decode()
                counts[element] = int(words[2])
            elif words[0] == b"property" and element == "vertex":
                kind = {b"float": "<f4", b"ushort": "<u2"}[words[1]]
                properties.append((words[2].decode(), kind))
        vertices = np.frombuffer(file.read(counts["vertex"] * np.dtype(properties).itemsize), properties)
        faces = np.frombuffer(file.read(), [("count", "u1"), ("corners", "<i4", 3)])
    columns = lambda names: np.stack([vertices[name] for name in names], 1).astype(np.float32)
    return columns(("x", "y", "z")), columns(("nx", "ny", "nz")), faces["corners"].astype(np.uint32)


def read_frame(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        header = dict(file.header())
        channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
    return header, channels


def mesh_of(positions, normals, triangles):
    mesh = mi.Mesh("surface", len(positions), len(triangles), has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = positions.ravel()
    parameters["vertex_normals"] = normals.ravel()
    parameters["faces"] = triangles.ravel()
    parameters.update()
    return mesh


def matrix(header, name):
    return np.array(header[name], float).reshape(4, 4)


def pixel_rays(header, width, height):
    """Origins and directions through the pixels' centres, from the two matrices (row vectors)."""
    ndc_from_world = matrix(header, "worldToNDC")
    world_from_ndc = np.linalg.inv(ndc_from_world)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    world_from_camera = np.linalg.inv(matrix(header, "worldToCamera"))
    ahead = world_from_camera[2, :3]
    perspective = np.abs(ndc_from_world[:3, 3]).max() > 1e-12
    at = lambda depth: np.stack([x, y, np.full_like(x, depth), np.ones_like(x)], -1).reshape(-1, 4) @ world_from_ndc
    if perspective:
        origin = np.broadcast_to(world_from_camera[3, :3], (width * height, 3))
        points = at(0.5)
        direction = points[:, :3] / points[:, 3:] - origin
    else:
        origin = at(0.0)[:, :3]
        direction = np.broadcast_to(ahead, origin.shape)
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return origin, direction, world_from_camera[3, :3], ahead


def trace(scene, origins, directions):
    """What rays meet: whether anything, hit points, interpolated normals, and the triangles' numbers."""
    vector = lambda a: mi.Vector3f(*np.ascontiguousarray(a.T, dtype=np.float32))
    if "scalar" not in mi.variant():
        hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(vector(origins)), vector(directions)))
        valid = np.array(hit.is_valid())
        to_array = lambda v: np.array(v).reshape(3, -1).T.astype(np.float64)
        return valid, to_array(hit.p), to_array(hit.sh_frame.n), np.array(hit.prim_index).astype(np.int64)
    count = len(origins)
    valid = np.zeros(count, bool)
    points, normals, triangles = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count, np.int64)
    for k in range(count):
        hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(origins[k].tolist()), mi.Vector3f(directions[k].tolist())))
        if hit.is_valid():
            valid[k] = True
            points[k], normals[k], triangles[k] = hit.p, hit.sh_frame.n, hit.prim_index
    return valid, points, normals, triangles


def smooth_starts(corners, normals, points, lift):
    """Where shadow rays start: on the smooth surface where it bulges over a triangle (Hanika 2021), and a little above."""
    edges = np.roll(corners, -1, 1) - corners
    facets = np.cross(edges[:, 0], edges[:, 1])
    squared = (facets**2).sum(1)
    # Twice the area that a point spans with the edge opposite each corner, over the triangle's.
    spanned = np.cross(np.roll(edges, -1, 1), points[:, None] - np.roll(corners, -1, 1))
    shares = (spanned * facets[:, None]).sum(2) / squared[:, None]
    depths = np.maximum(((corners - points[:, None]) * normals).sum(2), 0)
    outside = np.sign((facets * normals.sum(1)).sum(1))[:, None] * facets / np.sqrt(squared)[:, None]
    return points + ((shares * depths)[:, :, None] * normals).sum(1) + lift * outside


def is_lit(scene, starts, own, light, step):
    """Whether nothing lies between each point and the light but the triangle `own` that it belongs to."""
    towards = np.broadcast_to(light, starts.shape)
    blocked, points, _, triangles = trace(scene, starts, towards)
    again = blocked & (triangles == own)
    blocked[again] = trace(scene, points[again] + step * light, towards[again])[0]
    return ~blocked


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map")
    parser.add_argument("frame")
    parser.add_argument("--variant", choices=VARIANTS, help="of Mitsuba; default: llvm where it runs")
    arguments = parser.parse_args()
    for variant in [arguments.variant] if arguments.variant else VARIANTS:
        try:
            mi.set_variant(variant)
            mi.Point3f(0)
            break
        except Exception as error:
            print(f"{variant}: {error}", file=sys.stderr)
    positions, normals, triangles = read_map(arguments.map)
    size = np.linalg.norm(np.ptp(positions, axis=0))
    scene = mi.load_dict({"type": "scene", "surface": mesh_of(positions, normals, triangles)})
    header, channels = read_frame(arguments.frame)
    height, width = channels["A"].shape
    origins, directions, camera, ahead = pixel_rays(header, width, height)
    valid, points, found_normals, hit = trace(scene, origins, directions)

    covered = channels["A"].ravel() > 0
    both = covered & valid
    print(f"{mi.variant()}: {width}x{height}, covered by both {both.sum()}, by one alone {(covered ^ valid).sum()}")
    depth = (points - camera) @ ahead
    depth_off = np.abs(depth - channels["Z"].ravel())[both] / size
    normal = np.stack([channels[name].ravel() for name in ("N.X", "N.Y", "N.Z")], 1)
    cosine = np.clip((normal * found_normals).sum(1), -1, 1)[both]
    shares = {
        "depth within 1e-3 of the scene": ((depth_off < 1e-3).mean(), 0.999),
        "normals within 1 degree": ((np.degrees(np.arccos(cosine)) < 1).mean(), 0.999),
    }
    if "shadow.Y" in channels and "lightDirection" in header:
        light = np.array(header["lightDirection"], float)
        starts = smooth_starts(positions[triangles[hit[both]]], normals[triangles[hit[both]]], points[both], 1e-5 * size)
        lit = is_lit(scene, starts, hit[both], light, 1e-5 * size) & (found_normals[both] @ light > 0)
        shares["shadows the same"] = ((lit == (channels["shadow.Y"].ravel()[both] > 0.5)).mean(), 0.995)
    failed = False
    for name, (share, wanted) in shares.items():
        failed |= share < wanted
        print(f"{name}: {100 * share:.3f} % (wanted {100 * wanted:.1f} %)")
    sys.exit(int(failed))


if __name__ == "__main__":
    main()
