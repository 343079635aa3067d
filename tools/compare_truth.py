#!/usr/bin/env python3
"""Measures what a sample shows between its directions against the truth, end to end.

    tools/compare_truth.py --preset cobbles
    tools/compare_truth.py FOLDER --crop 256 --depth 0.08 --sets 12x5 bonn81
    tools/compare_truth.py --hexagons --sample-counts 1 4 16 --weights continuous quadratic inverse-angle

A material is baked at the directions of each set, and at `--views` × `--lights` directions that no set has: the truth
(`--truth-samples` rays per texel). The program then renders the sample on a flat grid, a vertex per texel, seen orthographically
from each of those views under each of those lights (pixel shading, the nearest texel, no shadows), and the pixel that shows a
texel's centre is compared with the truth at that texel. Held-out directions are spread evenly over the cosine of the angle from the normal,
down to `--largest-theta`, at random headings.

The material is a preset, a folder or file that `bake` reads (a folder of maps may be cropped from its upper left corner by
`--crop`, which makes it one that does not tile), or a relief of hexagonal prisms, 6 texels across, matte, of random colours, whose
heights are random between 0 and 6 texels (`--hexagons`).

Per sample, weighting and kind of blending it prints, over the pairs whose angles from the normal are both below 69 degrees:
the relative error Σ|rendered − truth| / Σ truth over linear values, the peak signal-to-noise ratio (1/π is the peak), and the
contrast, Σ std(rendered) / Σ std(truth) over images; then the relative error by the angle of the light, of views below 69 degrees, and by
the angle of the view, under lights below 69 degrees. Prints Markdown; `--json FILE` keeps all figures. `--oracle` blends the sample in NumPy
too, by the formulas of docs/rendering.md, and exits 1 where the program's images differ.

Needs: pip install numpy pillow OpenEXR
"""

import argparse
import itertools
import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

NEAR = 69.0  # degrees from the normal; figures over all directions stop here
BINS = (0, 30, 50, 69, 76, 90)
ACROSS = 6  # texels across a prism, and the largest difference of heights
BORDER = 4  # texels left out round a sample that does not tile
MARGIN = 24  # texels round a sample that tiles, so that nothing ends at its borders
LARGEST_DIFFERENCE = 1e-4  # from NumPy, of an image's largest value
PIXELS = 2.0  # per texel, where the view foreshortens it most


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    material = parser.add_mutually_exclusive_group(required=True)
    material.add_argument("material", nargs="?", type=Path, help="material file, or folder of maps")
    material.add_argument("--preset", help="built-in material")
    material.add_argument("--hexagons", action="store_true", help="relief of prisms")
    parser.add_argument("--crop", type=int, help="side in pixels of what is cut out of a folder's maps")
    parser.add_argument("--depth", type=float, help="as bake --depth")
    parser.add_argument("--size", type=int, default=64, help="texels")
    parser.add_argument("--sets", nargs="+", default=["12x5", "bonn81", "bonn151", "fibonacci:60", "fibonacci:150"])
    parser.add_argument("--sample-counts", nargs="+", type=int, default=[16], help="rays per texel of the samples")
    parser.add_argument("--truth-samples", type=int, default=64, help="rays per texel of the truth")
    parser.add_argument("--weights", nargs="+", default=["continuous", "quadratic", "inverse-angle"])
    parser.add_argument("--parallax", nargs="+", default=[None], help="as render --parallax, one or several")
    parser.add_argument("--views", type=int, default=12, help="held-out views")
    parser.add_argument("--lights", type=int, default=12, help="held-out lights")
    parser.add_argument("--largest-theta", type=float, default=84.0, help="degrees, of held-out directions")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default="target/release/mesotex")
    parser.add_argument("--threads", type=int, help="as the program's --threads")
    parser.add_argument("--folder", type=Path, help="where baked samples are kept, and taken from when they are there")
    parser.add_argument("--oracle", action="store_true", help="compare images without parallax with NumPy's, and stop where they differ")
    parser.add_argument("--json", type=Path, help="file for all figures")
    return parser.parse_args()


class Program:
    """The program under test."""

    def __init__(self, args):
        self.command = [args.program]
        self.always = ["--quiet"] + (["--threads", str(args.threads)] if args.threads else [])

    def __call__(self, *words):
        command = self.command + [str(word) for word in words] + self.always
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)}: {done.stderr}")


# ---- directions ----


def held_out(count, largest_theta, seed):
    """(theta, phi) in degrees: one at random in each of `count` equal parts of the cosine."""
    random = np.random.default_rng(seed)
    lowest = math.cos(math.radians(largest_theta))
    cosines = 1 - (np.arange(count) + random.uniform(0, 1, count)) / count * (1 - lowest)
    return np.stack([np.degrees(np.arccos(cosines)), random.uniform(0, 360, count)], 1)


def write_directions(path, directions):
    rows = "".join(f"{theta!r},{phi!r}\n" for theta, phi in directions.tolist())
    path.write_text("theta_deg,phi_deg\n" + rows)


def vector(direction):
    theta, phi = np.radians(direction)
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


# ---- materials ----


def hexagons(folder, size):
    """A relief of hexagonal prisms as a material, each texel in the prism whose axis is nearest."""
    random = np.random.default_rng(7)
    columns = round(size / ACROSS)
    rows = 2 * round(size / (ACROSS * math.sqrt(3)))
    row, column = np.divmod(np.arange(rows * columns), columns)
    axes = np.stack([(column + 0.5 * (row % 2)) * size / columns, row * size / rows], 1)
    place = np.arange(size) + 0.5
    texels = np.stack(np.meshgrid(place, place), -1).reshape(-1, 1, 2)
    offset = np.abs(texels - axes)
    offset = np.minimum(offset, size - offset)
    prism = np.argmin((offset**2).sum(-1), 1).reshape(size, size)
    heights = random.uniform(0, 1, len(axes))
    albedo = random.uniform(0.15, 0.85, (len(axes), 3))
    folder.mkdir()
    Image.fromarray(np.round(65535 * heights[prism]).astype(np.uint16)).save(folder / "height.png")
    encoded = np.where(albedo <= 0.0031308, 12.92 * albedo, 1.055 * albedo ** (1 / 2.4) - 0.055)
    Image.fromarray(np.round(255 * encoded[prism]).astype(np.uint8)).save(folder / "albedo.png")
    text = f'height = "height.png"\ndepth = {ACROSS / size}\nalbedo = "albedo.png"\n'
    (folder / "material.toml").write_text(text)
    return folder / "material.toml"


def cropped(folder, side, into):
    """The upper left corner of a folder's maps as a material that does not tile."""
    into.mkdir()
    lines = ["tileable = false"]
    for role in ("height", "albedo", "roughness"):
        found = sorted(folder.glob(f"{role}.*"))
        if found:
            name = f"{role}.png"
            Image.open(found[0]).crop((0, 0, side, side)).save(into / name)
            lines.append(f'{role} = "{name}"')
    (into / "material.toml").write_text("\n".join(lines) + "\n")
    return into / "material.toml"


class Samples:
    """Baked samples of the material, in a folder; those that are there are not baked again."""

    def __init__(self, args, program, temporary, views, lights):
        self.args, self.program = args, program
        self.folder = args.folder or temporary
        self.folder.mkdir(parents=True, exist_ok=True)
        self.material = material_words(args, temporary)
        self.held_out = [self.folder / "views.csv", self.folder / "lights.csv"]
        write_directions(self.held_out[0], views)
        write_directions(self.held_out[1], lights)

    def truth(self):
        args = self.args
        name = f"truth-{args.views}x{args.lights}-{args.largest_theta:g}-{args.seed}-{args.truth_samples}.sample"
        return self.baked(self.folder / name, *self.held_out, args.truth_samples)

    def of_set(self, directions, count):
        name = "".join(letter if letter.isalnum() else "-" for letter in Path(directions).name)
        return self.baked(self.folder / f"{name}-{count}.sample", directions, directions, count)

    def baked(self, sample, views, lights, count):
        if not sample.exists():
            size = self.args.size
            self.program("bake", *self.material, "--size", size, "--views", views, "--lights", lights, "--samples", count, "-o", sample)
        return sample


def material_words(args, folder):
    """What `bake` is told of the material."""
    depth = ["--depth", args.depth] if args.depth is not None else []
    if args.preset:
        return ["--preset", args.preset, *depth]
    if args.hexagons:
        return [hexagons(folder / "hexagons", args.size), *depth]
    if args.crop:
        return [cropped(args.material, args.crop, folder / "crop"), *depth]
    return [args.material, *depth]


# ---- rendering a flat grid ----


class FlatGrid:
    """A surface texton map of a sample on the plane z = 0, a vertex at each texel's centre."""

    def __init__(self, sample):
        head = json.loads((sample / "btf.json").read_text())
        self.width, self.height = head["width"], head["height"]
        self.tileable = head["tileable"]
        margin = MARGIN if self.tileable else 0
        self.columns = np.arange(-margin, self.width + margin)
        self.rows = np.arange(-margin, self.height + margin)  # upwards, 0 at the sample's lowest texels
        self.id = head["id"]

    def inner(self):
        """The texels that are compared."""
        border = 0 if self.tileable else BORDER
        return slice(border, self.height - border), slice(border, self.width - border)

    def write(self, path):
        x, y = np.meshgrid(self.columns + 0.5, self.rows + 0.5)
        x, y = x.ravel(), y.ravel()
        names = ["x", "y", "z", "nx", "ny", "nz", "sx", "sy", "sz", "s", "t"]
        vertices = np.zeros(len(x), [(name, "<f4") for name in names] + [("texton", "<u2")])
        # The grid's middle is the origin.
        vertices["x"], vertices["y"] = x - 0.5 * self.width, y - 0.5 * self.height
        vertices["nz"], vertices["sx"] = 1, 1
        vertices["s"], vertices["t"] = x % self.width, y % self.height
        across, up = len(self.columns), len(self.rows)
        corner = (np.arange(up - 1)[:, None] * across + np.arange(across - 1)).ravel()
        triangles = np.concatenate(
            [
                np.stack([corner, corner + 1, corner + across + 1], 1),
                np.stack([corner, corner + across + 1, corner + across], 1),
            ]
        )
        faces = np.zeros(len(triangles), [("count", "u1"), ("indices", "<i4", 3)])
        faces["count"], faces["indices"] = 3, triangles
        properties = [f"property float {name}" for name in names] + ["property ushort texton"]
        lines = [
            "ply", "format binary_little_endian 1.0", "comment mesotex 1", f"comment exemplar {self.width} {self.height}",
            "comment texel 1", "comment seed 0", f"comment sample {self.id}", f"comment space {self.id}",
            f"element vertex {len(vertices)}", *properties,
            f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header",
        ]
        path.write_bytes(("\n".join(lines) + "\n").encode() + vertices.tobytes() + faces.tobytes())


class View:
    """An orthographic picture of a flat grid, fine enough to show every texel."""

    def __init__(self, grid, direction):
        self.towards = vector(direction)
        self.right = np.cross([0, 0, 1], self.towards)
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.towards, self.right)
        x = np.arange(grid.width) + 0.5 - 0.5 * grid.width
        y = 0.5 * grid.height - 0.5 - np.arange(grid.height)
        points = np.stack([*np.meshgrid(x, y), np.zeros((grid.height, grid.width))], -1)
        self.across, self.upwards = points @ self.right, points @ self.up
        scale = PIXELS / self.towards[2]
        self.size = [math.ceil(scale * 2 * np.abs(side).max()) + 8 for side in (self.across, self.upwards)]
        self.view_height = self.size[1] / scale
        self.scale = scale

    def pixels(self):
        """Row and column of the pixel that shows each texel's centre."""
        column = np.floor(0.5 * self.size[0] + self.scale * self.across).astype(int)
        row = np.floor(0.5 * self.size[1] - self.scale * self.upwards).astype(int)
        return row, column


def render(program, sample, grid, view_direction, lights, options, folder):
    """Images [light, row, column, channel] of the grid as the program shows it."""
    view = View(grid, view_direction)
    # Light azimuth 0 is where the first camera stands.
    rows = [f"{phi - float(view_direction[1])!r},{90 - theta!r}" for theta, phi in lights.tolist()]
    sweep, frames = folder / "sweep.csv", folder / "frames"
    sweep.write_text("light_azimuth,light_elevation\n" + "\n".join(rows) + "\n")
    position = ",".join(repr(float(number)) for number in 1000 * view.towards)
    program(
        "render", sample, folder / "x.map.ply", "-o", frames, "--sweep", sweep, "--frames", len(lights), "--up", "z", "--projection", "orthographic",
        f"--camera-position={position}", "--camera-target=0,0,0", "--view-height", view.view_height,
        "--size", "x".join(map(str, view.size)), "--samples", 1, "--shading", "pixel", "--texels", "nearest", "--mip", "off",
        "--shadows", "none", "--irradiance", 1, "--layers", "rgba", "--float", *options,
    )  # fmt: skip
    images = [read_frame(path)[view.pixels()] for path in sorted(frames.glob("*.exr"))]
    for path in frames.iterdir():
        path.unlink()
    frames.rmdir()
    return np.stack(images)


def read_frame(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return np.stack([file.channels()[name].pixels.astype(np.float64) for name in "RGB"], -1)


# ---- the weights of docs/rendering.md, written again ----


def log_map(directions, wanted):
    """Coordinates of directions about a wanted one, and their angles to it."""
    first = np.cross(wanted, [0.3, -0.5, 0.2])
    first /= np.linalg.norm(first)
    x, y = directions @ first, directions @ np.cross(wanted, first)
    angles = np.arctan2(np.hypot(x, y), directions @ wanted)
    stretch = angles / np.maximum(np.hypot(x, y), 1e-12)
    return x * stretch, y * stretch, angles


def direction_weights(directions, wanted, weighting, negative):
    x, y, angles = log_map(directions, wanted)
    weights = np.zeros(len(directions))
    if angles.min() < 1e-4:
        weights[angles.argmin()] = 1
        return weights
    if weighting == "inverse-angle":
        nearest = np.argsort(angles, kind="stable")[:4]
        weights[nearest] = 1 / angles[nearest]
        return weights / weights.sum()
    counted = 5 if weighting == "continuous" else 10
    reach = min(math.pi, 1.05 * np.sort(angles)[counted - 1]) if len(angles) >= counted else math.pi
    nearness = np.where(angles < reach, ((reach - angles) / (reach * angles)) ** 2, 0)
    nearness /= nearness.sum()
    x, y = x / reach, y / reach
    terms = np.stack([np.ones_like(x), x, y] + ([x * x, y * y, math.sqrt(2) * x * y] if weighting == "quadratic" else []), 1)
    matrix = terms.T @ (terms * nearness[:, None])
    matrix += np.diag([0] + [1e-3 * np.trace(matrix) / len(matrix)] * (len(matrix) - 1))
    weights = nearness * (terms @ np.linalg.inv(matrix)[:, 0])
    if weighting == "continuous":
        weights *= np.where(weights < 0, negative, 1)
    return weights / weights.sum()


class Oracle:
    """A sample blended by NumPy, without parallax."""

    def __init__(self, sample, weighting):
        head = json.loads((sample / "btf.json").read_text())
        self.views, self.lights = np.array(head["views"]), np.array(head["lights"])
        self.radiance = np.load(sample / "radiance.npy", mmap_mode="r")
        self.weighting = weighting

    def image(self, view, light):
        of_views = direction_weights(self.views, view, self.weighting, 0)
        lowest = self.lights[:, 2].min()
        negative = min(max(4 * (1 - light[2] / lowest), 0), 1)
        of_lights = direction_weights(self.lights, light, self.weighting, negative)
        if self.weighting == "inverse-angle":
            of_lights *= min(1, light[2] / lowest)
        else:
            of_lights *= np.minimum(light[2] / self.lights[:, 2], 2)
        blend = 0
        for at in np.flatnonzero(of_views):
            kept = np.flatnonzero(of_lights)
            blend = blend + of_views[at] * np.tensordot(of_lights[kept], self.radiance[at, kept].astype(np.float64), 1)
        return np.maximum(blend, 0)


def check_against_oracle(sample, weighting, render_view, views, lights, inner):
    """Ends the run where the program's images differ from NumPy's."""
    oracle = Oracle(sample, weighting)
    worst = 0.0
    for view in views[:: max(1, len(views) // 4)]:
        rendered = render_view(view)
        for at, light in enumerate(lights):
            wanted = oracle.image(vector(view), vector(light))[inner]
            worst = max(worst, np.abs(rendered[at][inner] - wanted).max() / wanted.max())
    print(f"<!-- {weighting}: at most {worst:.1e} of an image's largest value from NumPy -->", flush=True)
    if worst > LARGEST_DIFFERENCE:
        raise SystemExit("the program does not blend as docs/rendering.md says")


# ---- figures ----


class Errors:
    """Errors of images, summed."""

    def __init__(self):
        self.absolute = self.truth = self.squares = self.count = 0.0
        self.spread = np.zeros(2)

    def add(self, rendered, truth):
        difference = rendered - truth
        self.absolute += np.abs(difference).sum()
        self.truth += truth.sum()
        self.squares += (difference**2).sum()
        self.count += truth.size
        self.spread += [image.std((0, 1)).sum() for image in (rendered, truth)]

    def figures(self):
        return {
            "relative_error": self.absolute / self.truth,
            "psnr": -10 * math.log10(self.squares / self.count * math.pi**2),
            "contrast": self.spread[0] / self.spread[1],
        }


def bin_of(theta):
    return next((low, high) for low, high in zip(BINS, BINS[1:]) if theta < high)


def measure(render_view, truth, views, lights, inner):
    """Figures over all near pairs, and relative errors by the angle of light and view."""
    whole, by_light, by_view = Errors(), {}, {}
    for view, (view_theta, _) in enumerate(views):
        rendered = render_view(views[view])
        for light, (light_theta, _) in enumerate(lights):
            pair = (rendered[light][inner], truth[view, light][inner])
            if view_theta < NEAR and light_theta < NEAR:
                whole.add(*pair)
            if view_theta < NEAR:
                by_light.setdefault(bin_of(light_theta), Errors()).add(*pair)
            if light_theta < NEAR:
                by_view.setdefault(bin_of(view_theta), Errors()).add(*pair)
    by_angle = lambda bins: {f"{low}-{high}": errors.figures()["relative_error"] for (low, high), errors in sorted(bins.items())}
    return {**whole.figures(), "by_light": by_angle(by_light), "by_view": by_angle(by_view)}


def title():
    angles = [f"{low}–{high}°" for low, high in zip(BINS, BINS[1:])]
    by = [f"{what} {angle}" for what in ("light", "view") for angle in angles]
    names = ["set", "samples", "weights", "parallax", "error", "PSNR", "contrast", *by]
    return "| " + " | ".join(names) + " |\n|" + " --- |" * len(names)


def line(result):
    angles = [f"{low}-{high}" for low, high in zip(BINS, BINS[1:])]
    shown = lambda bins: [f"{bins[angle]:.3f}" if angle in bins else "" for angle in angles]
    cells = [
        result["set"], str(result["samples"]), result["weights"], result["parallax"] or "",
        f"{result['relative_error']:.4f}", f"{result['psnr']:.1f}", f"{result['contrast']:.3f}",
        *shown(result["by_light"]), *shown(result["by_view"]),
    ]  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main():
    args = arguments()
    program = Program(args)
    views = held_out(args.views, args.largest_theta, [args.seed, 0])
    lights = held_out(args.lights, args.largest_theta, [args.seed, 1])
    results = []
    with tempfile.TemporaryDirectory() as name:
        samples = Samples(args, program, Path(name), views, lights)
        truth = np.load(samples.truth() / "radiance.npy").astype(np.float64)
        print(title(), flush=True)
        for directions, count in itertools.product(args.sets, args.sample_counts):
            sample = samples.of_set(directions, count)
            grid = FlatGrid(sample)
            grid.write(Path(name) / "x.map.ply")
            for weights, parallax in itertools.product(args.weights, args.parallax):
                options = ["--weights", weights] + (["--parallax", parallax] if parallax else [])
                render_view = lambda view: render(program, sample, grid, view, lights, options, Path(name))
                if args.oracle and parallax in (None, "off"):
                    check_against_oracle(sample, weights, render_view, views, lights, grid.inner())
                figures = measure(render_view, truth, views, lights, grid.inner())
                results.append({"set": directions, "samples": count, "weights": weights, "parallax": parallax, **figures})
                print(line(results[-1]), flush=True)
    if args.json:
        args.json.write_text(json.dumps({"options": vars(args), "results": results}, indent=1, default=str))


if __name__ == "__main__":
    main()
