//! The views and lights of a bake, and how wide highlights have to be between them.

use crate::btf::bake::angular::Widening;
use crate::btf::bake::lights::Lights;
use crate::btf::direction::Direction;

/// Lights at most by which `--samples auto` tells how many samples a texel needs.
pub(super) const MOST_PILOTS: usize = 12;

/// A view among those of the bake.
#[derive(Clone, Copy)]
pub(super) struct View {
    pub(super) index: usize,
    pub(super) direction: Direction,
}

/// All directions of a bake.
pub(super) struct Directions {
    pub(super) views: Vec<Direction>,
    pub(super) lights: Vec<Direction>,
    /// `None`: highlights are as the material has them.
    pub(super) widening: Option<Widening>,
}

impl Directions {
    pub(super) fn view(&self, index: usize) -> View {
        View {
            index,
            direction: self.views[index],
        }
    }

    /// Some lights as the image of a view has them.
    pub(super) fn lights(&self, view: View, chosen: Vec<usize>) -> Lights {
        let directions: Vec<Direction> = chosen.iter().map(|&light| self.lights[light]).collect();
        let mut lights = Lights::new(&directions);
        lights.least_alpha_squared = self.widening.as_ref().map(|widening| {
            let least = |&light: &usize| widening.least_alpha_squared(view.index, light) as f32;
            chosen.iter().map(least).collect()
        });
        lights
    }

    /// Some lights and the pilots, which follow where they are not among them.
    pub(super) fn lights_with_pilots(&self, view: View, mut chosen: Vec<usize>) -> Lights {
        let mut places = Vec::with_capacity(MOST_PILOTS);
        for pilot in self.pilots() {
            let place = chosen.iter().position(|&light| light == pilot);
            places.push(place.unwrap_or(chosen.len()));
            if place.is_none() {
                chosen.push(pilot);
            }
        }
        let mut lights = self.lights(view, chosen);
        lights.pilots = places;
        lights
    }

    /// Some lights, spread over all; the same for every view, slab and run.
    pub(super) fn pilots(&self) -> impl Iterator<Item = usize> {
        let count = self.lights.len();
        let taken = count.min(MOST_PILOTS);
        (0..taken).map(move |index| index * count / taken)
    }

    /// Lights halfway between the pilots in the order of the set.
    pub(super) fn between_pilots(&self) -> Vec<usize> {
        let count = self.lights.len();
        let half_step = count / MOST_PILOTS.min(count) / 2;
        self.pilots().map(|pilot| pilot + half_step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(lights: usize) -> Directions {
        let set = format!("fibonacci:{lights}").parse::<crate::btf::direction_set::DirectionSet>();
        let lights = set.unwrap().directions().unwrap();
        Directions {
            views: vec![lights[0]],
            lights,
            widening: None,
        }
    }

    #[test]
    fn pilots_are_the_same_in_every_run_of_lights() {
        let directions = directions(40);
        let view = directions.view(0);
        let pilots: Vec<usize> = directions.pilots().collect();
        assert_eq!(pilots.len(), MOST_PILOTS);
        for run in [0..40, 0..7, 30..40, 13..14] {
            let lights = directions.lights_with_pilots(view, run.clone().collect());
            let at = |light: usize| directions.lights[light].0.as_vec3();
            for (light, place) in run.zip(0..) {
                assert_eq!(lights.directions.get(place), at(light));
            }
            for (&pilot, &place) in pilots.iter().zip(&lights.pilots) {
                assert_eq!(lights.directions.get(place), at(pilot));
            }
        }
    }

    #[test]
    fn lights_between_pilots_are_others_where_there_are_enough() {
        let many = directions(40);
        let between = many.between_pilots();
        assert_eq!(between.len(), MOST_PILOTS);
        assert!(many.pilots().all(|pilot| !between.contains(&pilot)));
        assert_eq!(directions(5).between_pilots(), [0, 1, 2, 3, 4]);
    }
}
