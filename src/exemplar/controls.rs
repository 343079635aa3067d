//! Controls of an exemplar: what is known of its texels beside their features, by which a method may
//! steer synthesis (Zhang 2003: the mask of the pattern's parts, the transition function, the
//! orientation field).
//!
//! In: arrays of the finest level. Out: the same, checked, on every level.
//! Coarser levels: a mask takes the commonest label of the (up to) four texels, of equally common ones
//! that of the smallest flat index; transitions are averaged; orientations are averaged and made unit
//! vectors again, and where they cancel the texel of the smallest flat index decides.

use std::io;

use ndarray::{Array, Array2, Array3, Dimension, Ix2, Ix3};

use crate::error::{Error, Result};
use crate::format::npz;
use crate::grid::TexelGrid;

/// Labels of a mask are below this.
pub const MASK_LABELS: u8 = 4;
/// How far from 1 the length of an orientation may be.
const UNIT: f32 = 1e-3;
/// A mean of unit vectors shorter than this has no direction.
const NO_DIRECTION: f32 = 1e-3;

/// Which control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlKind {
    /// Labels of the parts of a pattern.
    Mask,
    /// How far a texture that changes has changed.
    Transition,
    /// Which way the pattern runs.
    Orientation,
}

impl ControlKind {
    /// All controls.
    pub const ALL: [Self; 3] = [Self::Mask, Self::Transition, Self::Orientation];

    /// Its name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mask => "mask",
            Self::Transition => "transition",
            Self::Orientation => "orientation",
        }
    }

    /// The option of `mesotex exemplar` that gives it.
    pub fn option(self) -> &'static str {
        match self {
            Self::Mask => "mask",
            Self::Transition => "transition",
            Self::Orientation => "orientation-map",
        }
    }

    fn member(self, level: usize) -> String {
        format!("L{level}/{}", self.name())
    }
}

/// The controls of one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controls {
    /// Labels 0 to 3, [H, W].
    pub mask: Option<Array2<u8>>,
    /// 0 to 1, [H, W].
    pub transition: Option<Array2<f32>>,
    /// Unit vectors (s, t), [H, W, 2].
    pub orientation: Option<Array3<f32>>,
}

impl Controls {
    /// Whether a control is there.
    pub fn has(&self, kind: ControlKind) -> bool {
        match kind {
            ControlKind::Mask => self.mask.is_some(),
            ControlKind::Transition => self.transition.is_some(),
            ControlKind::Orientation => self.orientation.is_some(),
        }
    }

    /// The controls that are there.
    pub fn kinds(&self) -> impl Iterator<Item = ControlKind> {
        ControlKind::ALL.into_iter().filter(|&kind| self.has(kind))
    }

    /// Checks sizes and values against a level of `grid`.
    pub fn check(&self, grid: TexelGrid) -> Result<()> {
        // Check the labels.
        let sides = [grid.height as usize, grid.width as usize];
        if let Some(mask) = &self.mask {
            check_shape("mask", mask, &sides)?;
            let wrong = mask
                .indexed_iter()
                .find(|(_, label)| **label >= MASK_LABELS);
            if let Some(((row, col), label)) = wrong {
                return Err(fault("mask", row, col, format!("label {label}"))
                    .expected(format!("0 to {}", MASK_LABELS - 1)));
            }
        }
        // Check the transition.
        if let Some(transition) = &self.transition {
            check_shape("transition", transition, &sides)?;
            let wrong = transition
                .indexed_iter()
                .find(|(_, value)| !(0.0..=1.0).contains(*value));
            if let Some(((row, col), value)) = wrong {
                return Err(fault("transition", row, col, value.to_string()).expected("0 to 1"));
            }
        }
        // Check the orientation.
        if let Some(orientation) = &self.orientation {
            check_shape("orientation", orientation, &[sides[0], sides[1], 2])?;
            for (at, vector) in orientation.rows().into_iter().enumerate() {
                let (s, t) = (vector[0], vector[1]);
                if !(1.0 - UNIT..=1.0 + UNIT).contains(&s.hypot(t)) {
                    let found = format!("({s}, {t})");
                    return Err(fault("orientation", at / sides[1], at % sides[1], found)
                        .expected("a vector of length 1"));
                }
            }
        }
        Ok(())
    }

    /// The controls of the level above one of `grid`.
    #[must_use]
    pub fn coarser(&self, grid: TexelGrid) -> Self {
        let parents = grid.coarser();
        let sides = (parents.height as usize, parents.width as usize);
        Self {
            mask: self.mask.as_ref().map(|mask| {
                let labels = |at| children(grid, at).map(|(row, col)| mask[[row, col]]);
                Array2::from_shape_fn(sides, |at| commonest(&labels(at).collect::<Vec<_>>()))
            }),
            transition: self.transition.as_ref().map(|values| {
                let of = |at| children(grid, at).map(|(row, col)| values[[row, col]]);
                Array2::from_shape_fn(sides, |at| mean(&of(at).collect::<Vec<_>>()))
            }),
            orientation: self.orientation.as_ref().map(|vectors| {
                let vector = |(row, col)| [vectors[[row, col, 0]], vectors[[row, col, 1]]];
                let mut coarse = Array3::zeros((sides.0, sides.1, 2));
                for (at, mut slot) in coarse.rows_mut().into_iter().enumerate() {
                    let of = children(grid, (at / sides.1, at % sides.1)).map(vector);
                    let [s, t] = mean_direction(&of.collect::<Vec<_>>());
                    (slot[0], slot[1]) = (s, t);
                }
                coarse
            }),
        }
    }

    /// The controls of every level, finest first; none where there are none.
    pub(super) fn pyramid(self, grid: TexelGrid, levels: usize) -> Result<Vec<Self>> {
        if self == Self::default() {
            return Ok(Vec::new());
        }
        self.check(grid)?;
        let (mut all, mut grid) = (vec![self], grid);
        while all.len() < levels {
            let next = all[all.len() - 1].coarser(grid);
            all.push(next);
            grid = grid.coarser();
        }
        Ok(all)
    }

    /// Reads the controls of a level.
    pub(super) fn read(file: &mut npz::Reader, level: usize, grid: TexelGrid) -> Result<Self> {
        for kind in ControlKind::ALL {
            let (finest, here) = (kind.member(0), kind.member(level));
            let (on_finest, is_here) = (file.has(&finest), file.has(&here));
            if on_finest != is_here {
                let (found, expected) = match is_here {
                    true => ("there", format!("none: {finest} is missing")),
                    false => ("missing", format!("an array on every level, as {finest}")),
                };
                return Err(file.fault(&here, found).expected(expected));
            }
        }
        let controls = Self {
            mask: optional::<u8, Ix2>(file, &ControlKind::Mask.member(level))?,
            transition: optional::<f32, Ix2>(file, &ControlKind::Transition.member(level))?,
            orientation: optional::<f32, Ix3>(file, &ControlKind::Orientation.member(level))?,
        };
        let checked = controls.check(grid);
        checked.map_err(|error| file.at(&format!("L{level}"), error))?;
        Ok(controls)
    }

    /// Writes the controls of a level.
    pub(super) fn write(&self, file: &mut npz::Writer<'_>, level: usize) -> io::Result<()> {
        if let Some(mask) = &self.mask {
            file.array(&ControlKind::Mask.member(level), mask.view())?;
        }
        if let Some(transition) = &self.transition {
            file.array(&ControlKind::Transition.member(level), transition.view())?;
        }
        if let Some(orientation) = &self.orientation {
            file.array(&ControlKind::Orientation.member(level), orientation.view())?;
        }
        Ok(())
    }
}

fn optional<T: crate::format::npy::Element, D: Dimension>(
    file: &mut npz::Reader,
    name: &str,
) -> Result<Option<Array<T, D>>> {
    match file.has(name) {
        true => file.array(name).map(Some),
        false => Ok(None),
    }
}

fn check_shape<T, D: Dimension>(name: &str, array: &Array<T, D>, shape: &[usize]) -> Result<()> {
    if array.shape() == shape {
        return Ok(());
    }
    Err(Error::data(name, format!("shape {:?}", array.shape()))
        .expected(format!("{shape:?}, the size of the exemplar")))
}

fn fault(name: &str, row: usize, col: usize, found: String) -> Error {
    Error::data(format!("{name}, row {row}, column {col}"), found)
}

/// Row and column of the texels of a level of `grid` below one (row, column) of the coarser level, by
/// flat index.
fn children(grid: TexelGrid, (row, col): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    let parent = grid.coarser().texel(row as u32, col as u32);
    grid.children(parent).map(move |texel| {
        let (row, col) = grid.row_col(texel);
        (row as usize, col as usize)
    })
}

/// The label most texels have; of equally common ones the first.
fn commonest(labels: &[u8]) -> u8 {
    let count = |label: u8| labels.iter().filter(|&&other| other == label).count();
    let mut best = (0, 0);
    for &label in labels {
        if count(label) > best.1 {
            best = (label, count(label));
        }
    }
    best.0
}

fn mean(values: &[f32]) -> f32 {
    (values.iter().sum::<f32>() / values.len() as f32).clamp(0.0, 1.0)
}

/// The direction of the sum; that of the first vector where they cancel.
fn mean_direction(vectors: &[[f32; 2]]) -> [f32; 2] {
    let sum = |axis: usize| vectors.iter().map(|vector| vector[axis]).sum::<f32>();
    let length = f32::hypot(sum(0), sum(1));
    if length < NO_DIRECTION * vectors.len() as f32 {
        return vectors[0];
    }
    [sum(0) / length, sum(1) / length]
}

#[cfg(test)]
mod tests;
