#!/usr/bin/env python3
"""Compares ways of keeping highlights between the sampled directions, with the truth by angle.

A glossy material is baked for a set of directions
  off      as it is,
  on       with highlights widened to the spacing of the directions (`--angular-filter on`),
  cells    with every image averaged over its light's cell: baked for several directions spread over
           each cell, which costs as many times more,
and its images are interpolated for pairs of view and light that are not in the set, with the linear
weights of rendering. The truth is a bake for those pairs. Printed are sum |difference| / sum radiance over
all pairs, over those whose half vector lies within 10, 10 to 25 and more than 25 degrees of the normal,
over views and lights below and above 45 degrees, and the PSNR over all values (white is 1).

    pip install numpy pillow
    tools/compare_angular_filter.py scales facade/:0.03 --set 12x5 --picture sheet.png

`--picture` writes, for a plane of the material under a light that moves, a row per way and one of the truth.
"""

import argparse
import json
import math
import os
import subprocess
import tempfile

import numpy as np
from PIL import Image

SIDE_BY_SIDE = 12
PER_CELL = 9


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("materials", nargs="+", metavar="MATERIAL[:DEPTH]")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--set", default="12x5")
    parser.add_argument("--size", default="32")
    parser.add_argument("--samples", default="4", help="of the bakes that are compared; the truth has 16")
    parser.add_argument("--pairs", type=int, default=120)
    parser.add_argument("--skip-cells", action="store_true")
    parser.add_argument("--picture")
    parser.add_argument("--threads", help="as of the program")
    return parser.parse_args()


def write_directions(path, directions):
    theta = np.degrees(np.arccos(np.clip(directions[:, 2], -1.0, 1.0)))
    phi = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))
    with open(path, "w") as file:
        file.write("theta_deg,phi_deg\n")
        for pair in zip(theta, phi):
            file.write(f"{float(pair[0])!r},{float(pair[1])!r}\n")


def spherical(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def random_directions(random, count, largest_theta=69.0):
    theta = np.arccos(random.uniform(math.cos(math.radians(largest_theta)), 1.0, count))
    return spherical(theta, random.uniform(0.0, 2.0 * math.pi, count))


def held_out_pairs(count, seed=1):
    """Half of the pairs at random, half near the mirror direction of the mean plane."""
    random = np.random.default_rng(seed)
    views = random_directions(random, count)
    lights = random_directions(random, count)
    half = spherical(random.uniform(0.0, math.radians(12.0), count), random.uniform(0.0, 2.0 * math.pi, count))
    mirrored = 2.0 * (views * half).sum(1, keepdims=True) * half - views
    near = (np.arange(count) % 2 == 0) & (mirrored[:, 2] > math.cos(math.radians(69.0)))
    return views, np.where(near[:, None], mirrored, lights)


def bake(args, material, views, lights, extra):
    name, _, depth = material.partition(":")
    source = [name] if os.path.exists(name) else ["--preset", name]
    command = [args.program, "bake", *source, "-o", "x.sample", "--json", "--size", args.size, "--dtype", "f4"]
    command += ["--views", views, "--lights", lights]
    command += ["--threads", args.threads] if args.threads else []
    command += (["--depth", depth] if depth else []) + extra
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    description = json.load(open("x.sample/btf.json"))
    # Read whole: the next bake replaces the file.
    return np.load("x.sample/radiance.npy"), description, report


def truth_at(args, material, views, lights):
    images = []
    for first in range(0, len(views), 20):
        write_directions("v.csv", views[first : first + 20])
        write_directions("l.csv", lights[first : first + 20])
        radiance, _, _ = bake(args, material, "v.csv", "l.csv", ["--samples", "16", "--angular-filter", "off"])
        images += [radiance[i, i] for i in range(len(radiance))]
    return np.stack(images)


def weights(directions, wanted):
    """Of rendering's `continuous`: all directions within 1.05 times the angle to the fifth nearest, linear change exact."""
    cos = np.clip(directions @ wanted, -1.0, 1.0)
    angles = np.arccos(cos)
    if angles.min() < 1e-4:
        return (np.arange(len(angles)) == angles.argmin()).astype(float)
    reach = 1.05 * np.sort(angles)[4]
    near = angles < reach
    d = angles[near]
    b = ((reach - d) / (reach * d)) ** 2
    b /= b.sum()
    axis = np.eye(3)[np.abs(wanted).argmin()]
    tangent = np.cross(wanted, axis)
    tangent /= np.linalg.norm(tangent)
    bitangent = np.cross(wanted, tangent)
    across = directions[near] - cos[near, None] * wanted
    across *= (d / np.maximum(np.linalg.norm(across, axis=1), 1e-12) / reach)[:, None]
    p = np.stack([np.ones_like(d), across @ tangent, across @ bitangent], 1)
    a = (p * b[:, None]).T @ p
    a[[1, 2], [1, 2]] += 1e-3 * np.trace(a) / 3.0
    w = np.zeros(len(angles))
    w[near] = np.maximum(0.0, b * (p @ np.linalg.solve(a, [1.0, 0.0, 0.0])))
    return w / w.sum()


def interpolated(radiance, views, lights, view, light):
    w_view, w_light = weights(views, view), weights(lights, light)
    w_light = w_light * np.minimum(light[2] / np.maximum(lights[:, 2], 1e-9), 2.0)
    pairs = [(i, j) for i in np.flatnonzero(w_view) for j in np.flatnonzero(w_light)]
    return sum(w_view[i] * w_light[j] * radiance[i, j].astype(np.float64) for i, j in pairs)


def cell_directions(lights, per_cell, seed=2):
    """`per_cell` directions spread over the cell of each light: the part of the sphere nearest to it, within the reach
    of the fifth nearest light, above the horizon."""
    random = np.random.default_rng(seed)
    chosen = []
    for light in lights:
        reach = np.sort(np.arccos(np.clip(lights @ light, -1.0, 1.0)))[5]
        reach = min(reach, math.radians(30.0))
        cos = random.uniform(math.cos(reach), 1.0, 4000)
        phi = random.uniform(0.0, 2.0 * math.pi, 4000)
        tangent = np.cross(light, np.eye(3)[np.abs(light).argmin()])
        tangent /= np.linalg.norm(tangent)
        bitangent = np.cross(light, tangent)
        sin = np.sqrt(1.0 - cos**2)
        around = np.outer(cos, light) + np.outer(sin * np.cos(phi), tangent) + np.outer(sin * np.sin(phi), bitangent)
        around = around[(around[:, 2] > 0.0) & ((around @ lights.T).argmax(1) == (lights @ light).argmax())]
        # Farthest points first: an even spread. Each stands for the part of the cell that is nearest to it.
        spread = [int((around @ light).argmax())]
        while len(spread) < per_cell:
            spread.append(int((around @ around[spread].T).max(1).argmin()))
        for _ in range(8):
            nearest = (around @ around[spread].T).argmax(1)
            centres = [around[nearest == k].mean(0) for k in range(per_cell)]
            spread = [int((around @ centre).argmax()) for centre in centres]
        chosen.append(around[spread])
    return np.concatenate(chosen)


def averaged_over_cells(args, material, lights):
    """Baked for every direction of the cells, in groups of views that fit memory; the mean of each cell."""
    write_directions("cells.csv", cell_directions(lights, PER_CELL))
    radiance, _, report = bake(args, material, args.set, "cells.csv", ["--samples", args.samples, "--angular-filter", "off"])
    views, _, height, width, channels = radiance.shape
    return radiance.reshape(views, len(lights), PER_CELL, height, width, channels).mean(2), report


def ways(args, material):
    found = {}
    for name in ("off", "on"):
        extra = ["--samples", args.samples, "--angular-filter", name]
        radiance, description, report = bake(args, material, args.set, args.set, extra)
        found[name] = (radiance, report)
    views, lights = np.array(description["views"]), np.array(description["lights"])
    if not args.skip_cells:
        found["cells"] = averaged_over_cells(args, material, lights)
    return found, views, lights


def write_picture(args, material, found, views, lights, path):
    """Strips of the material under a light that rises, seen from 40 degrees: a row per way, the truth last."""
    steps = np.linspace(5.0, 65.0, SIDE_BY_SIDE)
    view = spherical(math.radians(40.0), math.radians(17.0))
    moving = np.stack([spherical(math.radians(theta), math.radians(197.0 + 0.3 * theta)) for theta in steps])
    rows = []
    for radiance, _ in found.values():
        rows.append(np.concatenate([interpolated(radiance, views, lights, view, light) for light in moving], 1))
    rows.append(np.concatenate(list(truth_at(args, material, np.repeat(view[None], len(moving), 0), moving)), 1))
    linear = np.clip(np.concatenate(rows, 0) * math.pi, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    Image.fromarray((255.0 * encoded + 0.5).astype(np.uint8)).save(path)


def main():
    args = arguments()
    args.program = os.path.abspath(args.program)
    picture = os.path.abspath(args.picture) if args.picture else None
    materials = []
    for material in args.materials:
        name, colon, depth = material.partition(":")
        materials.append((os.path.abspath(name) if os.path.exists(name) else name) + colon + depth)
    view, light = held_out_pairs(args.pairs)
    half = view + light
    half_angle = np.degrees(np.arccos(np.clip(half[:, 2] / np.linalg.norm(half, axis=1), -1.0, 1.0)))
    steep = lambda directions: directions[:, 2] > math.cos(math.radians(45.0))
    groups = {
        "all": np.full(args.pairs, True),
        "h<10": half_angle < 10.0,
        "h 10-25": (half_angle >= 10.0) & (half_angle < 25.0),
        "h>25": half_angle >= 25.0,
        "view<45": steep(view),
        "view>45": ~steep(view),
        "light<45": steep(light),
        "light>45": ~steep(light),
    }
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for index, material in enumerate(materials):
            truth = truth_at(args, material, view, light).astype(np.float64)
            found, views, lights = ways(args, material)
            print(f"{os.path.basename(material)}, {args.set}: pairs " + ", ".join(f"{k} {v.sum()}" for k, v in groups.items()))
            print(f"{'way':8}" + "".join(f"{name:>10}" for name in groups) + f"{'PSNR':>10}{'seconds':>10}")
            for name, (radiance, report) in found.items():
                images = np.stack([interpolated(radiance, views, lights, v, l) for v, l in zip(view, light)])
                off, all_ = np.abs(images - truth).sum((1, 2, 3)), truth.sum((1, 2, 3))
                errors = [off[chosen].sum() / all_[chosen].sum() for chosen in groups.values()]
                square = np.mean((np.clip(images * math.pi, 0, 1) - np.clip(truth * math.pi, 0, 1)) ** 2)
                line = "".join(f"{error:10.4f}" for error in errors)
                print(f"{name:8}{line}{-10.0 * math.log10(square):10.2f}{report['seconds']:10.2f}", flush=True)
            if picture:
                path = picture if len(materials) == 1 else picture.replace(".png", f".{index}.png")
                write_picture(args, material, found, views, lights, path)


if __name__ == "__main__":
    main()
