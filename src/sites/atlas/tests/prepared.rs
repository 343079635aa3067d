//! Whole preparations: the same at any number of threads, and what is refused.

use super::*;
use crate::sites::level::{Parent, Sites};
use crate::sites::scan_order::{one_pass_order, scan_order};

fn at_threads(threads: usize, sampling: Sampling) -> (AtlasSurface, SiteHierarchy<AtlasSites>) {
    let options = AtlasOptions {
        levels: 3,
        resolution: 64,
        sampling,
        seed: 3,
        ..AtlasOptions::default()
    };
    let (user, options) = unwrapped(shapes::torus(24, 12, 1.0, 0.4), options);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(|| prepared(&user, &options))
}

#[test]
fn an_atlas_is_the_same_at_any_number_of_threads() {
    for sampling in BOTH {
        let (one, four) = (at_threads(1, sampling), at_threads(4, sampling));
        assert!(one == four);
        let (surface, sites) = one;
        let areas: f32 = sites.levels[0].areas.iter().sum();
        assert!((f64::from(areas) / surface.mesh.area() - 1.0).abs() < 0.05);
        for pair in sites.levels.windows(2) {
            let count = pair[1].count();
            assert!(
                pair[0]
                    .parents
                    .iter()
                    .all(|parent| (parent.site as usize) < count)
            );
            // Where a chart is narrower than a coarse texel, the nearest one lies farther away.
            let is_far = |parent: &&Parent| parent.x.abs().max(parent.y.abs()) > 1.0;
            let far = pair[0].parents.iter().filter(is_far);
            assert!(far.count() * 100 < pair[0].count());
        }
        for level in &sites.levels {
            let neighbors = (0..level.count()).map(|site| level.neighbors(site).count());
            assert!(neighbors.sum::<usize>() > 30 * level.count());
        }
        assert!(surface.counts.iter().all(|counts| counts.outside == 0));
        let finest = surface.counts[0];
        assert!(finest.marched < finest.valued / 10, "{finest:?}");
    }
}

#[test]
fn what_cannot_be_prepared_is_refused_by_name() {
    let refused = |user: &UserMesh, options: AtlasOptions| {
        let error = prepare(user, &options, Progress::silent()).unwrap_err();
        error.to_string()
    };
    let base = || AtlasOptions {
        resolution: 16,
        ..AtlasOptions::default()
    };
    let bare = UserMesh::from(shapes::icosphere(1));
    let text = refused(&bare, base());
    assert!(
        text.contains("no texture coordinates") && text.contains("--unwrap"),
        "{text}"
    );
    for resolution in [0, 1 << 20] {
        let text = refused(
            &flat(2),
            AtlasOptions {
                resolution,
                ..base()
            },
        );
        assert!(text.contains("--resolution"), "{text}");
    }
    for texture_scale in [0.0, -1.0, f64::NAN, 1e9] {
        let text = refused(
            &flat(2),
            AtlasOptions {
                texture_scale,
                ..base()
            },
        );
        assert!(text.contains("--texture-scale"), "{text}");
    }
    let text = refused(
        &flat(2),
        AtlasOptions {
            texture_scale: 0.1,
            ..base()
        },
    );
    assert!(
        text.contains("--texture-scale") && text.contains("256 of 256"),
        "{text}"
    );
    let text = refused(
        &flat(2),
        AtlasOptions {
            levels: 13,
            ..base()
        },
    );
    assert!(text.contains("--levels"), "{text}");
    let text = refused(
        &flat(2),
        AtlasOptions {
            neighborhood: 4,
            ..base()
        },
    );
    assert!(text.contains("--neighborhood"), "{text}");
}

#[test]
fn every_chart_has_a_site_at_every_level() {
    let options = AtlasOptions {
        levels: 4,
        resolution: 64,
        ..AtlasOptions::default()
    };
    let (user, options) = unwrapped(shapes::icosphere(3), options);
    let (surface, sites) = prepared(&user, &options);
    let mut charts = surface.charts.clone();
    charts.sort_unstable();
    charts.dedup();
    assert_eq!(charts.len(), surface.atlas.charts);
    let image = surface.image(&surface.charts, u32::MAX);
    for (texel, &chart) in image.iter().enumerate() {
        let expected = surface.points.chart(&surface.atlas, texel);
        assert_eq!(expected.unwrap_or(u32::MAX), chart);
    }
    assert!(
        sites
            .levels
            .iter()
            .all(|level| level.count() >= charts.len())
    );
}

#[test]
fn one_pass_crosses_charts_while_scan_lines_fill_them_one_by_one() {
    let options = AtlasOptions {
        levels: 1,
        resolution: 64,
        ..AtlasOptions::default()
    };
    let (user, options) = unwrapped(shapes::icosphere(3), options);
    let (_, sites) = prepared(&user, &options);
    let level = &sites.levels[0];
    let silent = Progress::silent();
    // Charts that have both finished and open sites, the most at any time.
    let open_at_once = |order: Vec<u32>| {
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..level.count() as u32));
        let charts: Vec<u32> = order
            .iter()
            .map(|&site| level.charts[site as usize])
            .collect();
        let ends = |chart: u32| {
            let is_it = |&at: &u32| at == chart;
            let first = charts.iter().position(is_it).unwrap();
            first..=charts.iter().rposition(is_it).unwrap()
        };
        let spans: Vec<_> = (0..=*charts.iter().max().unwrap()).map(ends).collect();
        let open = |at: usize| spans.iter().filter(|span| span.contains(&at)).count();
        (0..charts.len()).map(open).max().unwrap()
    };
    assert_eq!(open_at_once(scan_order(level, 0, silent).unwrap()), 1);
    assert!(open_at_once(one_pass_order(level, 0, silent).unwrap()) > 2);
}
