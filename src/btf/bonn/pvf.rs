//! PVF: a principal component analysis of the images of each view.
//!
//! Body: u32 components, u32 views; per view u8 scalar size, u32 components P, u32 rows of W, u32 dimension, then
//! eigenvalues \[P\], mean \[dimension\], C \[dimension\]\[P\], W \[rows\]\[P\], row-major. The dimension is (light,
//! channel), channel fastest, with a row of W per texel; or it is (texel, channel), with a row of W per light.
//!
//! The older files have in place of the common header the number 301074, u32 components, u32 width, u32 height,
//! u32 views, and the directions.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::{Array2, s};
use rayon::prelude::*;

use crate::btf::bonn::body::Body;
use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::header::{Header, Meta, big_endian, read_size};
use crate::btf::bonn::matrix::{MatrixRows, Sides, StoredMatrix, to_array};
use crate::btf::bonn::output::Output;
use crate::btf::bonn::sampling::Sampling;
use crate::btf::bonn::scalar::Scalar;
use crate::error::{Error, Result};
use crate::matrix::product_of;

/// The number that older files have behind their signature.
pub(super) const LEGACY: u32 = 301_074;

/// Reads a header of the old or the new kind.
pub(super) fn read_header(
    fields: &mut Fields,
    has_rotations: bool,
    notes: &mut Vec<String>,
) -> Result<(Header, u32)> {
    let start = fields.at();
    // Tell the kind of header by its first number.
    let number = fields.u32("header size")?;
    if number.swap_bytes() == LEGACY {
        return Err(big_endian("header size", number));
    }
    if number != LEGACY {
        fields.go_to(start);
        let header = Header::read(fields, has_rotations, notes)?;
        fields.u32("number of components")?;
        let views = fields.u32("number of view slots")?;
        return Ok((header, views));
    }
    // Read the older header, which has fewer fields.
    fields.u32("number of components")?;
    let [width, height] = read_size(fields)?;
    let views = fields.u32("number of view slots")?;
    let header = Header {
        meta: Meta {
            version: 1,
            has_cosine: false,
            ..Meta::default()
        },
        sampling: Sampling::read(fields, notes)?,
        width,
        height,
        rotations: Vec::new(),
    };
    notes.push("the file has the older PVF header, which does not state whether values include the cosine: they are taken without it".into());
    Ok((header, views))
}

/// The components of all views.
pub(super) struct Pvf {
    views: Vec<StoredView>,
    lights: usize,
    texels: usize,
    channels: usize,
    rgb: [usize; 3],
    /// The view that was read last.
    loaded: Mutex<Option<(usize, Arc<View>)>>,
}

/// Where the numbers of a view are.
struct StoredView {
    mean: StoredMatrix,
    components: StoredMatrix,
    weights: StoredMatrix,
}

/// The numbers of a view.
pub struct View {
    /// The mean, \[dimension\].
    pub mean: Vec<f32>,
    /// C, \[dimension\]\[components\].
    pub components: Array2<f32>,
    /// W, \[texels or lights\]\[components\].
    pub weights: Array2<f32>,
}

/// Reads what follows the header; the matrices stay in the file.
pub(super) fn read(fields: &mut Fields, header: &Header, slots: u32) -> Result<Pvf> {
    let rgb = header.meta.rgb_channels()?;
    let views = header.sampling.views.len();
    // Check that there is a slot per view.
    if slots as usize != views {
        return Err(Error::data("number of view slots", slots.to_string())
            .expected(format!("{views}, one per view")));
    }
    let (lights, texels) = (header.sampling.lights.len(), header.texels());
    let channels = header.meta.channels.len();
    // Read each view and check its sides against directions and texels.
    let stored = (0..views)
        .map(|view| {
            let place = format!("view {view}");
            let stored = read_view(fields, &place)?;
            let sides = [stored.components.rows(), stored.weights.rows()];
            let per = |count: usize| count.saturating_mul(channels);
            match sides == [per(lights), texels] || sides == [per(texels), lights] {
                true => Ok(stored),
                false => Err(Error::data(
                    format!("{place}: dimension and rows of weights"),
                    format!("{} and {}", sides[0], sides[1]),
                )
                .expected(format!(
                    "{} and {texels}, or {} and {lights} ({channels} channels, {lights} lights, {texels} texels)",
                    per(lights),
                    per(texels)
                ))),
            }
        })
        .collect::<Result<_>>()?;
    fields.end()?;
    Ok(Pvf {
        views: stored,
        lights,
        texels,
        channels,
        rgb,
        loaded: Mutex::new(None),
    })
}

fn read_view(fields: &mut Fields, place: &str) -> Result<StoredView> {
    let scalar = Scalar::of_size(place, fields.u8(place)?)?;
    let rank = fields.u32(&format!("{place}: components"))?;
    let rows = fields.u32(&format!("{place}: rows of weights"))?;
    let dimension = fields.u32(&format!("{place}: dimension"))?;
    if rank == 0 || dimension == 0 {
        return Err(Error::data(
            format!("{place}: components and dimension"),
            format!("{rank} and {dimension}"),
        )
        .expected("at least 1 each"));
    }
    let size = scalar.size() as u64;
    fields.pass(&format!("{place}: eigenvalues"), Some(rank.into()), size)?;
    let mut next = |name: &str, rows, columns| {
        let sides = Sides {
            rows,
            stored: columns,
            columns,
            scalar,
        };
        StoredMatrix::next(fields, format!("{place}: {name}"), sides)
    };
    Ok(StoredView {
        mean: next("mean", dimension, 1)?,
        components: next("C", dimension, rank)?,
        weights: next("W", rows, rank)?,
    })
}

impl StoredView {
    fn load(&self) -> Result<View> {
        let mut mean = vec![0.0; self.mean.rows()];
        self.mean.read(0..mean.len(), &mut mean)?;
        Ok(View {
            mean,
            components: to_array(&self.components)?,
            weights: to_array(&self.weights)?,
        })
    }
}

impl Pvf {
    /// The numbers of a view; the last one is kept. No work is done in parallel under the lock.
    fn view(&self, view: usize) -> Result<Arc<View>> {
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, numbers)) = loaded.as_ref().filter(|(held, _)| *held == view) {
            return Ok(Arc::clone(numbers));
        }
        *loaded = None;
        let numbers = Arc::new(self.views[view].load()?);
        *loaded = Some((view, Arc::clone(&numbers)));
        Ok(numbers)
    }

    fn read_of_view(&self, view: usize, lights: Range<usize>, out: &mut [f32]) -> Result<()> {
        let numbers = self.view(view)?;
        let per_light = out.par_chunks_mut(self.texels * 3).zip(lights);
        per_light.for_each(|(out, light)| self.decode(&numbers, light, out));
        Ok(())
    }

    /// One image, [texels, RGB].
    fn decode(&self, view: &View, light: usize, out: &mut [f32]) {
        let (out, _) = out.as_chunks_mut::<3>();
        let is_per_texel =
            view.weights.nrows() == self.texels && view.mean.len() == self.channels * self.lights;
        let (values, means) = match is_per_texel {
            true => {
                let rows = light * self.channels..(light + 1) * self.channels;
                let components = view.components.slice(s![rows.clone(), ..]);
                let values = product_of(view.weights.view(), components.t());
                (values, view.mean[rows].repeat(self.texels))
            }
            false => {
                let weights = view.weights.slice(s![light..=light, ..]);
                let values = product_of(view.components.view(), weights.t());
                (values, view.mean.clone())
            }
        };
        let numbers: Vec<f32> = values.iter().zip(means).map(|(v, mean)| v + mean).collect();
        for (out, texel) in out.iter_mut().zip(numbers.chunks(self.channels)) {
            *out = self.rgb.map(|channel| texel[channel]);
        }
    }
}

impl Body for Pvf {
    fn read(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let mut at = images.start;
        let mut rest = out;
        while at < images.end {
            let view = at / self.lights;
            let end = images.end.min((view + 1) * self.lights);
            let (part, later) = rest.split_at_mut((end - at) * self.texels * 3);
            let first = view * self.lights;
            self.read_of_view(view, at - first..end - first, part)?;
            (at, rest) = (end, later);
        }
        Ok(())
    }
}

/// What a PVF file is written from.
pub struct PvfContent<'a> {
    /// All that precedes the body.
    pub header: &'a Header,
    /// Components of each view.
    pub rank: usize,
    /// The numbers of a view, asked for in order.
    pub view: &'a mut dyn FnMut(usize) -> Result<View>,
    /// Their number type.
    pub scalar: Scalar,
    /// Whether the older header is written.
    pub legacy: bool,
}

impl PvfContent<'_> {
    /// Writes everything behind the signature.
    pub(super) fn write(&mut self, output: &mut Output<'_>, has_rotations: bool) -> Result<()> {
        let views = self.header.sampling.views.len();
        if self.legacy {
            let Header { width, height, .. } = self.header;
            for number in [
                LEGACY as usize,
                self.rank,
                *width as usize,
                *height as usize,
                views,
            ] {
                output.u32(number)?;
            }
            self.header.sampling.write(output)?;
        } else {
            self.header.write(output, has_rotations)?;
            output.u32(self.rank)?;
            output.u32(views)?;
        }
        (0..views).try_for_each(|view| self.write_view(output, view))
    }

    fn write_view(&mut self, output: &mut Output<'_>, view: usize) -> Result<()> {
        let numbers = (self.view)(view)?;
        let (weights, components) = (&numbers.weights, &numbers.components);
        output.u8(self.scalar.size() as u8)?;
        for number in [components.ncols(), weights.nrows(), components.nrows()] {
            output.u32(number)?;
        }
        let place = format!("view {view}");
        // With components of length 1 the eigenvalues are the variances of the weights.
        let rows = weights.nrows() as f32;
        let columns = weights.columns().into_iter();
        let variances: Vec<f32> = columns.map(|column| column.dot(&column) / rows).collect();
        output.scalars(self.scalar, &format!("{place}: eigenvalues"), &variances)?;
        output.scalars(self.scalar, &format!("{place}: mean"), &numbers.mean)?;
        output.matrix(self.scalar, &format!("{place}: C"), components)?;
        output.matrix(self.scalar, &format!("{place}: W"), weights)
    }
}
