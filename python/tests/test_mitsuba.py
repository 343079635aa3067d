"""The plugin for Mitsuba 3, against the formulas and against `mesotex render`. Skipped where Mitsuba does not run."""

import importlib.util
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

import mesotex  # noqa: E402

try:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    import drjit as dr

    import mesotex.mitsuba

    mesotex.mitsuba.register()
    MISSING = None
except (ImportError, RuntimeError) as error:
    MISSING = str(error)


def write_torus(path, around=40, across=20):
    """A torus of triangles, as OBJ."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    ring = 1 + 0.45 * np.cos(v)
    points = np.stack([ring * np.cos(u), 0.45 * np.sin(v), -ring * np.sin(u)], -1).reshape(-1, 3)
    at = lambda i, j: (i % around) * across + j % across + 1
    with open(path, "w", encoding="utf-8") as file:
        for point in points:
            print("v", *point, file=file)
        for i in range(around):
            for j in range(across):
                print("f", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), file=file)


def run(command, *words):
    return mesotex.run(command, *words, threads=1)


@unittest.skipIf(MISSING, f"Mitsuba: {MISSING}")
class Plugin(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        at = cls.at = Path(cls.folder.name)
        write_torus(at / "torus.obj")
        directions = ("--views", "fibonacci:24", "--lights", "fibonacci:20")
        run("bake", "--preset", "weave", "--size", 32, *directions, "--samples", 1, "-o", at / "a.sample")
        run("textons", at / "a.sample", "-o", at / "a.textons.npz", "--textons", 20, "--levels", 2)
        run("gram", at / "a.textons.npz", "-o", at / "a.space.npz")
        run("knn", at / "a.space.npz", "-o", at / "a.knn.npz", "--k", 4)
        run("synth", at / "a.space.npz", at / "a.knn.npz", at / "torus.obj", "-o", at / "a.map.ply", "--levels", 2)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def bsdf(self, **properties):
        paths = {"sample": str(self.at / "a.sample"), "map": str(self.at / "a.map.ply")}
        return mi.load_dict({"type": "mesotex", **paths, **properties})

    def seen(self, count):
        """What rays from all round see of the torus, and those that see it."""
        scene = mi.load_dict({"type": "scene", "torus": self.shape()})
        numbers = np.random.default_rng(5).normal(size=(3, count)).astype(np.float32)
        origin = mi.Point3f(*(4 * numbers / np.linalg.norm(numbers, axis=0)))
        target = mi.Point3f(*np.random.default_rng(6).uniform(-1, 1, (3, count)).astype(np.float32))
        si = scene.ray_intersect(mi.Ray3f(origin, dr.normalize(target - origin)))
        # Computed before the scene is gone: evaluation is lazy, and runs beside this thread.
        dr.eval(si)
        dr.sync_thread()
        return si, si.is_valid()

    def shape(self, **options):
        return mesotex.mitsuba.shape(self.at / "a.sample", self.at / "a.map.ply", **options)

    @staticmethod
    def directions(count, seed):
        numbers = np.random.default_rng(seed).normal(size=(3, count)).astype(np.float32)
        numbers[2] = np.abs(numbers[2])
        return mi.Vector3f(*(numbers / np.linalg.norm(numbers, axis=0)))

    def test_weights_are_those_of_the_formula(self):
        directions = mesotex.read_sample(self.at / "a.sample").lights
        found = mesotex.mitsuba._Directions(directions)
        for seed in range(20):
            wanted = np.array(self.directions(1, seed)).ravel().astype(float)
            expected = weights_of(directions, wanted)
            fit = found.fit(mi.Vector3f(*map(float, wanted)), are_lights=True)
            start, end = int(fit.start[0]), int(fit.end[0])
            weights = np.zeros(len(directions))
            for candidate in range(start, end):
                index, weight = found.weight(fit, mi.UInt32(candidate))
                weights[int(index[0])] = float(weight[0])
            np.testing.assert_allclose(weights, expected, atol=2e-4)

    def test_frames_agree(self):
        if importlib.util.find_spec("OpenEXR") is None:
            self.skipTest("OpenEXR is not installed")
        exact = ("--shading", "pixel", "--shadows", "pixel", "--texels", "bilinear", "--mip", "off", "--parallax", "off")
        picture = ("--frames", 1, "--size", "640x480", "--samples", 1, "--layers", "rgba,shadow")
        run("render", self.at / "a.sample", self.at / "a.map.ply", "-o", self.at / "frames", *picture, *exact)
        tool = [sys.executable, str(ROOT / "tools/compare_mitsuba_btf.py")]
        files = [self.at / name for name in ("a.sample", "a.map.ply", "frames/frame.0001.exr")]
        done = subprocess.run([*tool, *map(str, files)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_samples_have_the_value_of_their_direction(self):
        si, active = self.seen(2000)
        bsdf, context = self.bsdf(), mi.BSDFContext()
        points = mi.Point2f(*np.random.default_rng(7).uniform(size=(2, 2000)).astype(np.float32))
        found, weight = bsdf.sample(context, si, mi.Float(0.5), points, active)
        value, density = bsdf.eval_pdf(context, si, found.wo, active)
        active &= found.pdf > 1e-3
        self.assertGreater(int(dr.count(active)[0]), 500)
        np.testing.assert_allclose(np.array(dr.select(active, density - found.pdf, 0)), 0, atol=1e-4)
        apart = dr.select(active, weight * found.pdf - value, 0)
        np.testing.assert_allclose(np.array(apart), 0, atol=1e-4)

    def test_a_moved_surface_looks_the_same(self):
        turn = mi.ScalarTransform4f().translate([3, 1, 0]).rotate([0, 1, 0], 40).scale(2.5)
        still, active = self.seen(500)
        context, wo = mi.BSDFContext(), self.directions(500, 3)
        expected = self.bsdf().eval(context, still, wo, active)
        moved = mi.load_dict({"type": "scene", "torus": self.shape(to_world=turn)})
        matrix = mi.Transform4f(turn.matrix)
        viewer = matrix @ still.to_world(still.wi)
        place = matrix @ still.p
        si = moved.ray_intersect(mi.Ray3f(place + viewer, -viewer))
        light = dr.normalize(matrix @ still.to_world(wo))
        bsdf = self.bsdf(to_world=turn)
        value = bsdf.eval(context, si, si.to_local(light), active & si.is_valid())
        apart = np.abs(np.array(dr.select(active, value - expected, 0)))
        # A ray may meet the triangle beside the edge that it met before.
        self.assertLess(np.quantile(apart.max(axis=0), 0.98), 2e-3)

    def test_a_path_tracer_draws_it(self):
        camera = mi.ScalarTransform4f().look_at(origin=[0, 3, 3], target=[0, 0, 0], up=[0, 1, 0])
        film = {"type": "hdrfilm", "width": 24, "height": 16, "pixel_format": "rgb"}
        scene = mi.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {"type": "perspective", "to_world": camera, "film": film},
            "sky": {"type": "constant"},
            "torus": self.shape(texels="nearest"),
        })
        picture = np.array(mi.render(scene, spp=16))
        self.assertTrue(np.isfinite(picture).all())
        # Nothing reflects more than the sky sends, and nothing is black.
        self.assertLess(picture.max(), 1.05)
        self.assertGreater(picture.min(), 0.005)

    def test_what_does_not_fit_is_refused(self):
        with self.assertRaisesRegex(Exception, "bilinear or nearest"):
            self.bsdf(texels="cubic")
        small = ("--size", 16, "--views", "fibonacci:5", "--lights", "fibonacci:5", "--samples", 1)
        run("bake", "--preset", "weave", *small, "-o", self.at / "small.sample")
        with self.assertRaisesRegex(Exception, "exemplar: \\(32, 32\\)"):
            self.bsdf(sample=str(self.at / "small.sample"))
        mi.set_variant("scalar_rgb")
        try:
            with self.assertRaisesRegex(RuntimeError, "expected llvm_ad_rgb"):
                mesotex.mitsuba.register()
        finally:
            mi.set_variant("llvm_ad_rgb")


def weights_of(directions, wanted):
    """The weights of lights as docs/rendering.md has them."""
    angles = np.arccos(np.clip(directions @ wanted, -1, 1))
    reach = min(1.05 * np.sort(angles)[4], np.pi)
    if angles.min() < 1e-4:
        nearness = np.eye(len(directions))[angles.argmin()]
        return nearness * np.minimum(wanted[2] / directions[:, 2], 2)
    nearness = np.where(angles < reach, ((reach - angles) / (reach * angles)) ** 2, 0)
    nearness /= nearness.sum()
    along = np.cross([0.3, 0.5, 0.8], wanted)
    along /= np.linalg.norm(along)
    plane = directions @ np.stack([along, np.cross(wanted, along)], 1)
    place = plane / np.linalg.norm(plane, axis=1, keepdims=True) * (angles / reach)[:, None]
    terms = np.concatenate([np.ones((len(directions), 1)), place], 1)
    matrix = (nearness[:, None, None] * terms[:, :, None] * terms[:, None, :]).sum(0)
    matrix += np.diag([0, 1, 1]) * 1e-3 * np.trace(matrix) / 3
    weights = nearness * (terms @ np.linalg.solve(matrix, [1, 0, 0]))
    share = np.clip(4 * (1 - wanted[2] / directions[:, 2].min()), 0, 1)
    weights = np.where(weights < 0, weights * share, weights)
    return weights / weights.sum() * np.minimum(wanted[2] / directions[:, 2], 2)


if __name__ == "__main__":
    unittest.main()
