//! Where samples lie on a cylinder across its seam, and on a sphere across those of an unwrapped atlas.

use super::*;
use crate::neighborhood::Template;
use crate::sites::level::Sites;

/// The mean and the largest of some errors.
fn mean_and_most(errors: &[f32]) -> (f32, f32) {
    let sum: f32 = errors.iter().sum();
    let most = errors.iter().copied().fold(0.0, f32::max);
    (sum / errors.len().max(1) as f32, most)
}

#[test]
fn across_the_seam_of_a_cylinder_samples_lie_where_they_should() {
    let template = Template::square(7);
    for sampling in BOTH {
        let options = AtlasOptions {
            levels: 1,
            resolution: 128,
            sampling,
            ..AtlasOptions::default()
        };
        let (surface, sites) = prepared(&cylinder(), &options);
        let texel = surface.texel as f32;
        let circumference = AROUND as f32 * side_of_cylinder();
        let (mut inside, mut across) = (Vec::new(), Vec::new());
        for site in 0..sites.levels[0].count() {
            let from = unrolled(surface.positions[site]);
            for (offset, sample) in template.positions.iter().zip(sites.levels[0].samples(site)) {
                let wanted = from + *offset * texel;
                if !(0.0..=12.0 * STEP).contains(&wanted.y) {
                    assert_eq!(sample, SampleLocation::Outside);
                    continue;
                }
                let found = unrolled(place(&surface, sample).unwrap());
                let turn = (found.x - wanted.x + 0.5 * circumference).rem_euclid(circumference);
                let apart = Vec2::new(turn - 0.5 * circumference, found.y - wanted.y) / texel;
                // Beyond the outermost texels' centres there is nothing to blend.
                let margin = texel;
                let whole = (margin..12.0 * STEP - margin).contains(&wanted.y);
                let crosses = !(texel..circumference - texel).contains(&wanted.x);
                match (whole, crosses) {
                    (false, _) => {}
                    (true, false) => inside.push(apart.length()),
                    (true, true) => across.push(apart.length()),
                }
            }
        }
        let ((mean, most), (mean_across, most_across)) =
            (mean_and_most(&inside), mean_and_most(&across));
        assert!(across.len() > 500);
        assert!(mean < 0.001 && most < 0.01, "{sampling:?} {mean} {most}");
        assert!(
            mean_across < 0.003 && most_across < 0.05,
            "{sampling:?} {mean_across} {most_across}"
        );
    }
}

#[test]
fn every_texel_beside_the_seam_has_a_neighbour_across() {
    let options = AtlasOptions {
        levels: 1,
        resolution: 128,
        ..AtlasOptions::default()
    };
    let (surface, sites) = prepared(&cylinder(), &options);
    let circumference = AROUND as f32 * side_of_cylinder();
    let rows = surface.texels.iter().map(|texel| texel / 128);
    let rows = rows.clone().max().unwrap() - rows.min().unwrap() + 1;
    let columns = surface.texels.len() as u32 / rows;
    // A closed ring has as many edges as texels. Below the lowest row there are none.
    let (n, m) = (
        surface.edges.len() as u32,
        columns * rows + columns * (rows - 1),
    );
    assert!(n >= m && n <= m + rows, "{n} of {m}");
    for edge in &surface.edges {
        let length = Vec2::from_array(edge.offset).length();
        assert!((0.3..2.0).contains(&length), "{edge:?}");
    }
    let crossing = |site: usize| {
        let own = unrolled(surface.positions[site]).x;
        let mut near = sites.levels[0].neighbors(site);
        near.any(|near| {
            (unrolled(surface.positions[near.site as usize]).x - own).abs() > 0.5 * circumference
        })
    };
    for (site, &texel) in surface.texels.iter().enumerate() {
        let column = texel % 128;
        let first = surface
            .texels
            .iter()
            .map(|texel| texel % 128)
            .min()
            .unwrap();
        let from_seam = (column - first).min(first + columns - 1 - column);
        // The texels on both sides of the seam lie 1.8 texels apart.
        assert_eq!(crossing(site), from_seam < 2, "{site} {from_seam}");
    }
}

#[test]
fn on_an_unwrapped_sphere_samples_lie_on_great_circles() {
    let template = Template::square(7);
    for sampling in BOTH {
        let options = AtlasOptions {
            levels: 1,
            resolution: 128,
            sampling,
            ..AtlasOptions::default()
        };
        let (user, options) = unwrapped(shapes::icosphere(4), options);
        let (surface, sites) = prepared(&user, &options);
        let texel = surface.texel as f32;
        let (mut errors, mut outside, mut all) = (Vec::new(), 0, 0);
        for site in 0..sites.levels[0].count() {
            let n = surface.positions[site].normalize();
            let s = surface.orientations[site];
            let s = (s - n * n.dot(s)).normalize();
            let t = n.cross(s);
            for (offset, sample) in template.positions.iter().zip(sites.levels[0].samples(site)) {
                all += 1;
                let Some(found) = place(&surface, sample) else {
                    outside += 1;
                    continue;
                };
                let way = (s * offset.x + t * offset.y).normalize_or_zero();
                let angle = offset.length() * texel;
                let wanted = n * angle.cos() + way * angle.sin();
                errors.push(found.normalize().distance(wanted) / texel);
            }
        }
        let (mean, most) = mean_and_most(&errors);
        let stretch = surface.stretch(&sites.levels[0]);
        let stretch = stretch.iter().sum::<f32>() / stretch.len() as f32;
        assert!(mean < 0.01 && most < 1.0, "{sampling:?} {mean} {most}");
        assert!(outside * 1000 < all, "{sampling:?} {outside} of {all}");
        assert!(stretch < 0.02, "{sampling:?} {stretch}");
    }
}
