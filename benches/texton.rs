//! Texton analysis, stage by stage: 64×64 texels, 400 RGB images, 400 textons.

use mesotex::grid::TexelGrid;
use mesotex::matrix::as_rows;
use mesotex::progress::Progress;
use mesotex::random::stream;
use mesotex::texton::{
    FftFilters, FilterEigenbasis, PointFilters, ScatterMatrix, TexelSums, cluster, gram_matrix,
    leung_malik, sum_responses, texel_gram,
};
use ndarray::Array2;
use rand::Rng;

const SIDE: u32 = 64;
const TEXELS: usize = (SIDE * SIDE) as usize;
const PLANES: usize = 1200;
const TEXTONS: usize = 400;

fn main() {
    divan::main();
}

fn grid(tileable: bool) -> TexelGrid {
    TexelGrid {
        width: SIDE,
        height: SIDE,
        tileable,
    }
}

fn planes() -> Vec<f32> {
    let mut random = stream(1, "planes", 0, 0);
    (0..PLANES * TEXELS)
        .map(|_| random.gen_range(-1.0..1.0))
        .collect()
}

fn covariance(planes: &[f32]) -> Array2<f32> {
    let mut sum = ScatterMatrix::new(TEXELS);
    sum.add(as_rows(planes, PLANES, TEXELS), Progress::silent());
    sum.finish(Progress::silent()).unwrap()
}

#[divan::bench(sample_count = 5)]
fn image_coefficients(bencher: divan::Bencher<'_, '_>) {
    let (basis, planes) = (FilterEigenbasis::new(grid(true)), planes());
    bencher.bench(|| basis.coefficients(&planes));
}

#[divan::bench(sample_count = 5)]
fn image_dot_products(bencher: divan::Bencher<'_, '_>) {
    let planes = planes();
    bencher.bench(|| covariance(&planes));
}

#[divan::bench(args = [true, false], sample_count = 5)]
fn texel_dot_products(bencher: divan::Bencher<'_, '_>, tileable: bool) {
    let basis = FilterEigenbasis::new(grid(tileable));
    let transfer = basis.transfer(&leung_malik());
    let covariance = covariance(&planes());
    bencher
        .with_inputs(|| covariance.clone())
        .bench_values(|sum| texel_gram(sum, &basis, &transfer, Progress::silent()).is_ok());
}

#[divan::bench(sample_count = 5)]
fn k_means(bencher: divan::Bencher<'_, '_>) {
    let gram = covariance(&planes());
    bencher.bench(|| {
        let mut random = stream(1, "bench", 0, 0);
        cluster(gram.view(), TEXTONS, 1000, &mut random, Progress::silent()).is_ok()
    });
}

#[divan::bench(args = [true, false], sample_count = 5)]
fn image_appearance(bencher: divan::Bencher<'_, '_>, tileable: bool) {
    let (point_filters, planes) = (
        PointFilters::new(grid(tileable), &leung_malik(), 8),
        planes(),
    );
    bencher.bench(|| point_filters.responses(&planes));
}

#[divan::bench(args = [true, false], sample_count = 5)]
fn texton_centres(bencher: divan::Bencher<'_, '_>, tileable: bool) {
    let (filters, planes) = (FftFilters::new(grid(tileable), &leung_malik()), planes());
    let labels: Vec<u32> = (0..TEXELS).map(|i| (i % TEXTONS) as u32).collect();
    let mut counts = vec![0; TEXTONS];
    labels.iter().for_each(|&label| counts[label as usize] += 1);
    let averages = TexelSums::averages(&labels, &counts, |texel| filters.place(texel));
    bencher.bench(|| {
        let mut centroids = Array2::zeros((TEXTONS, PLANES * 48));
        sum_responses(&filters, &averages, &planes, vec![centroids.view_mut()]);
        centroids
    });
}

#[divan::bench(sample_count = 5)]
fn texton_dot_products(bencher: divan::Bencher<'_, '_>) {
    let vectors = Array2::from_elem((TEXTONS, PLANES * 48), 0.5_f32);
    bencher.bench(|| gram_matrix(&vectors).unwrap());
}
