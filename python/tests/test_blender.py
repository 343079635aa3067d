"""The scene that tools/blender_scene.py makes, opened and rendered by Blender. Skipped without the package `bpy`."""

import importlib.util
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import mesotex  # noqa: E402

# Blender ends the process where it fails, so it has one of its own.
RENDER = """
import json
import sys
import bpy
import numpy as np

scene_file, folder, frames = sys.argv[1:4]
bpy.ops.wm.open_mainfile(filepath=scene_file)
scene = bpy.context.scene
mesh = next(item.data for item in bpy.data.objects if item.type == "MESH")
scene.cycles.samples = 1
scene.render.image_settings.file_format = "OPEN_EXR"
results = {"vertices": len(mesh.vertices), "triangles": len(mesh.polygons), "last": scene.frame_end}
results["attributes"] = sorted(item.name for item in mesh.attributes)
results["sun"] = bpy.data.lights["sun"].energy


def alpha(path):
    image = bpy.data.images.load(path)
    columns, rows = image.size
    return np.array(image.pixels[:]).reshape(rows, columns, 4)[..., 3] > 0.5


for number in (1, 2):
    scene.frame_set(number)
    scene.render.filepath = f"{folder}/drawn.{number}.exr"
    bpy.ops.render.render(write_still=True)
    ours, theirs = alpha(f"{frames}/frame.000{number}.exr"), alpha(scene.render.filepath)
    results[f"overlap {number}"] = float((ours & theirs).sum() / (ours | theirs).sum())
print("RESULTS", json.dumps(results))
"""


@unittest.skipIf(importlib.util.find_spec("bpy") is None, "bpy is not installed")
class Scene(unittest.TestCase):
    def test_the_model_covers_its_frames(self):
        with tempfile.TemporaryDirectory() as folder:
            at = Path(folder)
            self.make_inputs(at)
            for projection in ("perspective", "orthographic"):
                results = self.drawn(at, projection)
                self.assertEqual((results["vertices"], results["last"]), (500, 3))
                self.assertIn("_TEXTON", results["attributes"])
                self.assertIn("Color", results["attributes"])
                self.assertAlmostEqual(results["sun"], np.pi, places=3)
                self.assertGreater(min(results["overlap 1"], results["overlap 2"]), 0.98, projection)

    def test_what_is_no_frame_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            at = Path(folder)
            self.make_inputs(at)
            done = self.script(at / "a.glb", at, "-o", at / "a.blend")
            self.assertIn("found no frame.0001.exr", done.stderr)
            self.assertNotEqual(done.returncode, 0)

    @staticmethod
    def make_inputs(at):
        run = lambda command, *words: mesotex.run(command, *words, threads=1)
        grid = np.stack(np.meshgrid(np.arange(25), np.arange(20), indexing="ij"), -1).reshape(-1, 2) / 10
        with open(at / "hill.obj", "w", encoding="utf-8") as file:
            for x, z in grid:
                print("v", x, 0.5 * np.sin(2 * x) * np.cos(z), z, file=file)
            for i in range(24):
                for j in range(19):
                    first = 20 * i + j + 1
                    print("f", first, first + 1, first + 21, first + 20, file=file)
        small = ("--size", 16, "--views", "fibonacci:5", "--lights", "fibonacci:5", "--samples", 1)
        run("bake", "--preset", "weave", *small, "-o", at / "a.sample")
        run("textons", at / "a.sample", "-o", at / "a.textons.npz", "--textons", 20, "--levels", 1)
        run("gram", at / "a.textons.npz", "-o", at / "a.space.npz")
        run("knn", at / "a.space.npz", "-o", at / "a.knn.npz", "--k", 4)
        run("synth", at / "a.space.npz", at / "a.knn.npz", at / "hill.obj", "-o", at / "a.map.ply", "--levels", 1)
        run("export", at / "a.map.ply", "--to", "glb", "-o", at / "a.glb", "--sample", at / "a.sample")

    def drawn(self, at, projection):
        """What Blender says of the scene."""
        frames = at / projection
        picture = ("--size", "320x240", "--layers", "rgba", "--samples", 16, "--projection", projection)
        sweep = ("--sweep", "view-orbit", "--frames", 3)
        mesotex.run("render", at / "a.sample", at / "a.map.ply", "-o", frames, *picture, *sweep, threads=1)
        scene = at / f"{projection}.blend"
        done = self.script(at / "a.glb", frames, "-o", scene)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.python("-c", RENDER, scene, at, frames)
        self.assertEqual(done.returncode, 0, done.stderr)
        line = next(line for line in done.stdout.splitlines() if line.startswith("RESULTS"))
        return json.loads(line.removeprefix("RESULTS"))

    def script(self, *words):
        return self.python(ROOT / "tools/blender_scene.py", *words)

    @staticmethod
    def python(*words):
        return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, check=False)


if __name__ == "__main__":
    unittest.main()
