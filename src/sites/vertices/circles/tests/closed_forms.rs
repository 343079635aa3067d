//! Circles against closed forms and slow oracles: plane, sphere, cylinder, bumps, boundary, fold; fields and
//! threads.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use rand::Rng;

use super::*;
use crate::random;

#[test]
fn on_a_plane_lengths_are_angles_and_positions_the_template() {
    let ready = flat(12);
    let centre = 6 * 13 + 6;
    for radius in [0.5, 0.37] {
        let circles = ready.march(radius, 4);
        for number in 1..=4 {
            let circle = circles.circle(centre, number);
            assert!(!circle.is_open());
            let perimeter = circles.perimeters[centre * 4 + number as usize - 1];
            let expected = TAU * radius * number as f32;
            assert!((perimeter / expected - 1.0).abs() < 1e-6, "{perimeter}");
            for arc in circle.arcs {
                assert!(arc.turn.abs_diff(arc.fraction) <= 1, "{arc:?}");
            }
        }
        let frames = ready.frames(Vec3::X, 0.3);
        let stencils = ready.stencils(&circles, &frames);
        let template = Template::round(4);
        let turn = Vec2::from_angle(0.3);
        for (sample, offset) in stencils.of_site(centre).zip(&template.positions) {
            let expected = turn.rotate(*offset) * radius;
            let at = ready.position(sample).unwrap() - ready.mesh.positions[centre];
            assert!(
                (at.truncate() - expected).length() < 1e-3,
                "{at} {expected}"
            );
        }
    }
}

#[test]
fn neighbours_on_a_plane_lie_where_they_are() {
    let ready = flat(12);
    let circles = ready.march(0.5, 3);
    let frames = ready.frames(Vec3::Y, 0.0);
    let near = sampling::neighbors(&circles, ready.surface(), &frames).unwrap();
    let centre = 6 * 13 + 6;
    // Lattice points other than the centre with x² + y² ≤ 9.
    assert_eq!(near.row(centre).len(), 28);
    let mut last = 0.0;
    for neighbor in near.row(centre).iter().copied() {
        let real =
            (ready.mesh.positions[neighbor.site as usize] - ready.mesh.positions[centre]) / 0.5;
        // s is +y, so t is −x.
        let expected = Vec2::new(real.y, -real.x);
        let told = Vec2::new(neighbor.x, neighbor.y);
        assert!((told - expected).length() < 2e-3, "{told} {expected}");
        assert!(expected.length() >= last - 1e-5);
        last = expected.length();
    }
}

#[test]
fn a_sphere_is_cut_at_the_height_of_the_cylinder() {
    let ready = Ready::new(shapes::icosphere(4));
    let (radius, count) = (0.1, 4);
    let circles = ready.march(radius, count);
    let frames = ready.frames(Vec3::Z, 0.0);
    let stencils = ready.stencils(&circles, &frames);
    let template = Template::round(count);
    for vertex in [0, 17, 1000, 2500] {
        for number in 1..=count {
            let rho = radius * number as f32;
            assert!(!circles.circle(vertex, number).is_open());
            let perimeter = circles.perimeters[vertex * 4 + number as usize - 1];
            assert!(
                (perimeter / (TAU * rho) - 1.0).abs() < 3e-3,
                "{perimeter} {rho}"
            );
        }
        for (sample, offset) in stencils.of_site(vertex).zip(&template.positions) {
            let at = frames[vertex].frame_from_mesh(ready.position(sample).unwrap());
            let flat = *offset * radius;
            let expected = flat.extend((1.0 - flat.length_squared()).sqrt());
            assert!((at - expected).length() < 4e-3, "{at} {expected}");
        }
    }
}

/// The length of the curve in which a cylinder of radius `rho` about the normal cuts one of radius `big`.
fn saddle_perimeter(big: f64, rho: f64) -> f64 {
    let steps = 20_000;
    let speed = |step: usize| {
        let (sin, cos) = ((step as f64 + 0.5) / f64::from(steps) * std::f64::consts::TAU).sin_cos();
        let height = rho * rho * cos * sin / (big * big - rho * rho * cos * cos).sqrt();
        rho.hypot(height)
    };
    let sum: f64 = (0..steps as usize).map(speed).sum();
    sum * std::f64::consts::TAU / f64::from(steps)
}

#[test]
fn a_cylinder_gives_the_perimeter_of_its_closed_form() {
    let ready = Ready::new(shapes::cylinder(100, 50, 1.0, 0.06));
    let vertex = ready.vertex_at(Vec3::new(1.0, 0.0, 1.5));
    let circles = ready.march(0.25, 3);
    for number in 1..=3 {
        let expected = saddle_perimeter(1.0, 0.25 * f64::from(number));
        let found = f64::from(circles.perimeters[vertex * 3 + number as usize - 1]);
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{number}: {found} {expected}"
        );
    }
    // Equal shares of arc length: half of them lies between the two directions along the axis.
    let stencils = ready.stencils(&circles, &ready.frames(Vec3::Z, 0.0));
    let template = Template::round(3);
    let opposite = template
        .positions
        .iter()
        .position(|p| *p == Vec2::new(-3.0, 0.0));
    let sample = stencils.of_site(vertex).nth(opposite.unwrap()).unwrap();
    let at = ready.position(sample).unwrap() - ready.mesh.positions[vertex];
    assert!((at - Vec3::new(0.0, 0.0, -0.75)).length() < 2e-3, "{at}");
}

#[test]
fn at_a_boundary_the_missing_half_is_a_gap() {
    let ready = flat(12);
    let edge = 6;
    let circles = ready.march(0.5, 2);
    let frames = ready.frames(Vec3::X, 0.0);
    for number in 1..=2 {
        let circle = circles.circle(edge, number);
        assert!(circle.is_open());
        let expected = TAU * 0.5 * number as f32;
        let perimeter = circles.perimeters[edge * 2 + number as usize - 1];
        assert!((perimeter / expected - 1.0).abs() < 1e-6);
    }
    let template = Template::round(2);
    let stencils = ready.stencils(&circles, &frames);
    for (sample, offset) in stencils.of_site(edge).zip(&template.positions) {
        match ready.position(sample) {
            None => assert!(offset.y < 1e-3, "{offset} has a surface"),
            Some(at) => {
                let at = (at - ready.mesh.positions[edge]).truncate();
                assert!((at - *offset * 0.5).length() < 1e-3, "{at} {offset}");
                assert!(offset.y > -1e-3);
            }
        }
    }
    assert!(
        stencils
            .of_site(edge)
            .filter(|s| !s.sites().is_empty())
            .count()
            >= 9
    );
    // A circle larger than the mesh has no surface at all.
    let large = ready.march(20.0, 1);
    let arcs = large.circle(edge, 1).arcs;
    assert_eq!(arcs.len(), 1);
    assert_eq!(arcs[0].triangle, Arc::GAP);
}

/// A bumpy height field over the plane, flat round its middle; and its height at any point of the plane.
fn bumpy() -> (Ready, impl Fn(Vec2) -> f32) {
    let mut mesh = shapes::grid(20, 20, 0.5);
    let mut stream = random::stream(3, "bumps", 0, 0);
    for (vertex, p) in mesh.positions.iter_mut().enumerate() {
        let (column, row) = (vertex % 21, vertex / 21);
        if column.abs_diff(10).max(row.abs_diff(10)) > 1 {
            p.z = stream.gen_range(-0.4..0.4);
        }
    }
    let heights: Vec<f32> = mesh.positions.iter().map(|p| p.z).collect();
    let height = move |at: Vec2| {
        let cell = (at / 0.5).floor().as_uvec2();
        let Vec2 { x, y } = at / 0.5 - cell.as_vec2();
        let corner = |dx, dy| heights[((cell.y + dy) * 21 + cell.x + dx) as usize];
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
        if x >= y {
            a + x * (b - a) + y * (c - b)
        } else {
            a + y * (d - a) + x * (c - d)
        }
    };
    (Ready::new(mesh), height)
}

#[test]
fn percentages_on_bumps_are_those_of_a_fine_polyline() {
    let (ready, height) = bumpy();
    let centre = 10 * 21 + 10;
    assert_eq!(ready.rings.normals[centre], Vec3::Z);
    let (radius, steps) = (0.8, 40_000);
    let circles = ready.march(radius, 5);
    let middle = ready.mesh.positions[centre].truncate();
    let axis = ready.rings.axes[centre].truncate();
    for number in 1..=5 {
        let point = |step: usize| {
            let turn = Vec2::from_angle(step as f32 / steps as f32 * TAU);
            let at = middle + turn.rotate(axis) * radius * number as f32;
            at.extend(height(at))
        };
        let mut lengths = vec![0.0_f64];
        for step in 0..steps {
            let length = f64::from(point(step).distance(point(step + 1)));
            lengths.push(lengths[step] + length);
        }
        let circle = circles.circle(centre, number);
        let perimeter = f64::from(circles.perimeters[centre * 5 + number as usize - 1]);
        assert!(!circle.is_open());
        assert!(
            (perimeter / lengths[steps] - 1.0).abs() < 2e-3,
            "{number}: {perimeter}"
        );
        for step in (0..steps).step_by(97) {
            let expected = (lengths[step] / lengths[steps]) as f32;
            let found = circle.fraction_at(step as f32 / steps as f32);
            assert!(
                (found - expected).abs() < 1e-3,
                "{number}: {found} {expected}"
            );
            let (_, turn) = circle.point_at(expected);
            assert!((turn - step as f32 / steps as f32).abs() < 2e-3);
        }
    }
}

#[test]
fn on_a_rough_closed_surface_samples_lie_on_their_cylinders() {
    let mut mesh = shapes::torus(40, 20, 1.0, 0.4);
    let mut stream = random::stream(9, "rough", 0, 0);
    for p in &mut mesh.positions {
        *p += Vec3::from_array(std::array::from_fn(|_| stream.gen_range(-0.05..0.05)));
    }
    let ready = Ready::new(mesh);
    let radius = 0.11;
    let circles = ready.march(radius, 4);
    let frames = ready.frames(Vec3::Z, 0.7);
    let stencils = ready.stencils(&circles, &frames);
    let template = Template::round(4);
    let mut outside = 0;
    for (vertex, frame) in frames.iter().enumerate() {
        for (sample, offset) in stencils.of_site(vertex).zip(&template.positions) {
            let Some(at) = ready.position(sample) else {
                outside += 1;
                continue;
            };
            let arm = frame.frame_from_mesh(at - ready.mesh.positions[vertex]);
            let expected = offset.length() * radius;
            assert!(
                (arm.truncate().length() - expected).abs() < 2e-3,
                "{vertex} {offset}"
            );
        }
    }
    let all = frames.len() * template.positions.len();
    assert!(outside > 0 && outside < all / 4, "{outside} of {all}");
}

/// A plane with a wave along x that is pushed over until it overhangs.
fn folded() -> Ready {
    let mut mesh = shapes::grid(40, 40, 0.1);
    for p in &mut mesh.positions {
        let wave = (-((p.x - 2.6) / 0.25).powi(2) - ((p.y - 2.0) / 0.6).powi(2)).exp();
        p.z += 0.45 * wave;
        p.x += 0.5 * wave;
    }
    Ready::new(mesh)
}

#[test]
fn a_fold_leaves_every_circle_one_turn_round_the_axis() {
    let ready = folded();
    let vertex = ready.vertex_at(Vec3::new(2.0, 2.0, 0.0));
    let circles = ready.march(0.25, 5);
    let frames = ready.frames(Vec3::X, 0.0);
    let stencils = ready.stencils(&circles, &frames);
    let template = Template::round(5);
    let turned_under = |triangle: u32| ready.mesh.area_normal(triangle as usize).z <= 0.0;
    assert!((0..ready.mesh.triangles.len() as u32).any(turned_under));
    for number in 1..=5 {
        let arcs = circles.circle(vertex, number).arcs;
        let known = |arc: &&Arc| arc.triangle != Arc::GAP;
        assert!(
            arcs.iter()
                .filter(known)
                .all(|arc| !turned_under(arc.triangle))
        );
    }
    // Samples keep their distance from the axis, and away from the fold their place.
    let (mut valued, mut in_place) = (0, 0);
    for (sample, offset) in stencils.of_site(vertex).zip(&template.positions) {
        let Some(at) = ready.position(sample) else {
            continue;
        };
        let at = frames[vertex]
            .frame_from_mesh(at - ready.mesh.positions[vertex])
            .truncate();
        assert!(
            (at.length() - offset.length() * 0.25).abs() < 2e-3,
            "{at} {offset}"
        );
        valued += 1;
        in_place += usize::from((at - *offset * 0.25).length() < 0.1);
    }
    assert!(valued > 80 && in_place > 60, "{valued} {in_place}");
}

#[test]
fn a_turned_field_takes_the_turned_template_from_the_same_circles() {
    let ready = Ready::new(shapes::torus(60, 30, 1.0, 0.4));
    let circles = ready.march(0.06, 3);
    let template = Template::round(3);
    // A quarter turn maps the template on itself: sample k becomes the one a quarter of the ring on.
    let straight = ready.stencils(&circles, &ready.frames(Vec3::Z, 0.0));
    let turned = ready.stencils(&circles, &ready.frames(Vec3::Z, TAU / 4.0));
    for vertex in 0..ready.mesh.positions.len() {
        let first: Vec<_> = straight
            .of_site(vertex)
            .map(|s| ready.position(s))
            .collect();
        let second: Vec<_> = turned.of_site(vertex).map(|s| ready.position(s)).collect();
        for pair in template.ring_ends.windows(2) {
            // P_0 of the turned field is a quarter of the angle on, not of the arc length: on a curved
            // surface the rings agree to their own unevenness.
            let count = pair[1] - pair[0];
            for k in 0..count {
                let on = first[pair[0] + (k + count / 4) % count].unwrap();
                let at = second[pair[0] + k].unwrap();
                assert!(on.distance(at) < 0.02, "{vertex} {k}: {on} {at}");
            }
        }
    }
}

#[test]
fn the_reference_tangent_does_not_matter() {
    let mut ready = Ready::new(shapes::torus(60, 30, 1.0, 0.4));
    let frames = ready.frames(Vec3::Z, 0.4);
    let circles = ready.march(0.06, 3);
    let first = ready.stencils(&circles, &frames);
    let near = sampling::neighbors(&circles, ready.surface(), &frames).unwrap();
    for (axis, normal) in ready.rings.axes.iter_mut().zip(&ready.rings.normals) {
        *axis = (*axis * 0.6 + normal.cross(*axis) * 0.8).normalize();
    }
    let circles = ready.march(0.06, 3);
    let second = ready.stencils(&circles, &frames);
    let again = sampling::neighbors(&circles, ready.surface(), &frames).unwrap();
    for vertex in 0..frames.len() {
        for (a, b) in first.of_site(vertex).zip(second.of_site(vertex)) {
            let (a, b) = (ready.position(a).unwrap(), ready.position(b).unwrap());
            assert!(a.distance(b) < 1e-3, "{vertex}: {a} {b}");
        }
        let sorted = |near: &crate::mesh::compressed_rows::Rows<crate::sites::level::Neighbor>| {
            let mut list = near.row(vertex).to_vec();
            list.sort_by_key(|n| n.site);
            list
        };
        for (a, b) in sorted(&near).iter().zip(sorted(&again)) {
            assert_eq!(a.site, b.site);
            assert!(
                Vec2::new(a.x - b.x, a.y - b.y).length() < 5e-3,
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn one_thread_and_four_give_the_same_circles() {
    let ready = Ready::new(shapes::torus(90, 50, 1.0, 0.4));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| ready.march(0.05, 3))
    };
    assert!(with(1) == with(4));
}
