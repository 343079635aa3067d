//! Writing a sample image by image: the array is never held whole, the folder appears when done.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::btf::description::{
    ARRAYS, DESCRIPTION, DType, Description, FORMAT, HEIGHTS, Layout, RADIANCE,
};
use crate::btf::height_map::HeightMap;
use crate::error::{Error, Result};
use crate::format::atomic::folder::FolderInProgress;
use crate::format::id::{ContentId, hash_file};
use crate::format::own_folder::OwnFolder;
use crate::format::{json, npy};
use crate::progress::Progress;

/// In an unfinished folder: the description of what is being written there.
const UNFINISHED: &str = "unfinished.json";

/// A sample under construction; images come in order, each checked on the way.
#[derive(Debug)]
pub struct SampleWriter {
    target: PathBuf,
    folder: FolderInProgress,
    description: Description,
    array: BufWriter<File>,
    hasher: blake3::Hasher,
    images_written: usize,
    heights: Option<HeightMap>,
    bytes: Vec<u8>,
}

impl SampleWriter {
    /// Begins `target`; `description.id` is filled in at the end.
    pub fn create(target: &Path, description: Description) -> Result<Self> {
        check(&description)?;
        let folder = FolderInProgress::create(target, objection_to_replacing)?;
        Self::begin(target, folder, description)
    }

    /// Goes on where an interrupted run with the same description stopped, else begins `target`. What
    /// is written stays when the writer is dropped unfinished, until [`discard`](Self::discard).
    pub fn resume(target: &Path, description: Description) -> Result<Self> {
        check(&description)?;
        let folder = FolderInProgress::resumable(target, objection_to_replacing)?;
        let note = folder.member(UNFINISHED);
        let text = serde_json::to_vec_pretty(&description)
            .map_err(|error| Error::data(UNFINISHED, error.to_string()))?;
        let same = fs::read(&note).is_ok_and(|old| old == text);
        if same && folder.member(RADIANCE).is_file() {
            return Self::go_on(target, folder, description);
        }
        folder.discard();
        let folder = FolderInProgress::resumable(target, objection_to_replacing)?;
        if let Err(error) = fs::write(folder.member(UNFINISHED), text) {
            folder.discard();
            return Err(Error::io(target, "write")(error));
        }
        Self::begin(target, folder, description)
    }

    fn begin(target: &Path, folder: FolderInProgress, description: Description) -> Result<Self> {
        let file = match File::create(folder.member(RADIANCE)) {
            Ok(file) => file,
            Err(error) => {
                folder.discard();
                return Err(Error::io(target, "write")(error));
            }
        };
        let bytes = header(&description).map_err(Error::io(target, "write"))?;
        let mut writer = Self::over(target, folder, description, file);
        writer.bytes = bytes;
        writer.write_bytes()?;
        Ok(writer)
    }

    /// Keeps the whole images that are there and hashes them.
    fn go_on(target: &Path, folder: FolderInProgress, description: Description) -> Result<Self> {
        let io = |action| Error::io(target, action);
        let path = folder.member(RADIANCE);
        let header = header(&description).map_err(io("write"))?.len() as u64;
        let numbers = description.grid().len() * description.channels as usize;
        let image = (numbers * description.dtype.size()) as u64;
        let written = fs::metadata(&path).map_err(io("read"))?.len();
        let Some(images) = written.checked_sub(header).map(|length| length / image) else {
            return Self::begin(target, folder, description);
        };
        let images = images.min(description.image_count() as u64);
        let file = OpenOptions::new()
            .append(true)
            .open(&path)
            .map_err(io("write"))?;
        file.set_len(header + images * image).map_err(io("write"))?;
        let mut writer = Self::over(target, folder, description, file);
        hash_file(&mut writer.hasher, &path)?;
        writer.images_written = images as usize;
        Ok(writer)
    }

    fn over(target: &Path, folder: FolderInProgress, description: Description, file: File) -> Self {
        Self {
            target: target.to_path_buf(),
            folder,
            description,
            array: BufWriter::with_capacity(1 << 20, file),
            hasher: blake3::Hasher::new(),
            images_written: 0,
            heights: None,
            bytes: Vec::new(),
        }
    }

    /// Removes what was written.
    pub fn discard(self) {
        self.folder.discard();
    }

    /// How many images are there already.
    pub fn images_written(&self) -> usize {
        self.images_written
    }

    /// What is being written; the id is not known yet.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Gives the sample heights; they are written in the end.
    pub fn set_heights(&mut self, heights: Option<HeightMap>) {
        self.heights = heights;
    }

    /// Adds the next image: row-major (height, width, RGB), linear radiance.
    pub fn push(&mut self, image: &[f32]) -> Result<()> {
        let length = self.description.grid().len() * 3;
        if image.len() != length || self.images_written == self.description.image_count() {
            return Err(Error::data(
                format!("image {}", self.images_written),
                format!("{} numbers", image.len()),
            )
            .expected(format!(
                "{length}, {} times",
                self.description.image_count()
            )));
        }
        self.check(image)?;
        self.bytes.clear();
        match self.description.dtype {
            DType::F2 => {
                let mut halves = vec![f16::ZERO; image.len()];
                halves.convert_from_f32_slice(image);
                self.bytes.extend_from_slice(bytemuck::cast_slice(&halves));
            }
            DType::F4 => self.bytes.extend_from_slice(bytemuck::cast_slice(image)),
        }
        self.images_written += 1;
        self.write_bytes()
    }

    /// Adds all images of a sample of the same texels, lights and number type; its bytes must have the hash that its
    /// description states. `folder` is the sample's.
    pub(super) fn append(
        &mut self,
        folder: &Path,
        sample: &Description,
        progress: Progress<'_>,
    ) -> Result<()> {
        let path = folder.join(RADIANCE);
        let mut file = File::open(&path).map_err(Error::io(&path, "read"))?;
        let mut head = header(sample).map_err(Error::io(&path, "read"))?;
        file.read_exact(&mut head)
            .map_err(Error::io(&path, "read"))?;
        let mut found = blake3::Hasher::new();
        found.update(&head);
        let image = sample.grid().len() * sample.channels as usize * sample.dtype.size();
        for _ in 0..sample.image_count() {
            self.bytes.resize(image, 0);
            file.read_exact(&mut self.bytes)
                .map_err(Error::io(&path, "read"))?;
            found.update_rayon(&self.bytes);
            self.write_bytes()?;
            self.images_written += 1;
            progress.advance(1)?;
        }
        let id = ContentId::of_hash(&found.finalize());
        match id == sample.id {
            true => Ok(()),
            false => Err(Error::data("hash", id.to_string())
                .expected(format!("{}, as {DESCRIPTION} states", sample.id))
                .advice("the file is damaged; make it again")
                .in_file(&path)),
        }
    }

    /// Refuses what no radiance can be, or what its number type cannot hold.
    fn check(&self, image: &[f32]) -> Result<()> {
        let largest = match self.description.dtype {
            DType::F2 => f16::MAX.to_f32(),
            DType::F4 => f32::MAX,
        };
        let Some(at) = image.iter().position(|&v| !(0.0..=largest).contains(&v)) else {
            return Ok(());
        };
        let (view, light) = self.description.view_and_light(self.images_written);
        let (row, col) = (
            at / 3 / self.description.width as usize,
            at / 3 % self.description.width as usize,
        );
        Err(Error::data(
            format!("view {view}, light {light}, row {row}, column {col}"),
            format!("radiance {}", image[at]),
        )
        .expected(format!("0 to {largest}"))
        .advice("choose --dtype f4 for values beyond half precision"))
    }

    fn write_bytes(&mut self) -> Result<()> {
        self.hasher.update(&self.bytes);
        self.array
            .write_all(&self.bytes)
            .map_err(Error::io(&self.target, "write"))
    }

    /// Writes the description and moves the folder to its place; returns the description.
    pub fn finish(mut self) -> Result<Description> {
        if let Err(error) = self.complete() {
            self.folder.discard();
            return Err(error);
        }
        self.folder.finish()?;
        Ok(self.description)
    }

    fn complete(&mut self) -> Result<()> {
        if self.images_written != self.description.image_count() {
            return Err(Error::data("images", self.images_written.to_string())
                .expected(self.description.image_count().to_string()));
        }
        self.array
            .flush()
            .map_err(Error::io(&self.target, "write"))?;
        write_heights(self.heights.as_ref(), &self.description, &self.folder)?;
        self.description.id = ContentId::of_hash(&self.hasher.finalize());
        json::write(&self.folder.member(DESCRIPTION), &self.description)?;
        let note = self.folder.member(UNFINISHED);
        if note.exists() {
            fs::remove_file(&note).map_err(Error::io(&note, "remove"))?;
        }
        Ok(())
    }
}

/// Refuses descriptions that no sample of whole images can have.
fn check(description: &Description) -> Result<()> {
    description.check()?;
    match description.layout {
        Layout::Product | Layout::Pairs => Ok(()),
        Layout::Factored(_) => {
            Err(Error::data("layout", "`factored`").expected("`product` or `pairs`"))
        }
    }
}

/// The folder of a sample.
pub(crate) const SAMPLE_FOLDER: OwnFolder = OwnFolder {
    name: "a sample",
    ending: Some("sample"),
    description: DESCRIPTION,
    format: FORMAT,
    members: &ARRAYS,
};

/// Says why a folder must not be replaced by a sample; `None` where it may.
pub(super) fn objection_to_replacing(folder: &Path) -> std::io::Result<Option<String>> {
    SAMPLE_FOLDER.objection(folder)
}

/// Writes a sample's heights into its folder; one that a killed run left there is not kept.
pub(super) fn write_heights(
    heights: Option<&HeightMap>,
    description: &Description,
    folder: &FolderInProgress,
) -> Result<()> {
    let Some(heights) = heights else {
        let left = folder.member(HEIGHTS);
        return match left.exists() {
            true => fs::remove_file(&left).map_err(Error::io(&left, "remove")),
            false => Ok(()),
        };
    };
    let (own, grid) = (heights.grid(), description.grid());
    match [own.width, own.height] == [grid.width, grid.height] {
        true => heights.write(folder.path()),
        false => Err(
            Error::data("heights", format!("{} × {} texels", own.width, own.height))
                .expected(format!("{} × {}", grid.width, grid.height)),
        ),
    }
}

/// The head of `radiance.npy`.
fn header(description: &Description) -> std::io::Result<Vec<u8>> {
    begin_array(description.dtype, &description.radiance_shape())
}

/// The head of an array of a sample.
pub(super) fn begin_array(dtype: DType, shape: &[usize]) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match dtype {
        DType::F2 => npy::write_header::<f16>(&mut bytes, shape)?,
        DType::F4 => npy::write_header::<f32>(&mut bytes, shape)?,
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;
    use crate::btf::sample::{Sample, VERSION};

    fn description(dtype: DType) -> Description {
        Description {
            format: FORMAT.into(),
            version: VERSION,
            name: "test".into(),
            width: 3,
            height: 2,
            channels: 3,
            dtype,
            texel_mm: None,
            layout: Layout::Product,
            views: vec![Direction::from_angles(0.0, 0.0)],
            lights: vec![
                Direction::from_angles(0.0, 0.0),
                Direction::from_angles(0.5, 1.0),
            ],
            pairs: None,
            tileable: true,
            id: ContentId::of_bytes(b""),
            source: serde_json::Value::Null,
        }
    }

    #[test]
    fn samples_round_trip_and_carry_their_hash() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        for dtype in [DType::F2, DType::F4] {
            let mut writer = SampleWriter::create(&target, description(dtype)).unwrap();
            writer.push(&[0.25; 18]).unwrap();
            writer.push(&[0.5; 18]).unwrap();
            let written = writer.finish().unwrap();
            let sample = Sample::open(&target).unwrap();
            assert_eq!(sample.description(), &written);
            assert_eq!(sample.image(1).unwrap().get(17), 0.5);
            assert_eq!(
                ContentId::of_file(&target.join(RADIANCE)).unwrap(),
                written.id
            );
        }
    }

    #[test]
    fn samples_carry_heights_of_their_own_size() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        let written = |heights: Option<HeightMap>| {
            let mut writer = SampleWriter::create(&target, description(DType::F4)).unwrap();
            writer.set_heights(heights);
            writer.push(&[0.25; 18]).unwrap();
            writer.push(&[0.5; 18]).unwrap();
            writer.finish().map(|description| description.id)
        };
        let grid = description(DType::F4).grid();
        let heights = HeightMap::new(grid, vec![0.5; 6]).unwrap();
        let id = written(Some(heights.clone())).unwrap();
        let sample = Sample::open(&target).unwrap();
        assert_eq!(sample.heights().unwrap(), Some(heights));
        assert_eq!(written(None).unwrap(), id);
        assert_eq!(Sample::open(&target).unwrap().heights().unwrap(), None);
        let small = crate::grid::TexelGrid { width: 2, ..grid };
        let small = HeightMap::new(small, vec![0.0; 4]).unwrap();
        let refused = written(Some(small)).unwrap_err().to_string();
        assert!(refused.contains("2 × 2"), "{refused}");
    }

    #[test]
    fn an_interrupted_sample_goes_on_to_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        let images = [[0.25; 18], [0.5; 18]];
        let mut whole = SampleWriter::create(&target, description(DType::F4)).unwrap();
        images.iter().for_each(|image| whole.push(image).unwrap());
        let wanted = whole.finish().unwrap();
        let mut first = SampleWriter::resume(&target, description(DType::F4)).unwrap();
        first.push(&images[0]).unwrap();
        drop(first);
        // A torn write at the end of the file is cut off.
        let partial = folder.path().join(".x.sample.partial").join(RADIANCE);
        let mut bytes = fs::read(&partial).unwrap();
        bytes.extend([7; 5]);
        fs::write(&partial, bytes).unwrap();
        let mut second = SampleWriter::resume(&target, description(DType::F4)).unwrap();
        assert_eq!(second.images_written(), 1);
        second.push(&images[1]).unwrap();
        assert_eq!(second.finish().unwrap(), wanted);
        assert_eq!(Sample::open(&target).unwrap().image(1).unwrap().get(3), 0.5);
        // Another description starts anew; discarding leaves nothing.
        drop(SampleWriter::resume(&target, description(DType::F4)).unwrap());
        let other = SampleWriter::resume(&target, description(DType::F2)).unwrap();
        assert_eq!(other.images_written(), 0);
        other.discard();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn only_samples_and_empty_folders_are_replaced() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("x.sample");
        let refused = || {
            let refused = SampleWriter::create(&target, description(DType::F4));
            refused.map(drop).map_err(|error| error.to_string())
        };
        fs::create_dir(&target).unwrap();
        refused().unwrap();
        fs::write(target.join(DESCRIPTION), "{\"format\": \"recipes\"}").unwrap();
        assert!(refused().unwrap_err().contains("without a btf.json"));
        fs::write(
            target.join(DESCRIPTION),
            "{\"format\": \"mesotex-btf\", \"version\": 9}",
        )
        .unwrap();
        refused().unwrap();
        fs::write(target.join("notes.txt"), "mine").unwrap();
        assert!(refused().unwrap_err().contains("`notes.txt`"));
        assert_eq!(fs::read(target.join("notes.txt")).unwrap(), b"mine");
    }

    #[test]
    fn impossible_radiance_is_refused_by_place() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        let mut writer = SampleWriter::create(&target, description(DType::F2)).unwrap();
        let mut image = vec![0.1; 18];
        for (bad, says) in [(f32::NAN, "NaN"), (-1.0, "-1"), (1e6, "f4")] {
            image[13] = bad;
            let error = writer.push(&image).unwrap_err().to_string();
            assert!(
                error.contains("row 1, column 1") && error.contains(says),
                "{error}"
            );
        }
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn numbers_that_do_not_match_the_description_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        let mut writer = SampleWriter::create(&target, description(DType::F2)).unwrap();
        writer.push(&[0.0; 18]).unwrap();
        writer.push(&[0.0; 18]).unwrap();
        let mut wrong = writer.finish().unwrap();
        wrong.width = 4;
        json::write(&target.join(DESCRIPTION), &wrong).unwrap();
        let error = Sample::open(&target).unwrap_err().to_string();
        assert!(
            error.contains("radiance.npy") && error.contains("[1, 2, 2, 4, 3]"),
            "{error}"
        );
        wrong.lights.clear();
        json::write(&target.join(DESCRIPTION), &wrong).unwrap();
        assert!(
            Sample::open(&target)
                .unwrap_err()
                .to_string()
                .contains("lights: 0")
        );
    }
}
