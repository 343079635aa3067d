//! The unit square is the flat grid.

use super::*;
use crate::neighborhood::Neighborhood;
use crate::sites::grid::window::SiteGrid;
use crate::sites::level::Sites;

const GRID: SiteGrid = SiteGrid {
    width: 32,
    height: 32,
    toroidal: false,
};

fn options(sampling: Sampling) -> AtlasOptions {
    AtlasOptions {
        levels: 3,
        neighborhood: 5,
        coarse_neighborhood: 3,
        resolution: 32,
        sampling,
        ..AtlasOptions::default()
    }
}

fn as_grid(sample: SampleLocation<1>) -> SampleLocation<4> {
    match sample {
        SampleLocation::AtSite(site) => SampleLocation::AtSite(site),
        _ => SampleLocation::Outside,
    }
}

#[test]
fn samples_neighbours_and_parents_are_those_of_the_grid() {
    let neighborhoods = [(5, 3), (5, 3), (5, 0)].map(|(a, b)| Neighborhood::square(a, b));
    let expected = GRID.hierarchy(&neighborhoods).unwrap();
    for (side, sampling) in [(5, BOTH[0]), (5, BOTH[1]), (2, BOTH[0]), (48, BOTH[0])] {
        let (_, found) = prepared(&flat(side), &options(sampling));
        assert_eq!(found.levels.len(), 3);
        for (level, (found, expected)) in found.levels.iter().zip(&expected.levels).enumerate() {
            let place = format!("{side} {sampling:?} level {level}");
            assert_eq!(found.count(), expected.count(), "{place}");
            assert_eq!(
                found.parent_samples_per_site(),
                expected.parent_samples_per_site()
            );
            for site in 0..found.count() {
                let samples = expected.samples(site).map(as_grid);
                assert!(found.samples(site).eq(samples), "{place} site {site}");
                let samples = expected.parent_samples(site).map(as_grid);
                assert!(
                    found.parent_samples(site).eq(samples),
                    "{place} site {site}"
                );
                let (near, others): (Vec<_>, Vec<_>) = (
                    found.neighbors(site).collect(),
                    expected.neighbors(site).collect(),
                );
                assert_eq!(near.len(), others.len(), "{place} site {site}");
                for (near, other) in near.iter().zip(&others) {
                    let apart = (near.x - other.x).abs().max((near.y - other.y).abs());
                    assert!(
                        near.site == other.site && apart < 1e-3,
                        "{place} site {site}"
                    );
                }
            }
            for (found, expected) in found.parents.iter().zip(&expected.parents) {
                let apart = (found.x - expected.x)
                    .abs()
                    .max((found.y - expected.y).abs());
                assert!(found.site == expected.site && apart < 1e-3, "{place}");
            }
            assert_eq!(found.parents.len(), expected.parents.len());
        }
    }
}

#[test]
fn edges_are_those_of_the_grid_and_the_mesh_is_its_mesh() {
    let (surface, _) = prepared(&flat(5), &options(Sampling::Charts));
    let mut expected = GRID.edges();
    expected.sort_by_key(|edge| [edge.from, edge.to]);
    assert_eq!(surface.edges.len(), expected.len());
    for (edge, expected) in surface.edges.iter().zip(&expected) {
        assert_eq!([edge.from, edge.to], [expected.from, expected.to]);
        let apart = [0, 1].map(|k| (edge.offset[k] - expected.offset[k]).abs());
        assert!(apart.iter().all(|&apart| apart < 1e-4));
    }
    assert_eq!(surface.triangles.len(), GRID.mesh().triangles.len());
    let mesh = TriangleMesh {
        positions: surface.positions.clone(),
        triangles: surface.triangles.clone(),
    };
    assert!((0..mesh.triangles.len()).all(|t| mesh.area_normal(t).z > 0.0));
    assert_eq!((surface.texel, surface.scale), (1.0 / 32.0, None));
}

#[test]
fn scale_and_rotation_are_honoured() {
    let mut user = flat(8);
    let count = user.mesh.positions.len();
    user.scale = Some(vec![2.0; count]);
    user.scale.as_mut().unwrap()[0] = 1.5;
    user.rotation = Some(vec![90.0; count]);
    for sampling in BOTH {
        let options = AtlasOptions {
            texture_scale: 1.5,
            ..options(sampling)
        };
        let (surface, sites) = prepared(&user, &options);
        let centre = 16 * 32 + 16;
        assert!((surface.orientations[centre] - Vec3::Y).length() < 1e-5);
        assert!((surface.scale.as_ref().unwrap()[centre] - 2.0).abs() < 1e-5);
        // One texel along s: up, 1.5 · 2 texels of the atlas.
        let sample = sites.levels[0].samples(centre).nth(13).unwrap();
        assert_eq!(sample, SampleLocation::AtSite(13 * 32 + 16));
        // One texel along t: to the left.
        let sample = sites.levels[0].samples(centre).nth(7).unwrap();
        assert_eq!(sample, SampleLocation::AtSite(16 * 32 + 13));
    }
}

#[test]
fn a_chart_seen_in_a_mirror_is_sampled_the_right_way_round() {
    let mut user = flat(6);
    for uv in user.corner_uvs.iter_mut().flatten().flatten() {
        uv.x = 1.0 - uv.x;
    }
    for sampling in BOTH {
        let (surface, sites) = prepared(&user, &options(sampling));
        for site in [0, 7 * 32 + 9, 20 * 32 + 30] {
            let samples = sites.levels[0].samples(site).enumerate();
            for (number, sample) in samples {
                let (right, up) = ((number % 5) as f32 - 2.0, 2.0 - (number / 5) as f32);
                let wanted = surface.positions[site] + Vec3::new(right, up, 0.0) / 32.0;
                let is_inside = wanted.min_element() >= 0.0 && wanted.max_element() <= 1.0;
                let found = place(&surface, sample);
                assert_eq!(found.is_some(), is_inside, "{site} {number}");
                assert!(found.is_none_or(|found| found.distance(wanted) < 1e-5));
            }
        }
        for &[a, b, c] in &surface.triangles {
            let [a, b, c] = [a, b, c].map(|site| surface.positions[site as usize]);
            assert!((b - a).cross(c - a).z > 0.0);
        }
    }
}
