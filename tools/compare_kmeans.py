#!/usr/bin/env python3
"""K-means of mesotex, FAISS and scikit-learn on the same appearance vectors, in one run.

Needs: pip install numpy scipy faiss-cpu scikit-learn, and a release build of mesotex.
Run:   tools/compare_kmeans.py weave.sample --images 400 --textons 400 --seeds 5

Chooses representative images with mesotex, writes them as a sample of their own, so that all
three see the same vectors [texels, images * 3 * 48] whatever the seed, and prints per method the
median time from vectors to labels, the median inertia (measured here in f64 from the labels, with
the means of the members as centres) and the peak memory. For mesotex the time is that of its own
report's stages from image dot products to labels: the matrix K included, no vector ever made.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sample")
    parser.add_argument("--mesotex", default="target/release/mesotex")
    parser.add_argument("--images", type=int, default=400)
    parser.add_argument("--textons", type=int, default=400)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--skip", nargs="*", default=[], choices=["faiss", "sklearn"])
    return parser.parse_args()


def mesotex(arguments, *words):
    subprocess.run([arguments.mesotex, *map(str, words), "--quiet"], check=True)


def chosen_images(arguments, folder):
    """Writes the representative images as a sample of their own; returns its path."""
    path = os.path.join(folder, "choice.npz")
    mesotex(arguments, "textons", arguments.sample, "-o", path, "--images", arguments.images,
            "--textons", 1, "--levels", 1)
    numbers = np.load(path)["representatives"]
    with open(os.path.join(arguments.sample, "btf.json")) as file:
        description = json.load(file)
    radiance = np.load(os.path.join(arguments.sample, "radiance.npy"), mmap_mode="r")
    height, width = description["height"], description["width"]
    images = radiance.reshape(-1, height, width, 3)[numbers]
    if description["layout"] == "pairs":
        pairs = [description["pairs"][i] for i in numbers]
    else:
        lights = len(description["lights"])
        pairs = [[int(i) // lights, int(i) % lights] for i in numbers]
    description.update(layout="pairs", pairs=pairs)
    target = os.path.join(folder, "chosen.sample")
    os.mkdir(target)
    np.save(os.path.join(target, "radiance.npy"), images)
    with open(os.path.join(target, "btf.json"), "w") as file:
        json.dump(description, file)
    filters = np.load(path)["filters"].astype(np.float64)
    return target, images.astype(np.float64), filters, description["tileable"]


def appearance_vectors(images, filters, tileable):
    """Responses of every texel, [texels, images * 3 * 48], by FFT in f64, kept as f32."""
    count, height, width, _ = images.shape
    def extended(plane):
        if tileable:
            return plane
        rows = np.concatenate([plane, plane[::-1]])
        return np.concatenate([rows, rows[:, ::-1]], axis=1)
    shape = extended(images[0, :, :, 0]).shape
    spectra = []
    for taps in filters:
        kernel = np.zeros(shape)
        for (u, v), tap in np.ndenumerate(taps):
            kernel[(u - 24) % shape[0], (v - 24) % shape[1]] += tap
        spectra.append(np.fft.rfft2(kernel))
    spectra = np.array(spectra)
    vectors = np.empty((height * width, count * 3 * 48), np.float32)
    for image in range(count):
        for channel in range(3):
            spectrum = np.fft.rfft2(extended(images[image, :, :, channel]))
            responses = np.fft.irfft2(spectra * spectrum, shape)[:, :height, :width]
            first = (image * 3 + channel) * 48
            vectors[:, first:first + 48] = responses.reshape(48, -1).T
    return vectors


def inertia(vectors, labels):
    """Sum of squared distances to the members' means, in f64."""
    total = 0.0
    for label in np.unique(labels):
        members = vectors[labels == label].astype(np.float64)
        total += ((members - members.mean(0)) ** 2).sum()
    return total


def run_mesotex(arguments, sample, folder, seed):
    output, report = os.path.join(folder, "o.npz"), os.path.join(folder, "r.json")
    mesotex(arguments, "textons", sample, "-o", output, "--images", "all", "--levels", 1,
            "--textons", arguments.textons, "--seed", seed, "--threads", arguments.threads,
            "--report", report)
    with open(report) as file:
        figures = json.load(file)
    counted = ("image dot products", "texel dot products of level 0", "textons of level 0")
    seconds = sum(s["seconds"] for s in figures["stages"] if s["name"] in counted)
    labels = np.load(output)["L0/labels"].ravel()
    return seconds, labels, figures["peak_bytes"]


def run_faiss(arguments, vectors, seed):
    import faiss
    faiss.omp_set_num_threads(arguments.threads)
    start = time.perf_counter()
    kmeans = faiss.Kmeans(vectors.shape[1], arguments.textons, niter=25, seed=seed + 1,
                          min_points_per_centroid=1, max_points_per_centroid=len(vectors))
    kmeans.train(vectors)
    labels = kmeans.index.search(vectors, 1)[1].ravel()
    return time.perf_counter() - start, labels, peak()


def run_sklearn(arguments, vectors, seed):
    from sklearn.cluster import KMeans
    start = time.perf_counter()
    found = KMeans(arguments.textons, init="k-means++", n_init=1, random_state=seed).fit(vectors)
    return time.perf_counter() - start, found.labels_, peak()


def peak():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main():
    arguments = parse()
    with tempfile.TemporaryDirectory() as folder:
        sample, images, filters, tileable = chosen_images(arguments, folder)
        vectors = appearance_vectors(images, filters, tileable)
        print(f"{vectors.shape[0]} vectors of {vectors.shape[1]} numbers, {arguments.textons} clusters, "
              f"{arguments.seeds} seeds, {arguments.threads} threads")
        methods = {"mesotex": lambda seed: run_mesotex(arguments, sample, folder, seed)}
        if "faiss" not in arguments.skip:
            methods["FAISS, 25 steps"] = lambda seed: run_faiss(arguments, vectors, seed)
        if "sklearn" not in arguments.skip:
            methods["scikit-learn"] = lambda seed: run_sklearn(arguments, vectors, seed)
        print(f"{'method':18} {'median s':>9} {'median inertia':>15} {'best':>12} {'worst':>12} {'peak MiB':>9}")
        for name, run in methods.items():
            rows = []
            for seed in range(arguments.seeds):
                seconds, labels, memory = run(seed)
                rows.append((seconds, inertia(vectors, labels), memory))
            times, inertias, memory = zip(*rows)
            print(f"{name:18} {np.median(times):9.3f} {np.median(inertias):15.6g} {min(inertias):12.6g} "
                  f"{max(inertias):12.6g} {max(memory) / 2**20:9.0f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
