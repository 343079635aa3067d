//! Rays against the height field: exact intersection with bilinear patches, found by stepping
//! through a pyramid of maxima (Tevs 2008, "Maximum mipmaps for fast, accurate, and scalable dynamic
//! height field rendering").
//!
//! Along a ray the height over a patch is g(s) = C + B·s + A·s², so a hit is the root of a
//! quadratic, and a shadow needs no root at all: only whether g falls below 0. A ray that starts on
//! the surface has C = 0 in its own patch exactly, so no offset is needed. Directions need not point
//! upwards. Rays that have not left after [`MOST_LAPS`] times round the torus count as free.

use glam::{DVec2, DVec3};

use crate::btf::bake::height_field::{HeightField, Patch, ReliefPoint};

/// A ray below the surface by less than this is on it, in texels.
const TOUCHING: f64 = 1e-9;
/// How often a ray may run round the torus; only rays parallel to the plane run longer.
const MOST_LAPS: f64 = 256.0;

impl HeightField {
    /// The point of the surface over a place of the plane z = 0.
    pub fn point_above(&self, on_plane: DVec2) -> ReliefPoint {
        let (x, along_x) = wrapped(on_plane.x, self.width());
        let (y, along_y) = wrapped(on_plane.y, self.height());
        ReliefPoint {
            x,
            y,
            within: DVec2::new(along_x - x as f64, along_y - y as f64),
        }
    }

    /// What a viewer in direction `towards` (z > 0) sees through the point `on_plane` of z = 0.
    pub fn seen_through(&self, on_plane: DVec2, towards: DVec3) -> Option<ReliefPoint> {
        let rise = self.highest() / towards.z;
        let start = DVec3::new(
            on_plane.x + towards.x * rise,
            on_plane.y + towards.y * rise,
            self.highest(),
        );
        let mut walk = Walk::from_above(self, start, -towards);
        walk.run(|segment| segment.first_root())
    }

    /// The first point that a ray from the surface meets; `None` when it leaves.
    pub fn next_hit(&self, from: ReliefPoint, direction: DVec3) -> Option<ReliefPoint> {
        let mut walk = Walk::from_surface(self, from, direction);
        walk.run(|segment| segment.first_root())
    }

    /// How many lights over one heading something stands before, seen from a surface point: the
    /// lowest so many. `slopes` are their rises a texel along `heading`, ascending.
    ///
    /// What a walk has passed below a light's ray lies below a higher light's too, so at every obstacle the ray is
    /// raised to the next light and continues from there.
    pub fn shadowed(&self, from: ReliefPoint, heading: DVec2, slopes: &[f64]) -> usize {
        let Some(&lowest) = slopes.first() else {
            return 0;
        };
        let mut walk = Walk::from_surface(self, from, heading.extend(lowest));
        for (count, &slope) in slopes.iter().enumerate() {
            walk.direction.z = slope;
            let obstacle = walk.run(|segment| segment.dips_below().then_some(0.0));
            if obstacle.is_none() {
                return count;
            }
        }
        slopes.len()
    }

    /// Whether something stands between a surface point and a light in `direction`.
    pub fn occluded(&self, from: ReliefPoint, direction: DVec3) -> bool {
        let mut walk = Walk::from_surface(self, from, direction);
        walk.run(|segment| segment.dips_below().then_some(0.0))
            .is_some()
    }
}

/// The part of a ray over one patch: g(s) = c + b·s + a·s² for 0 ≤ s ≤ length.
struct Segment {
    a: f64,
    b: f64,
    c: f64,
    length: f64,
}

impl Segment {
    #[inline]
    fn new(patch: Patch, entry: DVec2, z: f64, direction: DVec3, length: f64) -> Self {
        let along = direction.truncate();
        Self {
            a: -patch.twist * direction.x * direction.y,
            b: direction.z - patch.slope(entry).dot(along),
            c: z - patch.height(entry),
            length,
        }
    }

    #[inline]
    fn at_exit(&self) -> f64 {
        self.c + (self.b + self.a * self.length) * self.length
    }

    /// Whether g falls below 0.
    #[inline]
    fn dips_below(&self) -> bool {
        if self.at_exit() < -TOUCHING {
            return true;
        }
        let (a, b) = (self.a, self.b);
        // The lowest point of an upward parabola inside the segment: c − b²/4a.
        a > 0.0 && b < 0.0 && -b < 2.0 * a * self.length && self.c - b * b / (4.0 * a) < -TOUCHING
    }

    /// The first s where g reaches 0 from above.
    #[inline]
    fn first_root(&self) -> Option<f64> {
        let Self { a, b, length, .. } = *self;
        if self.c < -TOUCHING {
            return Some(0.0); // came below at the edge just crossed
        }
        let c = self.c.max(0.0);
        let dips = a > 0.0 && b < 0.0 && -b < 2.0 * a * length && b * b >= 4.0 * a * c;
        if self.at_exit() >= 0.0 && !dips {
            return None;
        }
        let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
        let s = if b < 0.0 {
            2.0 * c / (root - b)
        } else {
            (b + root) / (-2.0 * a)
        };
        Some(s.clamp(0.0, length))
    }
}

/// A ray under way: the block it is in, and how far it has come.
struct Walk<'a> {
    field: &'a HeightField,
    /// Moved by whole laps so that origin + t·direction stays on the grid.
    origin: DVec3,
    direction: DVec3,
    inverse: DVec2,
    x: usize,
    y: usize,
    t: f64,
    /// On the surface at t = 0: there g(0) = 0 whatever the rounding says.
    on_surface: bool,
}

impl<'a> Walk<'a> {
    fn from_above(field: &'a HeightField, start: DVec3, direction: DVec3) -> Self {
        let (x, px) = wrapped(start.x, field.width());
        let (y, py) = wrapped(start.y, field.height());
        Self {
            field,
            origin: DVec3::new(px, py, start.z),
            direction,
            inverse: inverse(direction),
            x,
            y,
            t: 0.0,
            on_surface: false,
        }
    }

    fn from_surface(field: &'a HeightField, from: ReliefPoint, direction: DVec3) -> Self {
        Self {
            field,
            origin: field.position(from),
            direction,
            inverse: inverse(direction),
            x: from.x,
            y: from.y,
            t: 0.0,
            on_surface: true,
        }
    }

    /// Steps from block to block until `meets` finds a distance within a patch.
    #[inline]
    fn run(&mut self, meets: impl Fn(&Segment) -> Option<f64>) -> Option<ReliefPoint> {
        let field = self.field;
        let top = field.maxima().len() - 1;
        let highest = field.highest();
        let farthest = MOST_LAPS * field.width().max(field.height()) as f64;
        let mut level = 0;
        loop {
            let z = self.origin.z + self.t * self.direction.z;
            if (self.direction.z >= 0.0 && z > highest) || self.t > farthest {
                return None;
            }
            let exit = self.exit(level);
            let lowest = z.min(self.origin.z + exit.t * self.direction.z);
            let maxima = &field.maxima()[level];
            let block = (self.y >> level) * maxima.width + (self.x >> level);
            if lowest <= f64::from(maxima.bounds[block]) {
                if level > 0 {
                    level -= 1;
                    continue;
                }
                let (entry, segment) = self.segment(exit.t);
                if let Some(s) = meets(&segment) {
                    return Some(self.point(entry, s));
                }
            } else if level < top {
                level += 1;
            }
            self.leave(&exit);
        }
    }

    /// The stretch of the ray over the present patch.
    #[inline]
    fn segment(&self, exit_t: f64) -> (DVec2, Segment) {
        let position = self.origin + self.t * self.direction;
        let corner = DVec2::new(self.x as f64, self.y as f64);
        let entry = (position.truncate() - corner).clamp(DVec2::ZERO, DVec2::ONE);
        let patch = self.field.patch(self.x, self.y);
        let length = (exit_t - self.t).max(0.0);
        let mut segment = Segment::new(patch, entry, position.z, self.direction, length);
        if self.on_surface && self.t == 0.0 {
            segment.c = 0.0;
        }
        (entry, segment)
    }

    fn point(&self, entry: DVec2, s: f64) -> ReliefPoint {
        let within = entry + s * self.direction.truncate();
        ReliefPoint {
            x: self.x,
            y: self.y,
            within: within.clamp(DVec2::ZERO, DVec2::ONE),
        }
    }

    /// Where the ray leaves the block of 2^level patches it is in.
    #[inline]
    fn exit(&self, level: usize) -> Exit {
        let (field, d) = (self.field, self.direction);
        let (low_x, high_x) = block(self.x, level, field.width());
        let (low_y, high_y) = block(self.y, level, field.height());
        let edge_x = if d.x > 0.0 { high_x } else { low_x };
        let edge_y = if d.y > 0.0 { high_y } else { low_y };
        let t_x = distance(edge_x, self.origin.x, self.inverse.x);
        let t_y = distance(edge_y, self.origin.y, self.inverse.y);
        Exit {
            t: t_x.min(t_y).max(self.t),
            through_x: t_x <= t_y,
            edge: if t_x <= t_y { edge_x } else { edge_y },
            low: if t_x <= t_y { low_y } else { low_x },
            high: if t_x <= t_y { high_y } else { high_x },
        }
    }

    /// Steps into the neighbouring block, round the torus where the grid ends.
    #[inline]
    fn leave(&mut self, exit: &Exit) {
        self.t = exit.t;
        let (d, field) = (self.direction, self.field);
        if exit.through_x {
            self.y = exit.clamp(self.origin.y + self.t * d.y);
            self.x = cross(exit.edge, d.x, field.width(), &mut self.origin.x);
        } else {
            self.x = exit.clamp(self.origin.x + self.t * d.x);
            self.y = cross(exit.edge, d.y, field.height(), &mut self.origin.y);
        }
    }
}

/// How a ray leaves a block: when, through which side, and where the block ends across.
struct Exit {
    t: f64,
    through_x: bool,
    edge: usize,
    low: usize,
    high: usize,
}

impl Exit {
    /// The index along the other axis, kept inside the block against rounding.
    #[inline]
    fn clamp(&self, place: f64) -> usize {
        (place as usize).clamp(self.low, self.high - 1)
    }
}

#[inline]
fn block(index: usize, level: usize, count: usize) -> (usize, usize) {
    let low = (index >> level) << level;
    (low, (low + (1 << level)).min(count))
}

#[inline]
fn distance(edge: usize, origin: f64, inverse: f64) -> f64 {
    if inverse.is_infinite() {
        return f64::INFINITY;
    }
    (edge as f64 - origin) * inverse
}

/// The index beyond an edge; wraps the origin with it.
#[inline]
fn cross(edge: usize, direction: f64, count: usize, origin: &mut f64) -> usize {
    if direction > 0.0 {
        if edge == count {
            *origin -= count as f64;
            return 0;
        }
        edge
    } else {
        if edge == 0 {
            *origin += count as f64;
            return count - 1;
        }
        edge - 1
    }
}

fn inverse(direction: DVec3) -> DVec2 {
    DVec2::new(1.0 / direction.x, 1.0 / direction.y)
}

/// A coordinate moved onto [0, count), and the index of its patch.
fn wrapped(place: f64, count: usize) -> (usize, f64) {
    let side = count as f64;
    let mut on_grid = place.rem_euclid(side);
    if on_grid >= side {
        on_grid = 0.0;
    }
    (on_grid as usize, on_grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    /// Marches in small steps: slow, and blind to what is thinner than a step.
    fn marched(field: &HeightField, start: DVec3, direction: DVec3, step: f64) -> Option<DVec3> {
        let below = |p: DVec3| {
            let (x, px) = wrapped(p.x, field.width());
            let (y, py) = wrapped(p.y, field.height());
            let within = DVec2::new(px - x as f64, py - y as f64);
            p.z < field.patch(x, y).height(within)
        };
        let mut t = step;
        while t < 400.0 {
            let p = start + t * direction;
            if below(p) {
                return Some(p);
            }
            if direction.z > 0.0 && p.z > field.highest() {
                return None;
            }
            t += step;
        }
        None
    }

    fn rough_field(width: usize, height: usize) -> HeightField {
        let mut random = crate::random::stream(3, "test field", 0, width as u64);
        let heights: Vec<f32> = (0..width * height)
            .map(|_| random.gen_range(0.0..3.0))
            .collect();
        HeightField::new(width, height, &heights)
    }

    fn random_direction(random: &mut crate::random::Stream) -> DVec3 {
        loop {
            let d = DVec3::from_array([(); 3].map(|()| random.gen_range(-1.0..1.0)));
            if d.length() > 0.1 && d.length() < 1.0 {
                return d.normalize();
            }
        }
    }

    #[test]
    fn what_is_seen_agrees_with_marching() {
        let field = rough_field(11, 6);
        let mut random = crate::random::stream(5, "views", 0, 0);
        let step = 2e-4;
        let mut agree = 0;
        for _ in 0..300 {
            let mut towards = random_direction(&mut random);
            towards.z = towards.z.abs().max(0.1);
            let towards = towards.normalize();
            let through = DVec2::new(random.gen_range(0.0..11.0), random.gen_range(0.0..6.0));
            let seen = field.seen_through(through, towards).unwrap();
            let start = through.extend(0.0) + towards * (field.highest() / towards.z);
            let wanted = marched(&field, start, -towards, step).unwrap();
            let found = field.position(seen);
            let difference = found - wanted;
            let wrapped = DVec2::new(
                difference.x - 11.0 * (difference.x / 11.0).round(),
                difference.y - 6.0 * (difference.y / 6.0).round(),
            );
            agree += usize::from(wrapped.length() < 2.0 * step && difference.z.abs() < 2.0 * step);
        }
        assert!(agree >= 298, "{agree} of 300"); // grazing hits thinner than a step
    }

    #[test]
    fn shadows_and_hits_agree_with_marching_and_with_each_other() {
        let field = rough_field(8, 8);
        let mut random = crate::random::stream(6, "shadows", 0, 0);
        let (mut agree, mut occluded_count) = (0, 0);
        for _ in 0..600 {
            let from = ReliefPoint {
                x: random.gen_range(0..8),
                y: random.gen_range(0..8),
                within: DVec2::new(random.gen_range(0.0..1.0), random.gen_range(0.0..1.0)),
            };
            let direction = random_direction(&mut random);
            let normal = field.normal(from);
            if normal.dot(direction) < 0.02 || direction.z.abs() < 0.02 {
                agree += 1;
                continue;
            }
            let occluded = field.occluded(from, direction);
            assert_eq!(occluded, field.next_hit(from, direction).is_some());
            let start = field.position(from) + 1e-7 * normal;
            agree += usize::from(occluded == marched(&field, start, direction, 1e-3).is_some());
            occluded_count += usize::from(occluded);
        }
        assert!(agree >= 597, "{agree} of 600");
        assert!((50..550).contains(&occluded_count));
    }

    #[test]
    fn lights_over_one_heading_are_shadowed_as_each_alone() {
        let field = rough_field(8, 8);
        let mut random = crate::random::stream(8, "headings", 0, 0);
        let slopes = [0.05, 0.3, 0.7, 1.5, 3.0, 1e12];
        let mut counts = [0; 7];
        for _ in 0..600 {
            let from = ReliefPoint {
                x: random.gen_range(0..8),
                y: random.gen_range(0..8),
                within: DVec2::new(random.gen_range(0.0..1.0), random.gen_range(0.0..1.0)),
            };
            let heading = DVec2::from_angle(random.gen_range(0.0..6.3));
            let together = field.shadowed(from, heading, &slopes);
            let alone = slopes
                .iter()
                .filter(|&&slope| field.occluded(from, heading.extend(slope).normalize()))
                .count();
            assert_eq!(together, alone);
            counts[together] += 1;
        }
        assert!(counts[..5].iter().all(|&count| count > 0), "{counts:?}");
    }

    #[test]
    fn hits_lie_on_the_ray() {
        let field = rough_field(9, 5);
        let mut random = crate::random::stream(7, "hits", 0, 0);
        for _ in 0..500 {
            let from = ReliefPoint {
                x: random.gen_range(0..9),
                y: random.gen_range(0..5),
                within: DVec2::new(random.gen_range(0.0..1.0), random.gen_range(0.0..1.0)),
            };
            let mut direction = random_direction(&mut random);
            if field.normal(from).dot(direction) < 0.0 {
                direction = -direction;
            }
            let Some(hit) = field.next_hit(from, direction) else {
                continue;
            };
            // The same heights over the line: z of the hit against z of the ray at its place.
            let way = field.position(hit) - field.position(from);
            let t = way.z / direction.z;
            let off = way - t * direction;
            let lap = |d: f64, side: f64| d - side * (d / side).round();
            assert!(
                lap(off.x, 9.0).abs() < 1e-6 && lap(off.y, 5.0).abs() < 1e-6,
                "{off}"
            );
        }
    }

    #[test]
    fn a_plane_shades_nothing_and_is_seen_where_it_is() {
        let field = HeightField::new(4, 4, &[2.0; 16]);
        let towards = DVec3::new(0.9, -0.3, 0.05).normalize();
        let seen = field.seen_through(DVec2::new(1.25, 3.5), towards).unwrap();
        let at = field.position(seen);
        assert!((at - DVec3::new(1.25, 3.5, 0.0)).length() < 1e-9, "{at}");
        let above = field.position(field.point_above(DVec2::new(5.25, -0.5)));
        assert!((above - DVec3::new(1.25, 3.5, 0.0)).length() < 1e-9);
        assert!(!field.occluded(seen, towards));
        assert!(!field.occluded(seen, DVec3::X));
        assert!(field.occluded(seen, DVec3::new(1.0, 0.0, -0.1).normalize()));
    }
}
