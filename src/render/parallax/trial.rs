//! Does parallax help? Views are left out, predicted from the others with and without it, and compared with what was
//! measured there.

use std::collections::BTreeMap;
use std::f32::consts::PI;

use rand::Rng;
use rayon::prelude::*;

use crate::btf::HeightMap;
use crate::btf::direction::Direction;
use crate::btf::sample::{Pixels, Sample};
use crate::error::Result;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::random;
use crate::render::held_out::ErrorSum;
use crate::render::nearest::{DirectionSet, Scratch, Weight, Weighting, lifted};
use crate::render::parallax::reads::{Place, ReadList};
use crate::render::parallax::relief::Relief;

/// Lights under which a view is compared.
const LIGHTS: usize = 4;
/// Texels that are compared.
const TEXELS: usize = 1024;
/// Parallax helps when it leaves less than this share of the error of plain blending.
const HELPS: f64 = 0.98;
/// Lights lower than this cosine say little: their images are dark.
const LEAST_COSINE: f64 = 0.3;

/// The errors of predictions.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Views that were left out.
    pub views: usize,
    /// Errors of plain blending.
    pub plain: ErrorSum,
    /// Errors with parallax.
    pub parallax: ErrorSum,
}

/// What a prediction of one texel sums up: texel and share of each image's view.
type Blend = Vec<(u32, TexelIndex, f32)>;

impl Trial {
    /// Both errors, in words.
    pub fn describe(&self) -> String {
        format!(
            "prediction error of {} left-out views: {:.1} % with parallax, {:.1} % without",
            self.views,
            100.0 * self.parallax.relative(),
            100.0 * self.plain.relative()
        )
    }

    /// Whether parallax leaves clearly less error.
    pub fn helps(&self) -> bool {
        self.parallax.relative() < HELPS * self.plain.relative()
    }

    /// Leaves up to `most` views out, each in turn; `None` where too few are left to predict from.
    pub fn of(
        sample: &Sample,
        heights: &HeightMap,
        weighting: Weighting,
        most: usize,
        progress: Progress<'_>,
    ) -> Result<Option<Self>> {
        // Choose what is left out and compared.
        let description = sample.description();
        let views = DirectionSet::new(&description.views, weighting);
        if views.len() < 3 || description.pairs.is_some() {
            return Ok(None);
        }
        let work = Work {
            sample,
            relief: Relief::new(heights, views.directions(), 1),
            views: &views,
            lights: chosen_lights(&description.lights),
            texels: chosen_texels(sample.grid()),
            weighting,
        };
        // Leave each view out, with and without parallax.
        let held = spread(views.len(), most);
        progress.begin("trying parallax", held.len() as u64);
        let errors: Vec<[ErrorSum; 2]> = held
            .par_iter()
            .map(|&view| {
                let errors = work.leave_out(view)?;
                progress.advance(1)?;
                Ok(errors)
            })
            .collect::<Result<_>>()?;
        progress.end();
        // Add up in order.
        let mut trial = Self {
            views: held.len(),
            plain: ErrorSum::default(),
            parallax: ErrorSum::default(),
        };
        for [plain, parallax] in &errors {
            trial.plain.join(plain);
            trial.parallax.join(parallax);
        }
        Ok(Some(trial))
    }
}

struct Work<'a> {
    sample: &'a Sample,
    relief: Relief,
    views: &'a DirectionSet,
    /// As indices into the sample's lights.
    lights: Vec<usize>,
    texels: Vec<TexelIndex>,
    weighting: Weighting,
}

impl Work<'_> {
    /// The errors of predictions of a view from all others, plain and with parallax.
    fn leave_out(&self, held: usize) -> Result<[ErrorSum; 2]> {
        let others: Vec<u32> = (0..self.views.len() as u32)
            .filter(|&view| view as usize != held)
            .collect();
        let directions = self.views.directions();
        let rest: Vec<Direction> = others.iter().map(|&at| directions[at as usize]).collect();
        let view = lifted(directions[held].0);
        let mut weights = Vec::new();
        let set = DirectionSet::new(&rest, self.weighting);
        set.weigh::<false>(view, &mut Scratch::default(), &mut weights);
        weights
            .iter_mut()
            .for_each(|weight| weight.index = others[weight.index as usize]);
        let (plain, parallax) = self.blends(view, &weights);
        let mut errors = [ErrorSum::default(); 2];
        for &light in &self.lights {
            let images = self.read_images(light, held, &weights)?;
            for (at, texel) in self.texels.iter().enumerate() {
                let measured = value(&images[&(held as u32)], *texel);
                for (errors, blends) in errors.iter_mut().zip([&plain, &parallax]) {
                    let predicted = predict(&images, &blends[at]);
                    for (predicted, measured) in predicted.into_iter().zip(measured) {
                        errors.add(predicted, measured);
                    }
                }
            }
        }
        Ok(errors)
    }

    /// What is read for each texel, plain and with parallax.
    fn blends(&self, view: glam::DVec3, weights: &[Weight]) -> (Vec<Blend>, Vec<Blend>) {
        let mut list = ReadList::default();
        let plainly = |weights: &[Weight], texel: TexelIndex| -> Blend {
            let reads = weights.iter().map(|of| (of.index, texel, of.weight));
            reads.collect()
        };
        let blend = |&texel: &TexelIndex| {
            let place = Place {
                coord: self.sample.grid().centre(texel),
                level: 0,
                view: view.as_vec3(),
                reach: f32::INFINITY,
            };
            list.find(&self.relief, &place, weights);
            let reads = list.reads().iter();
            let mut blend: Blend = reads.map(|of| (of.view, of.texel, of.share)).collect();
            blend.extend(plainly(list.plain(), texel));
            (plainly(weights, texel), blend)
        };
        self.texels.iter().map(blend).unzip()
    }

    /// The images of the weighted views and the one left out, under a light; 1 for white facing the light.
    fn read_images(
        &self,
        light: usize,
        held: usize,
        weights: &[Weight],
    ) -> Result<BTreeMap<u32, Pixels>> {
        let lights = self.sample.description().lights.len();
        let views = weights.iter().map(|weight| weight.index);
        views
            .chain([held as u32])
            .map(|view| {
                let place = self.views.kept()[view as usize] as usize;
                Ok((view, self.sample.image(place * lights + light)?))
            })
            .collect()
    }
}

fn value(image: &Pixels, texel: TexelIndex) -> [f32; 3] {
    [0, 1, 2].map(|channel| PI * image.get(texel.index() * 3 + channel))
}

fn predict(images: &BTreeMap<u32, Pixels>, blend: &Blend) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for &(view, texel, share) in blend {
        let read = value(&images[&view], texel);
        sum.iter_mut()
            .zip(read)
            .for_each(|(sum, read)| *sum += share * read);
    }
    sum.map(|sum| sum.max(0.0))
}

/// So many of `count` things, evenly spread.
fn spread(count: usize, most: usize) -> Vec<usize> {
    let chosen = most.min(count);
    (0..chosen).map(|at| at * count / chosen).collect()
}

/// A few lights that stand high enough, evenly spread; all where none does.
fn chosen_lights(lights: &[Direction]) -> Vec<usize> {
    let high = |&light: &usize| lights[light].cos_theta() >= LEAST_COSINE;
    let mut all: Vec<usize> = (0..lights.len()).filter(high).collect();
    if all.is_empty() {
        all = (0..lights.len()).collect();
    }
    let places = spread(all.len(), LIGHTS);
    places.into_iter().map(|place| all[place]).collect()
}

/// Texels at random places, or all.
fn chosen_texels(grid: TexelGrid) -> Vec<TexelIndex> {
    if grid.len() <= TEXELS {
        return (0..grid.len() as u32).map(TexelIndex).collect();
    }
    let mut stream = random::stream(0, "parallax texels", 0, 0);
    let mut draw = |_| TexelIndex(stream.gen_range(0..grid.len()) as u32);
    (0..TEXELS).map(&mut draw).collect()
}
