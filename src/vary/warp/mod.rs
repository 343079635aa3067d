//! Feature-based warping of a mask (Zhang 2003 §4.3): operations that the transition function drives.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`scaling`] | features shrink or grow along an axis, as a share of their own width |
//! | [`motion`] | features are scaled, turned and moved about their centres |
//! | [`radial`], [`mesh`], [`field`] | what that says of all pixels: three ways from features to the plane |
//!
//! Where the transition is 0 nothing changes, where it is 1 an operation acts in full.

pub(crate) mod field;
pub(crate) mod mesh;
pub(crate) mod motion;
pub(crate) mod radial;
pub(crate) mod scaling;

use std::str::FromStr;

use glam::DVec2;
use ndarray::Array2;

use crate::error::{Error, Result};
use crate::vary::contours::MaskFeatures;
use crate::vary::label_set::LabelSet;
use crate::vary::morphology::{LARGEST_RADIUS, Operation, morph};
use crate::vary::nearest_pixel::Axis;
pub use crate::vary::warp::motion::Motion;
use crate::vary::warp::motion::{LARGEST_SCALE, Moved};

/// One operation on a mask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warp {
    /// What is done.
    pub kind: WarpKind,
    /// The labels that are features.
    pub labels: LabelSet,
}

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WarpKind {
    /// Every feature's width becomes `by` times as much where the transition is 1.
    Scale {
        /// 0 to 16.
        by: f64,
        /// Along which axes.
        along: Axis,
    },
    /// Features grow or shrink by this many pixels where the transition is 1.
    Morph {
        /// Which.
        operation: Operation,
        /// In pixels.
        by: f64,
        /// Along which axes.
        along: Axis,
    },
    /// The features move as [`Motion`] says where the transition is 1 at their centres.
    Move {
        /// How all pixels follow.
        follow: Follow,
        /// How features move.
        motion: Motion,
    },
}

/// How the pixels between features follow them (Gomes 1998).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// By radial basis functions on centres and contour points.
    Radial,
    /// By a mesh of quadrilaterals whose corners follow the features near them.
    Mesh,
    /// By the lines of the contours (Beier and Neely 1992).
    Field,
}

impl Warp {
    /// The mask after the operation. Errors: a mask without features or of features alone, and more features
    /// than radial basis functions can be solved for.
    pub fn apply(&self, mask: &Array2<u8>, transition: &Array2<f32>) -> Result<Array2<u8>> {
        let share = |row: usize, col: usize| f64::from(transition[[row, col]]);
        match self.kind {
            WarpKind::Scale { by, along } => {
                Ok(scaling::scaled(mask, self.labels, along, |row, col| {
                    1.0 + (by - 1.0) * share(row, col)
                }))
            }
            WarpKind::Morph {
                operation,
                by,
                along,
            } => {
                let radius = |row, col| (by * share(row, col)) as f32;
                Ok(morph(mask, operation, (self.labels, along), radius))
            }
            WarpKind::Move { follow, motion } => {
                let moved = Moved::features(&self.features(mask)?, transition, motion);
                let source: Box<dyn Fn(DVec2) -> DVec2> = match follow {
                    Follow::Radial => Box::new(radial::sources(&moved)?),
                    Follow::Mesh => Box::new(mesh::sources(&moved, mask.dim())),
                    Follow::Field => Box::new(field::sources(&moved)),
                };
                Ok(sampled(mask, source))
            }
        }
    }

    fn features(&self, mask: &Array2<u8>) -> Result<MaskFeatures> {
        let features = MaskFeatures::of(mask, self.labels);
        if !features.list.is_empty() && features.owner.iter().any(Option::is_none) {
            return Ok(features);
        }
        let found = match features.list.is_empty() {
            true => format!("no pixel of label {}", self.labels),
            false => format!("every pixel is of label {}", self.labels),
        };
        Err(Error::data("mask", found)
            .expected("features, and something round them")
            .advice("see `mesotex mask`, or name other labels: labels=1+2"))
    }
}

/// The mask at the source (x rightwards, y downwards) of every pixel; beyond the border its nearest pixel.
fn sampled(mask: &Array2<u8>, source: impl Fn(DVec2) -> DVec2) -> Array2<u8> {
    let (height, width) = mask.dim();
    Array2::from_shape_fn((height, width), |(row, col)| {
        let at = source(DVec2::new(col as f64, row as f64));
        let inside = |at: f64, side: usize| (at.round().max(0.0) as usize).min(side - 1);
        mask[[inside(at.y, height), inside(at.x, width)]]
    })
}

impl FromStr for Warp {
    type Err = String;

    /// Reads `KIND:NAME=VALUE,NAME=VALUE`, as `scale:by=0.5,along=horizontal,labels=1+2`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        // Read the values.
        let mut values = Values(Vec::new());
        for part in rest.split(',').filter(|part| !part.is_empty()) {
            let pair = part
                .split_once('=')
                .ok_or_else(|| format!("`{part}`; expected NAME=VALUE"))?;
            values.0.push(pair);
        }
        let labels = values
            .take("labels")
            .map_or(Ok(LabelSet::FEATURES), str::parse)?;
        // Read the kind, and what scaling and morphing need.
        let follow = match kind {
            "scale" => {
                let by = values.number("by", None, 0.0..=LARGEST_SCALE)?;
                let along = values.axis()?;
                return values.finished(Self {
                    kind: WarpKind::Scale { by, along },
                    labels,
                });
            }
            "dilate" | "erode" => {
                let operation = match kind {
                    "dilate" => Operation::Dilate,
                    _ => Operation::Erode,
                };
                let by = values.number("by", None, 0.0..=f64::from(LARGEST_RADIUS))?;
                let along = values.axis()?;
                let kind = WarpKind::Morph {
                    operation,
                    by,
                    along,
                };
                return values.finished(Self { kind, labels });
            }
            "radial" => Follow::Radial,
            "mesh" => Follow::Mesh,
            "field" => Follow::Field,
            _ => {
                let kinds = "scale, dilate, erode, radial, mesh or field";
                return Err(format!("`{kind}`; expected {kinds}"));
            }
        };
        // Read the motion of the others.
        let far = f64::from(LARGEST_RADIUS);
        let motion = Motion {
            scale: values.number("scale", Some(1.0), 0.05..=LARGEST_SCALE)?,
            turn: values.number("turn", Some(0.0), -360.0..=360.0)?,
            right: values.number("right", Some(0.0), -far..=far)?,
            up: values.number("up", Some(0.0), -far..=far)?,
        };
        if motion == Motion::NONE {
            return Err("expected a motion: scale, turn, right or up".into());
        }
        values.finished(Self {
            kind: WarpKind::Move { follow, motion },
            labels,
        })
    }
}

/// Named values that are not used yet.
struct Values<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Values<'a> {
    fn take(&mut self, name: &str) -> Option<&'a str> {
        let at = self.0.iter().position(|(other, _)| *other == name)?;
        Some(self.0.remove(at).1)
    }

    fn number(
        &mut self,
        name: &str,
        default: Option<f64>,
        range: std::ops::RangeInclusive<f64>,
    ) -> std::result::Result<f64, String> {
        let expected = || format!("{name}=NUMBER, {} to {}", range.start(), range.end());
        let Some(text) = self.take(name) else {
            return default.ok_or_else(|| format!("expected {}", expected()));
        };
        let number = text
            .parse::<f64>()
            .ok()
            .filter(|number| range.contains(number));
        number.ok_or_else(|| format!("`{name}={text}`; expected {}", expected()))
    }

    fn axis(&mut self) -> std::result::Result<Axis, String> {
        let Some(name) = self.take("along") else {
            return Ok(Axis::Both);
        };
        <Axis as clap::ValueEnum>::from_str(name, false)
            .map_err(|_| format!("`along={name}`; expected horizontal, vertical or both"))
    }

    fn finished(self, warp: Warp) -> std::result::Result<Warp, String> {
        match self.0.first() {
            None => Ok(warp),
            Some((name, _)) => Err(format!("`{name}` is given twice, or not used by this kind")),
        }
    }
}

#[cfg(test)]
mod tests;
