"""The reader against the program: `python -m unittest discover python/tests` with MESOTEX set to the program."""

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import mesotex  # noqa: E402


class Chain(unittest.TestCase):
    """Every product of one small chain."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.at = Path(cls.folder.name)
        small = ("--size", 32, "--views", "fibonacci:6", "--lights", "fibonacci:5", "--samples", 1)
        cls.run_in("bake", "--preset", "weave", *small, "-o", cls.at / "a.sample")
        cls.run_in("textons", cls.at / "a.sample", "-o", cls.at / "a.textons.npz", "--textons", 20, "--levels", 2)
        cls.run_in("gram", cls.at / "a.textons.npz", "-o", cls.at / "a.space.npz")
        cls.run_in("knn", cls.at / "a.space.npz", "-o", cls.at / "a.knn.npz", "--k", 4)
        grid = ("--grid", "24x20", "--levels", 2)
        cls.run_in("synth", cls.at / "a.space.npz", cls.at / "a.knn.npz", *grid, "-o", cls.at / "a.map.ply")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @staticmethod
    def run_in(command, *words):
        return mesotex.run(command, *words, threads=1)

    def test_sample(self):
        sample = mesotex.read_sample(self.at / "a.sample")
        self.assertEqual((sample.width, sample.height, sample.image_count), (32, 32, 30))
        self.assertEqual(sample.radiance.shape, (6, 5, 32, 32, 3))
        np.testing.assert_allclose(np.linalg.norm(sample.views, axis=1), 1, atol=1e-6)
        image = sample.image(2, 3)
        np.testing.assert_array_equal(image, sample.radiance[2, 3].astype(np.float32))
        self.assertTrue((image >= 0).all())
        theta = sample.angles()[0][:, 0]
        np.testing.assert_allclose(np.cos(np.radians(theta)), 1 - (np.arange(6) + 0.5) / 6, atol=1e-6)
        with self.assertRaises(KeyError):
            sample.image(6, 0)

    def test_factored_sample(self):
        self.run_in("factor", self.at / "a.sample", "--rank", 30, "-o", self.at / "f.sample")
        exact, factored = (mesotex.read_sample(self.at / name) for name in ("a.sample", "f.sample"))
        self.assertIsNone(factored.radiance)
        np.testing.assert_allclose(factored.image(1, 4), exact.image(1, 4), atol=2e-3)

    def test_textons(self):
        vocabulary = mesotex.read_vocabulary(self.at / "a.textons.npz")
        space = mesotex.read_space(self.at / "a.space.npz")
        table = mesotex.read_table(self.at / "a.knn.npz")
        self.assertEqual([level.labels.shape for level in space.levels], [(32, 32), (16, 16)])
        for level, found in zip(vocabulary.levels, space.levels):
            np.testing.assert_array_equal(np.bincount(level.labels.ravel()), level.counts)
            np.testing.assert_array_equal(level.labels, found.labels)
            products = level.centroids @ level.centroids.T
            scale = np.abs(products).max()
            np.testing.assert_allclose(found.gram[:-1, :-1], products, atol=1e-5 * scale)
        self.assertEqual(table.levels[0].neighbors.shape, (1024, 4))
        np.testing.assert_array_equal(table.levels[0].neighbors[:, 0], np.arange(1024))

    def test_map(self):
        surface = mesotex.read_map(self.at / "a.map.ply")
        sample = mesotex.read_sample(self.at / "a.sample")
        space = mesotex.read_space(self.at / "a.space.npz")
        self.assertEqual(surface.header.sample, sample.id)
        self.assertEqual(surface.header.exemplar, (32, 32))
        self.assertEqual(surface.positions.shape, (24 * 20, 3))
        rows, columns = surface.texels()
        np.testing.assert_array_equal(space.levels[0].labels[rows, columns], surface.texton)
        uv = surface.uv()
        self.assertTrue(((uv >= 0) & (uv <= 1)).all())
        self.assertLess(surface.faces.max(), len(surface.positions))

    def test_errors(self):
        with self.assertRaises(mesotex.CommandError) as caught:
            self.run_in("bake", "--preset", "weav", "-o", self.at / "b.sample")
        self.assertEqual(caught.exception.exit_code, 2)
        self.assertIn("did you mean `weave`", str(caught.exception))
        with self.assertRaises(mesotex.DataError) as caught:
            mesotex.read_sample(self.at / "a.map.ply")
        self.assertIn("a.map.ply", str(caught.exception))
        with self.assertRaises(mesotex.DataError):
            mesotex.read_space(self.at / "a.knn.npz")


if __name__ == "__main__":
    unittest.main()
