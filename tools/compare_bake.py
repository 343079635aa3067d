#!/usr/bin/env python3
"""Compares `mesotex bake` with Mitsuba 3 on the same height field.

Bakes a material for random view and light directions, builds the same surface as a finely
triangulated mesh, traces the same view rays (orthographic, rectified to the mean plane) through
Mitsuba's path integrator, and prints per direction pair: the median relative difference of
radiance and the share of texels whose shadow mask agrees. The reflection model is written down again
here (class Coated), from docs/bake.md, not taken from the program.

    pip install numpy mitsuba
    export DRJIT_LIBLLVM_PATH=/path/to/libLLVM.so     # a recent LLVM, 15 or later
    python3 tools/compare_bake.py --preset weave
    python3 tools/compare_bake.py material.toml --size 128
    python3 tools/compare_bake.py folder/ --bounces 4 --samples 16  # mean radiance with interreflections
    python3 tools/compare_bake.py folder/ --speed      # view rays per second of both

Exits 1 when a tolerance of docs/bake.md is not met.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
import zipfile

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("material", nargs="?", help="material file or folder")
    parser.add_argument("--preset", help="built-in material")
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--depth", type=float, help="as bake --depth")
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--largest-theta", type=float, default=60.0, help="degrees")
    parser.add_argument("--divisions", type=int, default=4, help="mesh cells along a patch")
    parser.add_argument("--bounces", type=int, default=0)
    parser.add_argument("--samples", type=int, default=4, help="per texel; raise it with --bounces")
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def random_directions(count, largest_theta, seed):
    """(theta, phi) in degrees, even in solid angle up to the largest theta."""
    random = np.random.default_rng(seed)
    lowest = math.cos(math.radians(largest_theta))
    theta = np.degrees(np.arccos(random.uniform(lowest, 1.0, count)))
    return theta, random.uniform(0.0, 360.0, count)


def write_directions(path, directions):
    with open(path, "w") as file:
        file.write("theta_deg,phi_deg\n")
        for theta, phi in zip(*directions):
            file.write(f"{float(theta)!r},{float(phi)!r}\n")


def bake(args, folder, views, lights, extra=()):
    """Runs the program; returns the sample's description and radiance, its surface, its report."""
    sample, surface = os.path.join(folder, "x.sample"), os.path.join(folder, "x.npz")
    command = [args.program, "bake", "-o", sample, "--surface", surface, "--json"]
    command += ["--preset", args.preset] if args.preset else [args.material]
    command += ["--depth", str(args.depth)] if args.depth else []
    command += ["--size", str(args.size), "--views", views, "--lights", lights, "--dtype", "f4"]
    command += ["--samples", str(args.samples), "--angular-filter", "off", *extra]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    description = json.load(open(os.path.join(sample, "btf.json")))
    radiance = np.load(os.path.join(sample, "radiance.npy"), mmap_mode="r")
    return description, radiance, np.load(surface), report


def read_meta(path):
    with zipfile.ZipFile(path) as archive:
        return json.loads(archive.read("meta.json"))


def height_function(heights, tileable):
    """Bilinear interpolation between texel centres; x = column, y upwards, row H-1 at y = 0."""
    up = heights[::-1].astype(np.float64)
    if not tileable:
        up = np.concatenate([up, up[::-1]], 0)
        up = np.concatenate([up, up[:, ::-1]], 1)
    rows, columns = up.shape

    def height(x, y):
        x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
        u, v = x - x0, y - y0
        at = lambda dx, dy: up[(y0 + dy) % rows, (x0 + dx) % columns]
        return (at(0, 0) * (1 - u) + at(1, 0) * u) * (1 - v) + (at(0, 1) * (1 - u) + at(1, 1) * u) * v

    return height


def build_mesh(height, shape, margin, divisions):
    """The surface over the texel grid and a margin round it, two triangles a division."""
    rows, columns = shape
    x = np.arange(-margin * divisions, (columns + margin) * divisions + 1) / divisions
    y = np.arange(-margin * divisions, (rows + margin) * divisions + 1) / divisions
    grid_x, grid_y = np.meshgrid(x, y)
    z = height(grid_x, grid_y)
    positions = np.stack([grid_x, grid_y, z], -1).reshape(-1, 3).astype(np.float32)
    across, down = len(x), len(y)
    corner = (np.arange(down - 1)[:, None] * across + np.arange(across - 1)[None, :]).ravel()
    lower = np.stack([corner, corner + 1, corner + across + 1], -1)
    upper = np.stack([corner, corner + across + 1, corner + across], -1)
    faces = np.concatenate([lower, upper]).astype(np.uint32)
    return positions, faces


def load_mesh(positions, faces, bsdf):
    properties = mi.Properties()
    properties["bsdf"] = bsdf
    properties["face_normals"] = True
    mesh = mi.Mesh("surface", len(positions), len(faces), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float(positions.ravel())
    parameters["faces"] = mi.UInt32(faces.ravel())
    parameters.update()
    return mesh


class Coated(mi.BSDF):
    """docs/bake.md: GGX coat over a Lambert or Oren-Nayar base, maps looked up by position."""

    maps = None  # set before loading: dict of tensors and numbers

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags
        maps = self.maps
        self.shape = maps["albedo"].shape[:2]
        stack = np.concatenate([maps["albedo"], maps["roughness"][..., None], maps["metallic"][..., None]], -1)
        wrap = dr.WrapMode.Repeat if maps["tileable"] else dr.WrapMode.Mirror
        self.texture = mi.Texture2f(mi.TensorXf(stack.astype(np.float32)), wrap_mode=wrap)

    def look_up(self, si, active):
        rows, columns = self.shape
        uv = mi.Point2f((si.p.x + 0.5) / columns, (rows - 1 - si.p.y + 0.5) / rows)
        r, g, b, roughness, metallic = self.texture.eval(uv, active)
        return mi.Color3f(r, g, b), roughness, metallic

    def eval(self, ctx, si, wo, active=True):
        albedo, roughness, metallic = self.look_up(si, active)
        cos_v, cos_l = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (cos_v > 0) & (cos_l > 0)
        base = albedo / dr.pi * (1 - metallic)
        sigma = self.maps["oren_nayar_sigma"]
        if sigma is not None:
            a = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33)
            b = 0.45 * sigma**2 / (sigma**2 + 0.09)
            sin_v, sin_l = mi.Frame3f.sin_theta(si.wi), mi.Frame3f.sin_theta(wo)
            cos_phi = (si.wi.x * wo.x + si.wi.y * wo.y) / dr.maximum(sin_v * sin_l, 1e-12)
            sin_alpha = dr.maximum(sin_v, sin_l)
            tan_beta = dr.minimum(sin_v / cos_v, sin_l / cos_l)
            base *= a + b * dr.maximum(cos_phi, 0) * sin_alpha * tan_beta
        value = base
        if not self.maps["matte"]:
            reflectance = self.maps["reflectance"]
            f0 = reflectance * (1 - metallic) + albedo * metallic
            f90 = dr.minimum(50 * dr.max(f0), 1)
            schlick = lambda c: f0 + (f90 - f0) * (1 - c) ** 5
            mean = f0 + (f90 - f0) / 21
            alpha = dr.maximum(roughness**2, 1e-3)
            half = dr.normalize(si.wi + wo)
            cos_h = mi.Frame3f.cos_theta(half)
            d = alpha**2 / (dr.pi * (cos_h**2 * (alpha**2 - 1) + 1) ** 2)
            # Smith: G = 1 / (1 + Λ(v) + Λ(l)), Λ = (sqrt(1 + α² tan²) − 1) / 2
            smith = lambda w: 0.5 * (dr.sqrt(1 + alpha**2 * mi.Frame3f.tan_theta_2(w)) - 1)
            g = 1 / (1 + smith(si.wi) + smith(wo))
            coat = schlick(dr.dot(half, wo)) * d * g / (4 * cos_v * cos_l)
            value = base * (1 - schlick(cos_v)) * (1 - schlick(cos_l)) / (1 - mean) + coat
        return dr.select(active, value * cos_l, 0.0)

    def pdf(self, ctx, si, wo, active=True):
        cos = mi.Frame3f.cos_theta(wo)
        active &= (mi.Frame3f.cos_theta(si.wi) > 0) & (cos > 0)
        return dr.select(active, mi.warp.square_to_cosine_hemisphere_pdf(wo), 0.0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        sample = mi.BSDFSample3f(wo)
        sample.pdf = self.pdf(ctx, si, wo, active)
        sample.eta = 1.0
        sample.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        sample.sampled_component = 0
        weight = self.eval(ctx, si, wo, active) / dr.maximum(sample.pdf, 1e-9)
        return sample, weight & (active & (sample.pdf > 0))

    def traverse(self, callback):
        pass

    def to_string(self):
        return "Coated[]"


mi.register_bsdf("coated", Coated)


def make_scene(mesh, light):
    return mi.load_dict(
        {
            "type": "scene",
            "surface": mesh,
            "light": {"type": "directional", "direction": [-c for c in light], "irradiance": {"type": "rgb", "value": 1.0}},
        }
    )


def sample_places(count):
    """Where in a texel samples look through, from its centre: van der Corput and Sobol, shifted (docs/bake.md)."""
    reversed_bits = lambda i: int(f"{i:032b}"[::-1], 2)

    def sobol(i):
        bits, direction = 0, 1 << 31
        while i:
            bits ^= direction if i & 1 else 0
            i, direction = i >> 1, direction ^ direction >> 1
        return bits

    points = np.array([[reversed_bits(i), sobol(i)] for i in range(count)]) / 2.0**32
    return (points + (0.53 if count == 1 else 0.5 / count)) % 1.0 - 0.5


def view_rays(shape, views, highest, samples):
    """Rays through every texel of the mean plane, view after view."""
    rows, columns = shape
    row, col = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    on_plane = np.stack([col, rows - 1 - row, np.zeros_like(row)], -1).reshape(-1, 3).astype(np.float64)
    origins, directions = [], []
    for view in np.asarray(views, dtype=np.float64):
        place = np.repeat(on_plane, samples, 0)
        place[:, :2] += np.tile(sample_places(samples), (len(on_plane), 1))
        origins.append(place + view * ((highest + 1.0) / view[2]))
        directions.append(np.broadcast_to(-view, place.shape))
    origins, directions = np.concatenate(origins), np.concatenate(directions)
    return mi.Ray3f(mi.Point3f(origins.T.astype(np.float32)), mi.Vector3f(directions.T.astype(np.float32)))


def radiance_of(integrator, scene, rays, seed=0):
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, dr.width(rays))
    value = integrator.sample(scene, sampler, mi.RayDifferential3f(rays))[0]
    dr.eval(value)
    return np.array(value).T


def setup(args, folder, views, lights, extra=(), divisions=None):
    description, radiance, surface, report = bake(args, folder, views, lights, extra)
    meta = read_meta(os.path.join(folder, "x.npz"))
    Coated.maps = {**meta, **{name: surface[name] for name in ("albedo", "roughness", "metallic")}}
    heights = surface["heights"]
    relief = float(heights.max() - heights.min())
    theta = max(math.acos(d[2]) for d in description["views"] + description["lights"])
    margin = int(math.ceil(2 * relief * math.tan(min(theta, math.radians(80))))) + 2
    height = height_function(heights, meta["tileable"])
    mesh = build_mesh(height, heights.shape, margin, divisions or args.divisions)
    return description, radiance, report, heights, mesh


def compare(args, folder):
    views, lights = os.path.join(folder, "views.csv"), os.path.join(folder, "lights.csv")
    write_directions(views, random_directions(args.pairs, args.largest_theta, args.seed))
    write_directions(lights, random_directions(args.pairs, args.largest_theta, args.seed + 1))
    extra = ["--bounces", str(args.bounces)] if args.bounces else []
    description, radiance, _, heights, (positions, faces) = setup(args, folder, views, lights, extra)
    mesh = load_mesh(positions, faces, mi.load_dict({"type": "coated"}))
    integrator = mi.load_dict({"type": "path", "max_depth": 2 + args.bounces, "rr_depth": 1000})
    medians, agreements, means = [], [], []
    print("pair  theta_v theta_l  median_difference  shadow_agreement  mean_ratio")
    for pair in range(args.pairs):
        view, light = description["views"][pair], description["lights"][pair]
        scene = make_scene(mesh, light)
        rays = view_rays(heights.shape, [view], float(heights.max()), args.samples)
        wanted = radiance_of(integrator, scene, rays, args.seed).reshape(-1, args.samples, 3).mean(1)
        found = np.asarray(radiance[pair, pair]).reshape(-1, 3)
        lit = (wanted.max(1) > 0) & (found.max(1) > 0)
        difference = np.abs(found - wanted)[lit].sum(1) / np.maximum(wanted[lit].sum(1), 1e-9)
        medians.append(float(np.median(difference)))
        agreements.append(float(((wanted.max(1) > 0) == (found.max(1) > 0)).mean()))
        means.append(float(found.mean() / wanted.mean()))
        theta = [math.degrees(math.acos(d[2])) for d in (view, light)]
        print(f"{pair:4}  {theta[0]:7.1f} {theta[1]:7.1f}  {medians[-1]:17.5f}  {agreements[-1]:16.4f}  {means[-1]:10.4f}")
    worst_median, worst_agreement = max(medians), min(agreements)
    mean_off = abs(float(np.mean(means)) - 1)
    print(f"median difference: {np.median(medians):.5f}, worst pair {worst_median:.5f}")
    print(f"shadow agreement:  {np.mean(agreements):.4f}, worst pair {worst_agreement:.4f}")
    print(f"mean radiance:     {np.mean(means):.4f} of Mitsuba's, worst pair {max(means, key=lambda m: abs(m - 1)):.4f}")
    if args.bounces:
        return mean_off <= 0.02
    return float(np.median(medians)) <= 0.02 and float(np.mean(agreements)) >= 0.98


def cpu_seconds(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def speed(args, folder):
    """View rays a second: 60 x 60 directions here; every light of it one wavefront of 60 views there.
    Best wall-clock time of three each, and processor time, which other programs disturb less."""
    runs = []
    for _ in range(3):
        begun = cpu_seconds(resource.RUSAGE_CHILDREN)
        description, _, report, heights, (positions, faces) = setup(args, folder, "12x5", "12x5", divisions=1)
        runs.append((report["seconds"], cpu_seconds(resource.RUSAGE_CHILDREN) - begun))
    lights = description["lights"]
    mesh = load_mesh(positions, faces, mi.load_dict({"type": "coated"}))
    integrator = mi.load_dict({"type": "path", "max_depth": 2})
    rays = view_rays(heights.shape, description["views"], float(heights.max()), args.samples)
    scenes = [make_scene(mesh, light) for light in lights[::10]]
    radiance_of(integrator, scenes[0], rays)  # compiles
    theirs = []
    for _ in range(3):
        begun = time.perf_counter(), cpu_seconds(resource.RUSAGE_SELF)
        for scene in scenes:
            radiance_of(integrator, scene, rays)
        scale = len(lights) / len(scenes)
        theirs.append((scale * (time.perf_counter() - begun[0]), scale * (cpu_seconds(resource.RUSAGE_SELF) - begun[1])))
    count = heights.size * args.samples * len(description["views"]) * len(lights)
    wall, cpu = (tuple(min(run[i] for run in runs) for runs in (runs, theirs)) for i in (0, 1))
    for name, i in (("mesotex", 0), ("mitsuba", 1)):
        print(f"{name}: {wall[i]:.2f} s ({cpu[i]:.2f} s of processor) for {count / 1e6:.1f} M view rays, {count / wall[i] / 1e6:.2f} M a second")
    print(f"ratio:   {wall[1] / wall[0]:.1f} by the clock, {cpu[1] / cpu[0]:.1f} by processor time")
    return wall[1] >= 4 * wall[0]


def main():
    args = arguments()
    with tempfile.TemporaryDirectory() as folder:
        good = speed(args, folder) if args.speed else compare(args, folder)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
