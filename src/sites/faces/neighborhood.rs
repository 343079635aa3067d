//! The 36 faces round a face, in three-fold symmetry (Castellanos and Williams §3.12, Fig. 9).
//!
//! On a regular lattice 12 faces share a corner with a face, and 24 more share a corner with those. Turning the lattice
//! by 120° about the face permutes them, and no face stays where it is. So they fall in three sectors of 12, one per
//! edge of the face, and a turn moves whole sectors. A face that points downwards has the offsets of one that points
//! upwards, negated.
//!
//! On a surface a neighbour is found by a walk: across an edge of the face, then left or right in every face that
//! it passes. Where the surface ends, another walk of the same length is tried; if none arrives, the neighbour is
//! missing.

use std::f64::consts::{FRAC_PI_3, TAU};

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use crate::mesh::shapes;
use crate::mesh::topology::{NONE, Topology, next, previous};

/// Sectors of a neighbourhood, one per edge of the face.
pub const SECTORS: usize = 3;
/// Faces in a sector: 4 of the first ring, then 8 of the second.
pub const PER_SECTOR: usize = 12;
/// Faces in a neighbourhood.
pub const NEIGHBORS: usize = SECTORS * PER_SECTOR;
/// Columns and rows of the lattice on which the walks are found.
const LATTICE: u32 = 12;
/// Turns of a walk, at most.
const MOST_TURNS: u8 = 6;

/// The faces round a face, sector by sector; [`NONE`] for one beyond a boundary. Turning it by 120° moves sector c + 1
/// to sector c.
pub type Neighborhood = [u32; NEIGHBORS];

/// A walk from face to face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Walk {
    /// How many turns follow the first edge.
    turns: u8,
    /// The edge that is crossed first.
    start: u8,
    /// Bit i is set where turn i goes to the left.
    left: u8,
}

/// How the faces of a neighbourhood are reached, and how far they lie.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceTemplate {
    /// Per place in sector 0, the shortest walks to it.
    walks: Vec<Vec<Walk>>,
    /// Per place in sector 0, its distance on a regular lattice where adjacent centres are 1 apart.
    distances: [f64; PER_SECTOR],
}

impl Default for FaceTemplate {
    fn default() -> Self {
        Self::new()
    }
}

impl FaceTemplate {
    /// The neighbourhood of two rings.
    pub fn new() -> Self {
        let lattice = Lattice::new();
        let places = lattice.places();
        let mut distances = [0.0; PER_SECTOR];
        for (distance, place) in distances.iter_mut().zip(&places) {
            *distance = lattice.offset(*place).length();
        }
        Self {
            walks: lattice.walks(&places),
            distances,
        }
    }

    /// Distances of the places of a sector on a regular lattice, in units of the distance of adjacent centres.
    pub fn distances(&self) -> &[f64; PER_SECTOR] {
        &self.distances
    }

    /// The neighbourhoods of all faces: 144 bytes for each.
    pub fn around_all(&self, topology: &Topology) -> Vec<Neighborhood> {
        let faces = (0..topology.opposite.len() as u32 / 3).into_par_iter();
        faces.map(|face| self.around(topology, face)).collect()
    }

    /// The neighbourhood of a face of a surface that continues beyond its boundary as its mirror image. So a face can
    /// stand for itself, and more than once.
    pub fn around_mirrored(&self, topology: &Topology, face: u32) -> Neighborhood {
        let mut neighborhood = self.around(topology, face);
        for (at, neighbor) in neighborhood.iter_mut().enumerate() {
            if *neighbor == NONE {
                let walk = self.walks[at % PER_SECTOR][0];
                *neighbor = walk.mirrored_end(topology, face, at / PER_SECTOR);
            }
        }
        neighborhood
    }

    /// The neighbourhood of a face; [`NONE`] for what lies beyond a boundary.
    pub fn around(&self, topology: &Topology, face: u32) -> Neighborhood {
        let mut neighborhood = [NONE; NEIGHBORS];
        for (sector, places) in neighborhood.chunks_exact_mut(PER_SECTOR).enumerate() {
            for (place, walks) in places.iter_mut().zip(&self.walks) {
                let mut ends = walks.iter().map(|walk| walk.end(topology, face, sector));
                *place = ends.find(|&end| end != NONE).unwrap_or(NONE);
            }
        }
        neighborhood
    }
}

impl Walk {
    /// The face at the end of the walk turned to a sector; [`NONE`] if it leaves the surface.
    fn end(self, topology: &Topology, face: u32, sector: usize) -> u32 {
        let start = (usize::from(self.start) + sector) % 3;
        let mut inside = topology.opposite[3 * face as usize + start];
        for turn in 0..self.turns {
            if inside == NONE {
                return NONE;
            }
            // Seen inwards from an edge, its end is on the right.
            let exit = match self.left >> turn & 1 {
                1 => previous(inside),
                _ => next(inside),
            };
            inside = topology.opposite[exit as usize];
        }
        if inside == NONE { NONE } else { inside / 3 }
    }
}

impl Walk {
    /// The face at the end of the walk, where every boundary edge leads into the mirror image of its own face: the walk
    /// stays there, and left and right change places.
    fn mirrored_end(self, topology: &Topology, face: u32, sector: usize) -> u32 {
        let mut is_mirrored = false;
        let mut cross = |half_edge: u32| {
            let twin = topology.opposite[half_edge as usize];
            is_mirrored ^= twin == NONE;
            (if twin == NONE { half_edge } else { twin }, is_mirrored)
        };
        let first = 3 * face + ((usize::from(self.start) + sector) % 3) as u32;
        let (mut inside, mut mirrored) = cross(first);
        for turn in 0..self.turns {
            let is_left = self.left >> turn & 1 == 1;
            let exit = if is_left != mirrored {
                previous(inside)
            } else {
                next(inside)
            };
            (inside, mirrored) = cross(exit);
        }
        inside / 3
    }
}

/// A piece of a regular lattice round a face.
struct Lattice {
    topology: Topology,
    triangles: Vec<[u32; 3]>,
    centers: Vec<DVec2>,
    middle: u32,
}

impl Lattice {
    fn new() -> Self {
        let mesh = shapes::grid(LATTICE, LATTICE, 1.0);
        // Steps along x, along the diagonal and along y become unit vectors at 0°, 60° and 120°; centres of
        // adjacent faces are then 1/√3 apart.
        let place =
            |p: Vec3| DVec2::new(f64::from(p.x - p.y / 2.0), f64::from(p.y) * 0.75f64.sqrt());
        let center = |t: usize| mesh.corners(t).map(place).into_iter().sum::<DVec2>() / 3f64.sqrt();
        Self {
            topology: Topology::new(&mesh.triangles),
            centers: (0..mesh.triangles.len()).map(center).collect(),
            middle: LATTICE * LATTICE + LATTICE,
            triangles: mesh.triangles,
        }
    }

    fn offset(&self, face: u32) -> DVec2 {
        self.centers[face as usize] - self.centers[self.middle as usize]
    }

    /// The rings of faces round the middle.
    fn rings(&self) -> [Vec<u32>; 2] {
        let mut held = vec![self.middle];
        [(); 2].map(|()| {
            let corners: Vec<u32> = held
                .iter()
                .flat_map(|&face| self.triangles[face as usize])
                .collect();
            let touches = |&face: &u32| {
                let own = &self.triangles[face as usize];
                !held.contains(&face) && own.iter().any(|corner| corners.contains(corner))
            };
            let all = 0..self.triangles.len() as u32;
            let ring: Vec<u32> = all.filter(touches).collect();
            held.extend(&ring);
            ring
        })
    }

    /// The places of sector 0: ring by ring, nearest first, then counter-clockwise. It spans 60° to both sides of
    /// edge 0; of the two directions to its corners it has the first.
    fn places(&self) -> Vec<u32> {
        let across = self.topology.opposite[3 * self.middle as usize] / 3;
        let axis = self.offset(across);
        let angle = |face: u32| {
            let turned = axis.angle_to(self.offset(face)) + FRAC_PI_3 + 1e-9;
            turned.rem_euclid(TAU)
        };
        let mut places = Vec::with_capacity(PER_SECTOR);
        for ring in self.rings() {
            let mut of_sector: Vec<u32> = ring;
            of_sector.retain(|&face| angle(face) < TAU / 3.0);
            of_sector.sort_by(|&a, &b| {
                let rounded = |face: u32| (self.offset(face).length_squared() * 3.0).round();
                let by_distance = rounded(a).total_cmp(&rounded(b));
                by_distance.then(angle(a).total_cmp(&angle(b)))
            });
            places.extend(of_sector);
        }
        places
    }

    /// The shortest walks to each place.
    fn walks(&self, places: &[u32]) -> Vec<Vec<Walk>> {
        let mut found = vec![Vec::<Walk>::new(); places.len()];
        for turns in 0..=MOST_TURNS {
            for start in 0..3 {
                for left in 0..1 << turns {
                    let walk = Walk { turns, start, left };
                    let end = walk.end(&self.topology, self.middle, 0);
                    let Some(place) = places.iter().position(|&place| place == end) else {
                        continue;
                    };
                    let shortest = found[place].first().map_or(turns, |walk| walk.turns);
                    if turns == shortest {
                        found[place].push(walk);
                    }
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sites::faces::triangular_grid::TriangularGrid;
    use glam::Vec2;

    /// A turn counter-clockwise, in radians.
    fn turned(offset: Vec2, angle: f32) -> Vec2 {
        Vec2::from_angle(angle).rotate(offset)
    }

    #[test]
    fn there_are_twelve_and_twenty_four() {
        let lattice = Lattice::new();
        let [first, second] = lattice.rings();
        assert_eq!((first.len(), second.len()), (12, 24));
        assert_eq!(lattice.places().len(), PER_SECTOR);
        let template = FaceTemplate::new();
        assert!(template.walks.iter().all(|walks| !walks.is_empty()));
        // Squared: across an edge 1; round a corner 3, 3 and 4; then the second ring.
        let squares = template.distances().map(|d| (d * d).round() as u32);
        assert_eq!(squares, [1, 3, 3, 4, 7, 7, 9, 9, 12, 12, 13, 13]);
    }

    #[test]
    fn neighborhoods_of_a_grid_have_the_same_offsets_in_every_sector() {
        let grid = TriangularGrid::new(24, 2).unwrap();
        let level = &grid.pyramid.levels[1];
        let template = FaceTemplate::new();
        let unit = level.adjacent_distances().mean as f32;
        let mut expected: Option<Vec<Vec2>> = None;
        let mut whole = [0, 0];
        for face in 0..level.count() as u32 {
            let around = template.around(&level.topology, face);
            let center = level.centers[face as usize];
            if around.contains(&NONE) {
                continue;
            }
            whole[usize::from(level.white[face as usize])] += 1;
            let offsets = around.map(|other| (level.centers[other as usize] - center).truncate());
            // Turned so that the neighbour across edge 0 lies to the right.
            let angle = -offsets[0].to_angle();
            for (sector, places) in offsets.chunks(PER_SECTOR).enumerate() {
                let back = angle - sector as f32 * std::f32::consts::TAU / 3.0;
                let places: Vec<Vec2> = places.iter().map(|&o| turned(o, back) / unit).collect();
                let expected = expected.get_or_insert_with(|| places.clone());
                for (place, expected) in places.iter().zip(expected.iter()) {
                    assert!(place.distance(*expected) < 1e-3);
                }
            }
            let mut all = around.to_vec();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), NEIGHBORS);
            assert!(!all.contains(&face));
        }
        assert!(whole[0] > 50 && whole[1] > 50, "{whole:?}");
        for (offset, distance) in expected.unwrap().iter().zip(template.distances()) {
            assert!((f64::from(offset.length()) - distance).abs() < 1e-3);
        }
    }

    #[test]
    fn beyond_a_straight_border_lies_the_mirror_image() {
        let grid = TriangularGrid::new(24, 2).unwrap();
        let level = &grid.pyramid.levels[1];
        let template = FaceTemplate::new();
        let unit = level.adjacent_distances().mean as f32;
        let (mut mirrored, mut kept) = (0, 0);
        for face in 0..level.count() as u32 {
            let (cut, whole) = (
                template.around(&level.topology, face),
                template.around_mirrored(&level.topology, face),
            );
            let center = level.centers[face as usize];
            // Far from the zigzag on both sides, so that only the lower border is near.
            let is_low = center.y < 6.0 * unit && (8.0..16.0).contains(&center.x);
            for (at, (&cut, &whole)) in cut.iter().zip(&whole).enumerate() {
                assert_ne!(whole, NONE);
                if cut != NONE {
                    assert_eq!(cut, whole);
                    kept += 1;
                } else if is_low {
                    let image = level.centers[whole as usize] * Vec3::new(1.0, -1.0, 1.0);
                    let distance = template.distances()[at % PER_SECTOR] as f32;
                    assert!((image.distance(center) / unit - distance).abs() < 1e-3);
                    mirrored += 1;
                }
            }
        }
        assert!(mirrored > 100 && kept > mirrored, "{mirrored} {kept}");
    }

    #[test]
    fn faces_at_a_border_miss_neighbors_and_keep_the_others() {
        let grid = TriangularGrid::new(10, 1).unwrap();
        let level = &grid.pyramid.levels[0];
        let template = FaceTemplate::new();
        let (mut whole, mut cut) = (0, 0);
        for face in 0..level.count() as u32 {
            let around = template.around(&level.topology, face);
            let found: Vec<u32> = around.into_iter().filter(|&other| other != NONE).collect();
            let unit = level.adjacent_distances().mean;
            for other in &found {
                assert!(level.distance(face as usize, *other as usize) < 4.1 * unit);
            }
            match found.len() {
                NEIGHBORS => whole += 1,
                3.. => cut += 1,
                _ => {}
            }
        }
        assert!(whole > 0 && cut > whole);
    }
}
