//! Which directions a set has, and in which order its images are written.
//!
//! Where every view stands with every light just once the layout is `product`, else `pairs`. A set that has
//! at least half of all images of its product is a product with gaps; one that has fewer is scattered.

use std::collections::{BTreeMap, BTreeSet};

use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::import::fill::{Blend, nearest};
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::prepare::{Preparation, Selection};
use crate::error::{Error, Result};

/// Directions that a note names; an error names all.
const NAMED: usize = 8;

/// What is written at one place of the sample.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Slot {
    /// An image of the list, by its place there.
    Read(usize),
    /// An image that the set lacks, blended from others.
    Fill(Blend),
}

/// The directions and images of a sample.
#[derive(Debug)]
pub(super) struct Arrangement {
    pub(super) views: Vec<Direction>,
    pub(super) lights: Vec<Direction>,
    /// (view, light) of each written image; `None` for the full product.
    pub(super) pairs: Option<Vec<[u32; 2]>>,
    /// The written images, in their order.
    pub(super) slots: Vec<Slot>,
    /// (view, light) of the images that are interpolated.
    pub(super) filled: Vec<[u32; 2]>,
    /// What the user should know.
    pub(super) notes: Vec<String>,
}

/// An image of the list that is used, and its directions by number.
#[derive(Clone, Copy)]
struct Used {
    image: usize,
    pair: [u32; 2],
}

/// The directions and images of a list that the user keeps.
struct Chosen {
    views: Vec<Direction>,
    lights: Vec<Direction>,
    used: Vec<Used>,
}

impl Arrangement {
    /// Arranges the images of a list as the user chose.
    pub(super) fn of(list: &ImageList, preparation: &Preparation) -> Result<Self> {
        let chosen = Chosen::of(list, preparation)?;
        let mut notes = check_repeated(list, &chosen.used)?;
        let missing = chosen.missing();
        notes.extend(chosen.check_missing(list, preparation, &missing)?);
        let is_each_once = chosen.used.len() + missing.len() == chosen.product().count();
        let is_whole = missing.is_empty() || preparation.fill;
        Ok(match is_each_once && is_whole && !preparation.scattered {
            true => chosen.into_product(list, missing, notes),
            false => chosen.into_pairs(notes),
        })
    }

    /// The images of the list that are read, in the order of the sample.
    pub(super) fn read_images(&self) -> Vec<usize> {
        let read = |slot: &Slot| match slot {
            Slot::Read(image) => Some(*image),
            Slot::Fill(_) => None,
        };
        self.slots.iter().filter_map(read).collect()
    }
}

impl Chosen {
    /// Numbers the directions of a list, in the order of rings for a set, and keeps what the user chose.
    fn of(list: &ImageList, preparation: &Preparation) -> Result<Self> {
        // Number the directions as they come.
        let (mut views, mut lights) = (Vec::new(), Vec::new());
        let number = |(image, measured): (usize, &MeasuredImage)| Used {
            image,
            pair: [
                place_of(measured.view, &mut views),
                place_of(measured.light, &mut lights),
            ],
        };
        let mut used: Vec<Used> = list.images.iter().enumerate().map(number).collect();
        // Put those of a set in the order of rings.
        if list.is_set {
            let (of_views, of_lights) = (ring_order(&mut views), ring_order(&mut lights));
            for used in &mut used {
                let [view, light] = used.pair.map(|number| number as usize);
                used.pair = [of_views[view], of_lights[light]];
            }
        }
        // Drop what the user does not keep, and number anew.
        let (views, of_views) = kept("keep-views", &preparation.keep_views, views)?;
        let (lights, of_lights) = kept("keep-lights", &preparation.keep_lights, lights)?;
        let kept = |used: Used| {
            let [view, light] = used.pair.map(|number| number as usize);
            let pair = [of_views[view]?, of_lights[light]?];
            Some(Used { pair, ..used })
        };
        let used: Vec<Used> = used.into_iter().filter_map(kept).collect();
        match used.is_empty() {
            false => Ok(Self {
                views,
                lights,
                used,
            }),
            true => Err(Error::option(
                "keep-views",
                "no image has both a kept view and a kept light",
                "directions that occur together in the set",
            )),
        }
    }

    /// Every view with every light.
    fn product(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (views, lights) = (self.views.len() as u32, self.lights.len() as u32);
        (0..views).flat_map(move |view| (0..lights).map(move |light| [view, light]))
    }

    /// Views with lights that no image shows.
    fn missing(&self) -> Vec<[u32; 2]> {
        let present: BTreeSet<[u32; 2]> = self.used.iter().map(|used| used.pair).collect();
        self.product()
            .filter(|pair| !present.contains(pair))
            .collect()
    }

    /// Gaps are a fault of a set unless the user says what becomes of them, and a note of a list.
    fn check_missing(
        &self,
        list: &ImageList,
        preparation: &Preparation,
        missing: &[[u32; 2]],
    ) -> Result<Option<String>> {
        let is_scattered = missing.len() * 2 > self.product().count();
        if preparation.fill && is_scattered {
            return Err(self.too_scattered(missing));
        }
        if missing.is_empty() || is_scattered || preparation.fill {
            return Ok(None);
        }
        match list.is_set && !preparation.scattered {
            true => Err(self.missing_images(list, missing)),
            false => Ok(Some(self.note_of_missing(missing))),
        }
    }

    /// Every view with every light, in this order; what is missing is blended.
    fn into_product(
        self,
        list: &ImageList,
        missing: Vec<[u32; 2]>,
        notes: Vec<String>,
    ) -> Arrangement {
        let places: BTreeMap<[u32; 2], usize> = self
            .used
            .iter()
            .map(|used| (used.pair, used.image))
            .collect();
        let slot = |pair: [u32; 2]| match places.get(&pair) {
            Some(&image) => Slot::Read(image),
            None => {
                let [view, light] = pair.map(|number| number as usize);
                let (view, light) = (self.views[view], self.lights[light]);
                Slot::Fill(nearest(&list.images, places.values(), view, light))
            }
        };
        Arrangement {
            slots: self.product().map(slot).collect(),
            pairs: None,
            filled: missing,
            notes,
            views: self.views,
            lights: self.lights,
        }
    }

    /// The images as they come.
    fn into_pairs(self, notes: Vec<String>) -> Arrangement {
        Arrangement {
            pairs: Some(self.used.iter().map(|used| used.pair).collect()),
            slots: self
                .used
                .iter()
                .map(|used| Slot::Read(used.image))
                .collect(),
            filled: Vec::new(),
            notes,
            views: self.views,
            lights: self.lights,
        }
    }

    /// A pair of directions in degrees, in the order of Bonn's names.
    fn told(&self, [view, light]: [u32; 2]) -> String {
        let angles = |direction: Direction| {
            let rounded = |radians: f64| (radians.to_degrees() * 100.0).round() / 100.0;
            let (theta, phi) = (rounded(direction.theta()), rounded(direction.phi()));
            format!("({theta}°, {phi}°)")
        };
        let (view, light) = (self.views[view as usize], self.lights[light as usize]);
        format!("light {}, view {}", angles(light), angles(view))
    }

    fn missing_images(&self, list: &ImageList, missing: &[[u32; 2]]) -> Error {
        let named: Vec<String> = missing.iter().map(|&pair| self.told(pair)).collect();
        let (count, all) = (missing.len(), self.product().count());
        Error::data("images", format!("{count} of {all} are missing"))
            .expected(format!(
                "every view with every light, also\n  {}",
                named.join("\n  ")
            ))
            .advice("--fill interpolates them, --scattered takes the images that are there")
            .in_file(&list.path)
    }

    fn note_of_missing(&self, missing: &[[u32; 2]]) -> String {
        let first = missing.iter().take(NAMED);
        let named: Vec<String> = first.map(|&pair| self.told(pair)).collect();
        let more = if missing.len() > NAMED { " …" } else { "" };
        format!(
            "{} of {} images are missing, so the sample is a list of pairs (--fill interpolates them): {}{more}",
            missing.len(),
            self.product().count(),
            named.join("; ")
        )
    }

    fn too_scattered(&self, missing: &[[u32; 2]]) -> Error {
        let found = format!(
            "{} of {} images of every view with every light are missing",
            missing.len(),
            self.product().count()
        );
        Error::option("fill", found, "a set that has at least half of them")
    }
}

/// Sorts directions by θ, then φ, whichever images are missing; the new number of each old one.
fn ring_order(directions: &mut Vec<Direction>) -> Vec<u32> {
    // Directions of one ring differ by rounding.
    let rounded = |radians: f64| (radians / SAME_DIRECTION).round();
    let key = |direction: &Direction| (rounded(direction.theta()), rounded(direction.phi()));
    let mut order: Vec<usize> = (0..directions.len()).collect();
    order.sort_by(|&a, &b| {
        let ((theta, phi), (other_theta, other_phi)) = (key(&directions[a]), key(&directions[b]));
        theta
            .total_cmp(&other_theta)
            .then(phi.total_cmp(&other_phi))
    });
    let mut numbers = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        numbers[old] = new as u32;
    }
    *directions = order.iter().map(|&old| directions[old]).collect();
    numbers
}

/// The directions that a choice keeps, and the new number of each old one.
fn kept(
    option: &str,
    selection: &Option<Selection>,
    directions: Vec<Direction>,
) -> Result<(Vec<Direction>, Vec<Option<u32>>)> {
    let Some(selection) = selection else {
        let numbers = (0..directions.len() as u32).map(Some).collect();
        return Ok((directions, numbers));
    };
    // Refuse a choice of directions that are not there.
    let fault = |found: String| {
        let count = directions.len();
        Error::option(
            option,
            found,
            format!("numbers below {count}, or theta:DEGREES that some have"),
        )
    };
    if let Some(beyond) = selection.beyond(directions.len()) {
        return Err(fault(format!("direction {beyond} of {}", directions.len())));
    }
    // Number those that are kept.
    let (mut left, mut numbers) = (Vec::new(), Vec::new());
    for (number, &direction) in directions.iter().enumerate() {
        numbers.push(selection.keeps(number, direction).then(|| {
            left.push(direction);
            left.len() as u32 - 1
        }));
    }
    match left.is_empty() {
        true => Err(fault(format!("`{selection}` keeps none"))),
        false => Ok((left, numbers)),
    }
}

/// The place of a direction among those seen so far; a new one is added.
fn place_of(direction: Direction, seen: &mut Vec<Direction>) -> u32 {
    let known = seen
        .iter()
        .position(|&other| other.angle_to(direction) <= SAME_DIRECTION);
    known.unwrap_or_else(|| {
        seen.push(direction);
        seen.len() - 1
    }) as u32
}

/// Images of the same directions: all are a fault of a set, a note of a list.
fn check_repeated(list: &ImageList, used: &[Used]) -> Result<Vec<String>> {
    let mut first: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut faults = Vec::new();
    for used in used {
        let earlier = *first.entry(used.pair).or_insert(used.image);
        if earlier != used.image {
            let name = |image: usize| list.images[image].path.display();
            faults.push(format!(
                "{}: the same directions as {}",
                name(used.image),
                name(earlier)
            ));
        }
    }
    match faults.len() {
        0 => Ok(Vec::new()),
        _ if list.is_set => Err(Error::Faults {
            path: list.path.clone(),
            lines: faults,
            usage: false,
        }),
        count => Ok(vec![format!(
            "{count} images repeat the directions of another, {} first",
            faults[0]
        )]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::import::family::Family;
    use crate::btf::import::list_options::Handedness;
    use crate::btf::import::place::Place;

    /// Images at these angles of view and light, in degrees.
    fn list(angles: &[(f64, f64)], is_set: bool) -> ImageList {
        let at = |degrees: f64| Direction::from_angles(degrees.to_radians(), 1.0);
        let image = |&(view, light): &(f64, f64)| MeasuredImage {
            path: format!("v{view}l{light}.png").into(),
            view: at(view),
            light: at(light),
        };
        ImageList {
            name: "set".into(),
            path: "set".into(),
            kind: "test",
            family: Family::Any,
            handedness: Handedness::Right,
            images: angles.iter().map(image).collect(),
            place: Place::default(),
            is_set,
            positions: None,
            notes: Vec::new(),
            facts: serde_json::Map::new(),
        }
    }

    fn arranged(list: &ImageList, preparation: &Preparation) -> Arrangement {
        Arrangement::of(list, preparation).unwrap()
    }

    #[test]
    fn gaps_and_repetitions_of_a_list_are_notes() {
        let plain = Preparation::default();
        let gap = arranged(
            &list(&[(0.0, 10.0), (0.0, 20.0), (5.0, 20.0)], false),
            &plain,
        );
        assert_eq!(gap.pairs, Some(vec![[0, 0], [0, 1], [1, 1]]));
        assert!(
            gap.notes[0].contains("1 of 4") && gap.notes[0].contains("(10°"),
            "{:?}",
            gap.notes
        );
        let twice = arranged(&list(&[(0.0, 10.0), (0.0, 10.0)], false), &plain);
        assert_eq!(twice.read_images(), [0, 1]);
        assert!(
            twice.notes[0].contains("1 images repeat"),
            "{:?}",
            twice.notes
        );
        let scattered = arranged(
            &list(&[(0.0, 10.0), (5.0, 20.0), (9.0, 30.0)], true),
            &plain,
        );
        assert_eq!((scattered.notes.len(), scattered.slots.len()), (0, 3));
    }

    #[test]
    fn directions_of_a_set_are_sorted_and_chosen() {
        let set = list(&[(5.0, 20.0), (0.0, 20.0), (5.0, 10.0), (0.0, 10.0)], true);
        let whole = arranged(&set, &Preparation::default());
        assert_eq!(
            (whole.pairs.is_none(), whole.read_images()),
            (true, vec![3, 1, 2, 0])
        );
        let preparation = Preparation {
            keep_views: Some("1".parse().unwrap()),
            ..Preparation::default()
        };
        let chosen = arranged(&set, &preparation);
        assert_eq!((chosen.views.len(), chosen.read_images()), (1, vec![2, 0]));
    }

    #[test]
    fn what_is_missing_is_blended_where_the_user_wants_it() {
        let set = list(&[(0.0, 10.0), (0.0, 20.0), (5.0, 20.0)], true);
        let fill = Preparation {
            fill: true,
            ..Preparation::default()
        };
        let filled = arranged(&set, &fill);
        assert_eq!(filled.filled, [[1, 0]]);
        assert!(matches!(&filled.slots[2], Slot::Fill(blend) if blend.0.len() == 3));
        let error = Arrangement::of(&set, &Preparation::default()).unwrap_err();
        assert!(error.to_string().contains("--fill"), "{error}");
        let scattered = list(&[(0.0, 10.0), (5.0, 20.0), (9.0, 30.0)], true);
        assert!(Arrangement::of(&scattered, &fill).is_err());
    }
}
