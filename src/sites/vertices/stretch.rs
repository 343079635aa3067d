//! How much a vertex's samples stretch the texture: distances between adjacent samples on the surface
//! against those on the flat template. The same measure for any template, so that round stencils (Chen 2008)
//! and square patches (Tong 2002) can be compared.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::sites::level::SampleLocation;
use crate::sites::vertices::stencil::PatchStencils;

/// Positions of a square template this far apart, in texels, are adjacent.
const ADJACENT: f32 = 1.01;

/// The adjacent samples of a template. On a round one: consecutive samples of a ring, and each sample with
/// the nearest of the ring inside. On any other: samples at most one texel apart.
pub fn adjacent_samples(template: &Template) -> Vec<[usize; 2]> {
    let positions = &template.positions;
    if template.ring_ends.is_empty() {
        let near = |a: usize, b: usize| positions[a].distance(positions[b]) <= ADJACENT;
        return (0..positions.len())
            .flat_map(|a| (a + 1..positions.len()).map(move |b| [a, b]))
            .filter(|&[a, b]| near(a, b))
            .collect();
    }
    let mut pairs = Vec::new();
    let mut inside = 0..template.ring_ends[0];
    for &end in &template.ring_ends[1..] {
        let ring = inside.end..end;
        for sample in ring.clone() {
            let next = if sample + 1 == end {
                ring.start
            } else {
                sample + 1
            };
            pairs.push([sample, next]);
            let distance = |other: &usize| positions[*other].distance(positions[sample]);
            let nearest = inside
                .clone()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            pairs.extend(nearest.map(|other| [other, sample]));
        }
        inside = ring;
    }
    pairs
}

/// Whether two samples of a round template lie on one ring.
pub fn on_one_ring(template: &Template, [a, b]: [usize; 2]) -> bool {
    let ring = |sample: usize| template.ring_ends.partition_point(|&end| end <= sample);
    !template.ring_ends.is_empty() && ring(a) == ring(b)
}

/// Per vertex √(mean of ln²(surface distance / template distance)) over the pairs of samples that both have a
/// place on the surface (all [`adjacent_samples`], or some): 0 where the texture is laid without stretch, 0.1 where it
/// is stretched or shrunk by about a tenth. NaN for a vertex with no such pair.
///
/// The surface distance is that of the straight line: at a texel's distance and a curvature of κ per texel it
/// is shorter than the way along the surface by κ²/24. `texels` are mesh units per texel at each vertex.
pub fn stretch(
    mesh: &TriangleMesh,
    stencils: &PatchStencils,
    template: &Template,
    pairs: &[[usize; 2]],
    texels: &[f32],
) -> Vec<f32> {
    stretch_of_places(template, pairs, texels, |vertex, places| {
        places.extend(stencils.of_site(vertex).map(|sample| place(mesh, sample)));
    })
}

/// Like [`stretch`] for any sites: `places` appends where the samples of one lie in space, in the template's
/// order.
pub fn stretch_of_places(
    template: &Template,
    pairs: &[[usize; 2]],
    texels: &[f32],
    places: impl Fn(usize, &mut Vec<Option<Vec3>>) + Sync,
) -> Vec<f32> {
    let pairs: Vec<([usize; 2], f32)> = pairs
        .iter()
        .map(|&[a, b]| {
            let flat = template.positions[a].distance(template.positions[b]);
            ([a, b], flat)
        })
        .collect();
    (0..texels.len())
        .into_par_iter()
        .map_init(Vec::new, |found, site| {
            found.clear();
            places(site, found);
            of_places(found, &pairs, texels[site])
        })
        .collect()
}

fn of_places(places: &[Option<Vec3>], pairs: &[([usize; 2], f32)], texel: f32) -> f32 {
    let (mut sum, mut count) = (0.0, 0);
    for &([a, b], flat) in pairs {
        let (Some(from), Some(to)) = (places[a], places[b]) else {
            continue;
        };
        // Samples that fall together are as far from each other as a thousandth of their distance.
        let ratio = (from.distance(to) / (flat * texel)).max(1e-3);
        sum += f64::from(ratio.ln().powi(2));
        count += 1;
    }
    (sum / f64::from(count)).sqrt() as f32
}

/// Where a sample lies in space; `None` outside the patch.
fn place(mesh: &TriangleMesh, sample: SampleLocation<3>) -> Option<Vec3> {
    let position = |site: u32| mesh.positions[site as usize];
    match sample {
        SampleLocation::Outside => None,
        SampleLocation::AtSite(site) => Some(position(site)),
        SampleLocation::Between(sites, weights) => {
            Some((0..3).map(|k| position(sites[k]) * weights[k]).sum())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::connection::frames_of;
    use crate::mesh::rings::Rings;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::progress::Progress;
    use crate::sites::vertices::circles::{Manifold, marching::march, sampling};

    /// Stretch of three rings of circles a texel apart, as if a texel were `told` mesh units.
    fn round_stretch(mesh: &TriangleMesh, texel: f32, told: f32) -> Vec<f32> {
        let topology = Topology::new(&mesh.triangles);
        let rings = Rings::new(mesh, &topology);
        let surface = Manifold {
            mesh,
            topology: &topology,
            rings: &rings,
        };
        let count = mesh.positions.len();
        let circles = march(surface, &vec![texel; count], 3, Progress::silent()).unwrap();
        let template = Template::round(3);
        let frames = frames_of(&rings, &vec![0.3; count]);
        let (stencils, _) = sampling::stencils(&circles, surface, &frames, &template).unwrap();
        stretch(
            mesh,
            &stencils,
            &template,
            &adjacent_samples(&template),
            &vec![told; count],
        )
    }

    #[test]
    fn a_plane_is_not_stretched_and_a_wrong_texel_by_its_factor() {
        let mut flat = shapes::grid(12, 12, 0.5);
        flat.positions.push(Vec3::Z);
        let (stray, right) = (169, round_stretch(&flat, 0.5, 0.5));
        assert!(right[stray].is_nan());
        assert!(right[..stray].iter().all(|s| *s < 2e-3));
        let twice = round_stretch(&flat, 0.5, 1.0);
        let factor = std::f32::consts::LN_2;
        assert!(twice[..stray].iter().all(|s| (s - factor).abs() < 2e-3));
    }

    #[test]
    fn on_a_sphere_stretch_grows_with_the_radius() {
        let ball = shapes::icosphere(3);
        let mean = |texel| {
            let all = round_stretch(&ball, texel, texel);
            all.iter().sum::<f32>() / all.len() as f32
        };
        let (small, large) = (mean(0.05), mean(0.2));
        assert!(small < 0.02 && large > 4.0 * small, "{small} {large}");
    }

    #[test]
    fn adjacent_samples_of_square_and_round_templates() {
        // 3×3: twelve edges of the grid.
        assert_eq!(adjacent_samples(&Template::square(3)).len(), 12);
        let round = adjacent_samples(&Template::round(2));
        // Per sample of a ring one to the next and one to the ring inside.
        assert_eq!(round.len(), 2 * (4 + 12));
        assert!(round.contains(&[0, 1]) && round.contains(&[4, 1]));
        let on_rings = round
            .iter()
            .filter(|&&pair| on_one_ring(&Template::round(2), pair));
        assert_eq!(on_rings.count(), 16);
    }
}
