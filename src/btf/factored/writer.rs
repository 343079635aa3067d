//! Writing a factored sample row by row: no array is held whole, the folder appears when done.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::btf::description::{DESCRIPTION, DIRECTIONS, DType, Description, EIGENTEXTURES};
use crate::btf::factored::content_id;
use crate::btf::factored::factorization::Factorization;
use crate::btf::factored::factors::{LARGEST_FACTOR, unsound};
use crate::btf::height_map::HeightMap;
use crate::btf::writer::{begin_array, objection_to_replacing, write_heights};
use crate::error::{Error, Result};
use crate::format::atomic::folder::FolderInProgress;
use crate::format::json;

/// A factored sample under construction. Rows of both arrays come in their order, channel after channel;
/// the arrays may be filled by turns.
#[derive(Debug)]
pub struct FactoredWriter {
    target: PathBuf,
    folder: FolderInProgress,
    description: Description,
    factors: Factorization,
    directions: RowFile,
    eigentextures: RowFile,
    heights: Option<HeightMap>,
}

impl FactoredWriter {
    /// Begins `target`, of layout `factored`; `description.id` is filled in at the end.
    pub fn create(target: &Path, description: Description) -> Result<Self> {
        description.check()?;
        let Some(factors) = description.factors() else {
            return Err(Error::data("layout", "not factored").expected("a rank"));
        };
        let folder = FolderInProgress::create(target, objection_to_replacing)?;
        let (images, texels) = (description.image_count(), description.grid().len());
        let begin = |name, shape| RowFile::begin(&folder, name, shape, description.dtype);
        let directions = begin(DIRECTIONS, factors.directions_shape(images));
        let eigentextures = begin(EIGENTEXTURES, factors.eigentextures_shape(texels));
        Ok(Self {
            target: target.to_path_buf(),
            directions: directions.map_err(Error::io(target, "write"))?,
            eigentextures: eigentextures.map_err(Error::io(target, "write"))?,
            folder,
            description,
            factors,
            heights: None,
        })
    }

    /// Gives the sample heights; they are written in the end.
    pub fn set_heights(&mut self, heights: Option<HeightMap>) {
        self.heights = heights;
    }

    /// Adds rows of `directions.npy`: K numbers per image, image after image, channel after channel.
    pub fn push_directions(&mut self, rows: &[f32]) -> Result<()> {
        self.directions.push(rows, &self.target)
    }

    /// Adds rows of `eigentextures.npy`: K numbers per texel, texel after texel, channel after channel.
    pub fn push_eigentextures(&mut self, rows: &[f32]) -> Result<()> {
        self.eigentextures.push(rows, &self.target)
    }

    /// Writes the description and moves the folder to its place; returns the description.
    pub fn finish(mut self) -> Result<Description> {
        self.directions.finish(&self.target)?;
        self.eigentextures.finish(&self.target)?;
        write_heights(self.heights.as_ref(), &self.description, &self.folder)?;
        let [directions, eigentextures] =
            [DIRECTIONS, EIGENTEXTURES].map(|name| self.folder.member(name));
        self.description.id = content_id::of_files(&directions, &eigentextures, &self.factors)?;
        json::write(&self.folder.member(DESCRIPTION), &self.description)?;
        self.folder.finish()?;
        Ok(self.description)
    }
}

/// An array [channels, rows, K] that grows row by row.
#[derive(Debug)]
struct RowFile {
    name: &'static str,
    shape: Vec<usize>,
    dtype: DType,
    file: BufWriter<File>,
    written: usize,
}

impl RowFile {
    fn begin(
        folder: &FolderInProgress,
        name: &'static str,
        shape: Vec<usize>,
        dtype: DType,
    ) -> std::io::Result<Self> {
        let mut file = BufWriter::with_capacity(1 << 20, File::create(folder.member(name))?);
        file.write_all(&begin_array(dtype, &shape)?)?;
        Ok(Self {
            name,
            shape,
            dtype,
            file,
            written: 0,
        })
    }

    fn length(&self) -> usize {
        self.shape.iter().product()
    }

    fn push(&mut self, rows: &[f32], target: &Path) -> Result<()> {
        let left = self.length() - self.written;
        if !rows.len().is_multiple_of(self.shape[2]) || rows.len() > left {
            return Err(
                Error::data(self.name, format!("{} numbers", rows.len())).expected(format!(
                    "whole rows of {}, at most {left} numbers more",
                    self.shape[2]
                )),
            );
        }
        self.check(rows)
            .map_err(|error| error.in_file(&target.join(self.name)))?;
        let written = match self.dtype {
            DType::F2 => {
                let mut halves = vec![f16::ZERO; rows.len()];
                halves.convert_from_f32_slice(rows);
                self.file.write_all(bytemuck::cast_slice(&halves))
            }
            DType::F4 => self.file.write_all(bytemuck::cast_slice(rows)),
        };
        self.written += rows.len();
        written.map_err(Error::io(target, "write"))
    }

    /// Refuses what no factor can be, or what its number type cannot hold.
    fn check(&self, rows: &[f32]) -> Result<()> {
        let largest = match self.dtype {
            DType::F2 => f16::MAX.to_f32(),
            DType::F4 => LARGEST_FACTOR,
        };
        let sound = |number: &f32| number.abs() <= largest;
        let Some(at) = rows.iter().position(|number| !sound(number)) else {
            return Ok(());
        };
        let fault = unsound(self.written + at, &self.shape, rows[at]);
        Err(match self.dtype {
            DType::F2 => fault
                .expected(format!("numbers from −{largest} to {largest}"))
                .advice("choose --dtype f4 for factors beyond half precision"),
            DType::F4 => fault,
        })
    }

    fn finish(&mut self, target: &Path) -> Result<()> {
        if self.written != self.length() {
            return Err(Error::data(self.name, format!("{} numbers", self.written))
                .expected(self.length().to_string()));
        }
        self.file.flush().map_err(Error::io(target, "write"))
    }
}
