#!/usr/bin/env python3
"""Runs the commands of docs/gallery.md and draws its pictures again.

    tools/draw_gallery.py --program target/release/mesotex --meshes MESHES --materials MATERIALS --folder WORK [-o PICTURES] [--only CHAPTER …]

MESHES holds bunny.obj, bunny.off, spot.obj, torus.obj, horse.obj and fertility.off. MATERIALS
holds folders with height.png, albedo.png and roughness.png of ambientCG's Facade005 (`facade`), Leather025 (`leather`) and Bark014 (`bark`).
Every chapter (`## `) of the page is one shell script in a folder of WORK. Blocks of JSON become the file that the commands
before them read as `--keys`. A chapter that ended is not run again while its commands and the program stay the same. Figures
of the reports are printed. Pictures are put together of frames and exemplars as PICTURES_OF says, and written to
docs/images/gallery unless -o names another folder.

Needs: pip install pillow numpy scipy OpenEXR; for the picture of three.js what tools/draw_glb.mjs needs, in WORK or above
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "gallery.md"
GAP = 8
MARGIN = 12
QUALITY = 88
FIGURES = ("coherence_half", "coherence_one", "energy", "energy_ratio_full", "histogram_chi2")
WIDTH = 1200  # pixels; a wider row is made smaller, none is made larger


def frames(*names):
    """First frames of folders, side by side; all cut by the box that holds what is drawn in any."""
    return [f"{name}/frame.0001.png" for name in names], None, True


def frames_of(name, count):
    return [f"{name}/frame.{index:04}.png" for index in range(1, count + 1)], None, True


def images(*names, height):
    return list(names), height, False


TWO_SAMPLES = "Two samples on three meshes"
# Of every picture: its chapter, then its rows.
PICTURES_OF = {
    "../hero.jpg": ("The picture of the README", [([f"{name}/frame.0001.png" for name in ("leather", "bark", "cobbles")], 480, False)]),
    "weave.jpg": (TWO_SAMPLES, [frames_of(f"weave-{mesh}", 3) for mesh in ("torus", "bunny", "fertility")]),
    "facade.jpg": (TWO_SAMPLES, [frames_of(f"facade-{mesh}", 3) for mesh in ("torus", "bunny", "fertility")]),
    **{
        f"three-methods-{preset}.png": (
            "Three methods on one mesh",
            [frames(*(f"{preset}-{method}" for method in ("k-coherence", "wei-levoy", "adaptive")))],
        )
        for preset in ("bricks", "weave")
    },
    "atlas-zebra.jpg": ("Texture atlases", [frames("zebra-640", "zebra-400", "zebra-256")]),
    "atlas-wicker.jpg": (
        "Texture atlases",
        [(["wicker.png", "wicker-multiscale/frame.0001.png", "wicker-k-coherence/frame.0001.png"], 360, False)],
    ),
    "atlas-cross.jpg": ("Texture atlases", [frames("cross-flat", "cross-multiscale", "cross-coherent")]),
    "atlas-stones.jpg": (
        "Texture atlases",
        [(["stones-flat/frame.0001.png", "stones-displaced/frame.0001.png", ("stones-flat.png", 1, 3)], 360, False)],
    ),
    "progressive-leopard.jpg": (
        "Progressively-variant textures",
        [images("leopard.color.png", height=256), frames("leopard", "leopard-behind")],
    ),
    "progressive-tiger.jpg": (
        "Progressively-variant textures",
        [images("tiger.color.png", height=256), frames("tiger", "tiger-behind")],
    ),
    "progressive-giraffe.jpg": (
        "Progressively-variant textures",
        [images("giraffe.color.png", height=256), frames("giraffe", "giraffe-behind")],
    ),
    "progressive-without-masks.jpg": (
        "Progressively-variant textures",
        [images("stones.color.png", height=256), frames("stones", "unmasked")],
    ),
    "progressive-marble.jpg": (
        "Progressively-variant textures",
        [images("marble-slice.color.png", height=256), frames("marble", "marble-behind")],
    ),
    "progressive-blends.jpg": (
        "Progressively-variant textures",
        [images("pale.png", f"marble-{by}.color.png", "red.png", height=192) for by in ("slice", "average", "mixture")],
    ),
    "progressive-worn.jpg": (
        "Progressively-variant textures",
        [images("worn.color.png", height=256), frames_of("worn", 4)],
    ),
    "faces-globes.jpg": (
        "Textures on faces",
        [
            images("rust.png", "pale.png", "water.png", "burl.png", height=128),
            frames("rust-globe", "pale-globe", "water-globe", "burl-globe"),
        ],
    ),
    "faces-bunnies.jpg": ("Textures on faces", [frames("rust-bunny", "pale-bunny", "water-bunny", "burl-bunny")]),
    "faces-isotropic.jpg": (
        "Textures on faces",
        [images("zebra.png", "candy.png", height=128), frames("zebra-globe", "candy-globe")],
    ),
}


def chapters():
    """Of every chapter that has commands: its heading, its script, its files of keys."""
    found, heading = {}, "Gallery"
    for part in re.split(r"^(## .*)$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE):
        if part.startswith("## "):
            heading = part[3:].strip()
            continue
        script, keys = found.setdefault(heading, ([], {}))
        for kind, block in re.findall(r"^```(text|json)\n(.*?)^```$", part, flags=re.MULTILINE | re.DOTALL):
            if kind == "text":
                script.append(block)
            else:
                keys[re.findall(r"--keys (\S+)", script[-1])[0]] = block
    return {heading: ("".join(script), keys) for heading, (script, keys) in found.items() if script}


def folder_of(work, heading):
    return work / re.sub(r"\W+", "-", heading.lower())


def link(folder, files):
    for name, target in files.items():
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(target.resolve())


def run(heading, script, keys, args):
    """Runs a chapter unless it ended before with the same commands of the same program."""
    folder, done = folder_of(args.folder, heading), folder_of(args.folder, heading) / "done.sh"
    identity = f"# {hashlib.sha256(args.program.read_bytes()).hexdigest()}\n{script}"
    if done.is_file() and done.read_text() == identity:
        print(f"{heading}: ran before")
        return
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    link(folder, {path.name: path for path in args.meshes.iterdir() if path.suffix in (".obj", ".off")})
    link(folder, {"materials": args.materials, "tools": ROOT / "tools"})
    (folder / "facade").mkdir()
    for name, text in keys.items():
        (folder / name).write_text(text)
    bin_folder = folder / "bin"
    bin_folder.mkdir()
    link(bin_folder, {"mesotex": args.program})
    print(f"{heading}: runs", flush=True)
    path = f"{bin_folder.resolve()}:{os.environ['PATH']}"
    ended = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, env=os.environ | {"PATH": path})
    if ended.returncode:
        sys.exit(f"{heading}: a command failed; see above")
    done.write_text(identity)


def print_figures(folder):
    """The figures of quality in the reports that a chapter keeps."""
    for path in sorted(folder.glob("*.json")):
        report = json.loads(path.read_text())
        if "histogram_chi2" not in report:
            continue
        (s, _), (_, t) = report["drift"]
        figures = {name: report[name] for name in FIGURES}
        print(f"{path.stem}: drift {s:.2f}, {t:.2f}, " + ", ".join(f"{name} {value:.3g}" for name, value in figures.items()))


def drawn_box(picture):
    """The box of what differs from the picture's corner, in pixels: left, top, right, bottom."""
    pixels = np.asarray(picture, dtype=int)
    drawn = np.abs(pixels - pixels[0, 0]).max(axis=2) > 4
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    return columns[0], rows[0], columns[-1] + 1, rows[-1] + 1


def cut(pictures):
    """All pictures of a row, cut by one box."""
    boxes = np.array([drawn_box(picture) for picture in pictures])
    left, top = np.maximum(boxes[:, :2].min(axis=0) - MARGIN, 0)
    right, bottom = np.minimum(boxes[:, 2:].max(axis=0) + MARGIN, pictures[0].size)
    return [picture.crop((left, top, right, bottom)) for picture in pictures]


def row_of(folder, row):
    """A row as one picture, at most WIDTH wide. Parts of a row with a height are enlarged or reduced to it."""
    paths, height, is_cut = row
    pictures = [opened(folder, path) for path in paths]
    pictures = cut(pictures) if is_cut else pictures
    if height:
        pictures = [part.resize((round(part.width * height / part.height), height), Image.LANCZOS) for part in pictures]
    strip = beside(pictures)
    return strip.resize((WIDTH, round(strip.height * WIDTH / strip.width)), Image.LANCZOS) if strip.width > WIDTH else strip


def opened(folder, path):
    """A picture, or the part (index, count) of one that holds several side by side."""
    path, index, count = (path, 0, 1) if isinstance(path, str) else path
    picture = Image.open(folder / path).convert("RGB")
    width = picture.width // count
    return picture.crop((index * width, 0, (index + 1) * width, picture.height))


def beside(pictures):
    sheet = Image.new("RGB", (sum(p.width for p in pictures) + GAP * (len(pictures) - 1), pictures[0].height), "white")
    left = 0
    for picture in pictures:
        sheet.paste(picture, (left, 0))
        left += picture.width + GAP
    return sheet


def draw(folder, rows):
    """Rows below each other, all as wide as the widest; a narrower row of samples keeps its size in the middle."""
    strips = [row_of(folder, row) for row in rows]
    width = max(strip.width for strip in strips)
    sheet = Image.new("RGB", (width, sum(strip.height for strip in strips) + GAP * (len(strips) - 1)), "white")
    top = 0
    for strip in strips:
        sheet.paste(strip, ((width - strip.width) // 2, top))
        top += strip.height + GAP
    return sheet


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True, help="the mesotex that draws")
    parser.add_argument("--meshes", type=Path, required=True, help="folder of the meshes")
    parser.add_argument("--materials", type=Path, required=True, help="folder of folders of maps")
    parser.add_argument("--folder", type=Path, required=True, help="folder for everything that the commands write")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "images" / "gallery", help="folder of the pictures")
    parser.add_argument("--only", nargs="+", metavar="CHAPTER", help="headings of the chapters to run and draw")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    found = chapters()
    unknown = set(args.only or ()) - set(found)
    if unknown:
        sys.exit(f"no chapter {', '.join(sorted(unknown))}; the page has {', '.join(found)}")
    for heading, (script, keys) in found.items():
        if args.only and heading not in args.only:
            continue
        run(heading, script, keys, args)
        print_figures(folder_of(args.folder, heading))
        for name, (of, rows) in PICTURES_OF.items():
            if of == heading:
                draw(folder_of(args.folder, heading), rows).save(args.output / name, quality=QUALITY)
                print(f"wrote {args.output / name}", flush=True)


if __name__ == "__main__":
    main()
