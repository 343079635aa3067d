//! Predictions of what was left out, from the rest, with the renderer's weights.

use rayon::prelude::*;

use crate::btf::direction::Direction;
use crate::btf::sample::Description;
use crate::error::Result;
use crate::progress::Progress;
use crate::render::held_out::errors::{ErrorSum, HeldOutErrors};
use crate::render::held_out::texels::ComparedTexels;
use crate::render::nearest::{DirectionSet, PairSet, Scratch, Weight, Weighting, lifted};

/// What is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    Lights,
    Views,
    Pairs,
}

impl Held {
    /// What of a sample can be left out.
    pub(super) fn of(description: &Description) -> &'static [Self] {
        match description.pairs {
            None => &[Self::Lights, Self::Views],
            Some(_) => &[Self::Pairs],
        }
    }

    /// The weightings that it can be predicted with.
    fn weightings(self) -> &'static [Weighting] {
        use Weighting::{Continuous, InverseAngle, Quadratic};
        match self {
            Self::Lights | Self::Views => &[Continuous, Quadratic, InverseAngle],
            Self::Pairs => &[Continuous, InverseAngle],
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Views => "views",
            Self::Pairs => "pairs",
        }
    }

    /// The directions or pairs that differ from all before them.
    pub(super) fn distinct(self, description: &Description) -> Result<Vec<u32>> {
        let (views, lights) = (&description.views, &description.lights);
        let any = Weighting::default();
        Ok(match (self, &description.pairs) {
            (Self::Lights, _) => DirectionSet::new(lights, any).kept().to_vec(),
            (Self::Views, _) => DirectionSet::new(views, any).kept().to_vec(),
            (Self::Pairs, Some(pairs)) => PairSet::new(views, lights, pairs, any)?.kept().to_vec(),
            (Self::Pairs, None) => Vec::new(),
        })
    }
}

/// One way of leaving out, with all weightings.
pub(super) struct Trial<'a> {
    pub(super) description: &'a Description,
    pub(super) texels: &'a ComparedTexels,
    pub(super) held: Held,
    pub(super) distinct: &'a [u32],
}

/// A prediction: the weighting, the angle of what was left out, and the errors.
type Prediction = (Weighting, f64, ErrorSum);

impl Trial<'_> {
    /// Leaves each group out and measures its predictions, by weighting.
    pub(super) fn run(
        &self,
        groups: &[Vec<u32>],
        progress: Progress<'_>,
    ) -> Result<Vec<(Weighting, HeldOutErrors)>> {
        progress.begin(
            format!("leaving out {}", self.held.name()),
            groups.len() as u64,
        );
        let of_groups: Vec<Vec<Prediction>> = groups
            .par_iter()
            .map(|group| {
                let predictions = self.leave_out(group)?;
                progress.advance(1)?;
                Ok(predictions)
            })
            .collect::<Result<_>>()?;
        progress.end();
        let of_weighting = |&weighting: &Weighting| {
            let mut errors = HeldOutErrors::default();
            let predictions = of_groups.iter().flatten();
            for (_, theta, sum) in predictions.filter(|(used, ..)| *used == weighting) {
                errors.add(*theta, sum);
            }
            (weighting, errors)
        };
        Ok(self.held.weightings().iter().map(of_weighting).collect())
    }

    /// The predictions of each of a group.
    fn leave_out(&self, group: &[u32]) -> Result<Vec<Prediction>> {
        let is_left = |one: &u32| !group.contains(one);
        let rest: Vec<u32> = self.distinct.iter().copied().filter(is_left).collect();
        if rest.is_empty() {
            return Ok(Vec::new());
        }
        let weightings = self.held.weightings().iter();
        let of_weighting = |&weighting: &Weighting| self.predict(group, &rest, weighting);
        let predictions: Vec<Vec<Prediction>> =
            weightings.map(of_weighting).collect::<Result<_>>()?;
        Ok(predictions.concat())
    }

    /// The predictions of each of a group from the rest, with one weighting.
    fn predict(
        &self,
        group: &[u32],
        rest: &[u32],
        weighting: Weighting,
    ) -> Result<Vec<Prediction>> {
        match (self.held, &self.description.pairs) {
            (Held::Pairs, Some(pairs)) => self.predict_pairs(pairs, group, rest, weighting),
            (Held::Views, _) => Ok(self.predict_directions::<false>(group, rest, weighting)),
            (Held::Lights | Held::Pairs, _) => {
                Ok(self.predict_directions::<true>(group, rest, weighting))
            }
        }
    }

    /// Views or lights of a product; all others of the other kind are taken as they are.
    fn predict_directions<const AS_LIGHTS: bool>(
        &self,
        group: &[u32],
        rest: &[u32],
        weighting: Weighting,
    ) -> Vec<Prediction> {
        // Tell which directions are left out, and which are taken as they are.
        let (views, lights) = (&self.description.views, &self.description.lights);
        let (directions, others) = match AS_LIGHTS {
            true => (lights, views.len()),
            false => (views, lights.len()),
        };
        let image = |one: u32, other: usize| match AS_LIGHTS {
            true => other * lights.len() + one as usize,
            false => one as usize * lights.len() + other,
        };
        // Weight the rest, and compare image by image.
        let kept: Vec<Direction> = rest.iter().map(|&one| directions[one as usize]).collect();
        let set = DirectionSet::new(&kept, weighting);
        let measure = |&one: &u32| {
            let wanted = directions[one as usize];
            let weights = direction_weights::<AS_LIGHTS>(&set, wanted);
            let mut sum = ErrorSum::default();
            for other in 0..others {
                let from = |weight: &Weight| {
                    let place = set.kept()[weight.index as usize] as usize;
                    (image(rest[place], other), weight.weight)
                };
                let blend: Vec<(usize, f32)> = weights.iter().map(from).collect();
                self.compare(image(one, other), &blend, &mut sum);
            }
            (weighting, wanted.theta(), sum)
        };
        group.iter().map(measure).collect()
    }

    fn predict_pairs(
        &self,
        pairs: &[[u32; 2]],
        group: &[u32],
        rest: &[u32],
        weighting: Weighting,
    ) -> Result<Vec<Prediction>> {
        let (views, lights) = (&self.description.views, &self.description.lights);
        let kept: Vec<[u32; 2]> = rest.iter().map(|&pair| pairs[pair as usize]).collect();
        let set = PairSet::new(views, lights, &kept, weighting)?;
        let measure = |&pair: &u32| {
            let [view, light] = pairs[pair as usize];
            let (view, light) = (lifted(views[view as usize].0), lights[light as usize]);
            let (mut scratch, mut found) = (Scratch::default(), Vec::new());
            if light.0.z > 0.0 {
                set.weigh(view, light.0, &mut scratch, &mut found);
            }
            let from = |weight: &Weight| {
                let place = set.kept()[weight.index as usize] as usize;
                (rest[place] as usize, weight.weight)
            };
            let blend: Vec<(usize, f32)> = found.iter().map(from).collect();
            let mut sum = ErrorSum::default();
            self.compare(pair as usize, &blend, &mut sum);
            (weighting, light.theta(), sum)
        };
        Ok(group.iter().map(measure).collect())
    }

    /// Adds the errors of a blend of images against a measured one.
    fn compare(&self, measured: usize, blend: &[(usize, f32)], sum: &mut ErrorSum) {
        let measured = self.texels.of_image(measured);
        let images: Vec<(&[f32], f32)> = blend
            .iter()
            .map(|&(image, weight)| (self.texels.of_image(image), weight))
            .collect();
        for (number, &measured) in measured.iter().enumerate() {
            let predicted: f32 = images
                .iter()
                .map(|(image, weight)| image[number] * weight)
                .sum();
            sum.add(predicted.max(0.0), measured);
        }
    }
}

/// The weights of a set for a direction.
fn direction_weights<const AS_LIGHTS: bool>(set: &DirectionSet, wanted: Direction) -> Vec<Weight> {
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    if AS_LIGHTS && wanted.0.z <= 0.0 {
        return found;
    }
    set.weigh::<AS_LIGHTS>(lifted(wanted.0), &mut scratch, &mut found);
    found
}
