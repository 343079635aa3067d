//! `.npy` arrays, as `numpy.load` opens them: C order, little endian, checked against the file's
//! length before anything is allocated. Big arrays are read in parts ([`ArrayFile`]).

use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::Path;

use bytemuck::Pod;
use ndarray::{ArrayD, ArrayViewD, IxDyn};
use npyz::{DType, NpyHeader, Order, WriterBuilder};

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;
use crate::format::positioned::PositionedFile;

/// A number type that arrays of this project hold.
pub trait Element: Pod + npyz::AutoSerialize + Send + Sync {
    /// numpy's name of the type, as `<f4`.
    const DTYPE: &'static str;
}

macro_rules! elements {
    ($($name:ty => $dtype:literal),* $(,)?) => {$(
        impl Element for $name {
            const DTYPE: &'static str = $dtype;
        }
    )*};
}
elements!(f32 => "<f4", f64 => "<f8", half::f16 => "<f2", u8 => "|u1", u16 => "<u2", u32 => "<u4",
    i32 => "<i4");

/// What an array file says of itself, checked against its length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// numpy's name of the number type, as `<f4`.
    pub dtype: String,
    /// Sides of the array, slowest first.
    pub shape: Vec<usize>,
    /// Where the numbers begin, in bytes.
    pub data_offset: usize,
}

impl Header {
    /// Refuses another number type than `T`.
    pub fn expect<T: Element>(&self) -> Result<()> {
        if self.dtype == T::DTYPE {
            return Ok(());
        }
        let numpy_name = T::DTYPE.trim_start_matches('|');
        Err(Error::data("dtype", format!("`{}`", self.dtype))
            .expected(format!("`{}`", T::DTYPE))
            .advice(format!("convert it in numpy: a.astype(\"{numpy_name}\")")))
    }
}

/// Reads the header at the start of `bytes`, the beginning of a file of `file_length` bytes, and
/// checks that the file holds just the numbers it promises.
pub fn parse_header(bytes: &[u8], file_length: u64) -> Result<Header> {
    // Read the header.
    check_brackets(header_text(bytes)?)?;
    let mut rest = bytes;
    let header = NpyHeader::from_reader(&mut rest).map_err(|error| {
        Error::data("npy header", error.to_string()).expected("a file written by numpy.save")
    })?;
    let data_offset = bytes.len() - rest.len();
    // Refuse what is stored in another way.
    if header.order() == Order::Fortran {
        return Err(Error::data("npy header", "the array is in Fortran order")
            .expected("C order")
            .advice("save it again in numpy: numpy.save(path, numpy.ascontiguousarray(a))"));
    }
    let DType::Plain(scalar) = header.dtype() else {
        return Err(Error::data("dtype", header.dtype().descr()).expected("one plain number type"));
    };
    // Compare the length with the shape.
    let shape: Option<Vec<usize>> = header
        .shape()
        .iter()
        .map(|&side| usize::try_from(side).ok())
        .collect();
    let promised = header
        .shape()
        .iter()
        .try_fold(scalar.num_bytes().unwrap_or(0) as u64, |n, &side| {
            n.checked_mul(side)
        });
    let held = file_length - data_offset as u64;
    match (shape, promised) {
        (Some(shape), Some(promised)) if promised == held => Ok(Header {
            dtype: scalar.to_string(),
            shape,
            data_offset,
        }),
        _ => Err(Error::data(
            format!("shape {:?} of `{scalar}`", header.shape()),
            format!("{held} bytes of numbers"),
        )
        .expected(promised.map_or("fewer than 2^64 bytes".into(), |n| format!("{n} bytes")))
        .advice("the file is truncated, or was written for another shape")),
    }
}

/// The description in a header. One whose length goes beyond the bytes at hand is refused before it is
/// allocated.
fn header_text(bytes: &[u8]) -> Result<&[u8]> {
    let (rest, length) = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, rest @ ..] => {
            (rest, u32::from(u16::from_le_bytes([*a, *b])))
        }
        [
            0x93,
            b'N',
            b'U',
            b'M',
            b'P',
            b'Y',
            2 | 3,
            _,
            a,
            b,
            c,
            d,
            rest @ ..,
        ] => (rest, u32::from_le_bytes([*a, *b, *c, *d])),
        _ => {
            return Err(Error::data("npy header", "no `\\x93NUMPY` at the start")
                .expected("a file written by numpy.save"));
        }
    };
    rest.get(..length as usize).ok_or_else(|| {
        Error::data("npy header", format!("it claims {length} bytes"))
            .expected(format!("at most {}", rest.len()))
    })
}

/// Refuses brackets within brackets: the parser of headers takes twice the time for each pair. An array of
/// plain numbers has those of the description and those of the shape.
fn check_brackets(text: &[u8]) -> Result<()> {
    let opening = text.iter().filter(|byte| b"([{".contains(byte)).count();
    match opening {
        0..=2 => Ok(()),
        _ => Err(
            Error::data("npy header", format!("{opening} opening brackets"))
                .expected("at most 2: one plain number type, and one shape"),
        ),
    }
}

/// The array in `bytes`, a whole `.npy` file.
pub fn decode<T: Element>(bytes: &[u8]) -> Result<ArrayD<T>> {
    let header = parse_header(bytes, bytes.len() as u64)?;
    header.expect::<T>()?;
    let numbers = bytemuck::pod_collect_to_vec(&bytes[header.data_offset..]);
    ArrayD::from_shape_vec(IxDyn(&header.shape), numbers)
        .map_err(|error| Error::data("shape", error.to_string()))
}

/// Reads a whole array file.
pub fn read<T: Element>(path: &Path) -> Result<ArrayD<T>> {
    let bytes = std::fs::read(path).map_err(Error::io(path, "read"))?;
    guarded(path, || decode(&bytes))
}

/// Writes the header of an array of `T` with these sides.
pub fn write_header<T: Element>(sink: &mut impl Write, shape: &[usize]) -> io::Result<()> {
    let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
    let dtype = DType::Plain(T::DTYPE.parse().map_err(io::Error::other)?);
    npyz::WriteOptions::new_header_only()
        .dtype(dtype)
        .shape(&shape)
        .writer(sink)
        .write_header_only()?;
    Ok(())
}

/// Writes header and numbers of an array.
pub fn encode<T: Element>(sink: &mut impl Write, array: ArrayViewD<'_, T>) -> io::Result<()> {
    write_header::<T>(sink, array.shape())?;
    let array = array.as_standard_layout();
    let numbers = array
        .as_slice()
        .ok_or_else(|| io::Error::other("not in C order"))?;
    sink.write_all(bytemuck::cast_slice(numbers))
}

/// Writes a whole array file.
pub fn write<T: Element>(path: &Path, array: ArrayViewD<'_, T>) -> Result<()> {
    atomic::write_file(path, |sink| encode(sink, array))
}

/// Reads the header of a file without its numbers.
pub fn read_header(path: &Path) -> Result<Header> {
    header_of(&PositionedFile::open(path)?)
}

/// Bytes read to find a header.
const HEADER: u64 = 1 << 16;

fn header_of(file: &PositionedFile) -> Result<Header> {
    let mut start = vec![0; HEADER.min(file.length()) as usize];
    file.read_at(0, &mut start)?;
    guarded(file.path(), || parse_header(&start, file.length()))
}

/// An array file open for reading in parts.
#[derive(Debug)]
pub struct ArrayFile<T> {
    file: PositionedFile,
    header: Header,
    element: PhantomData<T>,
}

impl<T: Element> ArrayFile<T> {
    /// Opens an array file of `T`.
    pub fn open(path: &Path) -> Result<Self> {
        let file = PositionedFile::open(path)?;
        let header = header_of(&file)?;
        header.expect::<T>().map_err(|error| error.in_file(path))?;
        Ok(Self {
            file,
            header,
            element: PhantomData,
        })
    }

    /// Sides of the array, slowest first.
    pub fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    /// The file's name.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Fills `numbers` from number `first` on, in C order.
    pub fn read(&self, first: usize, numbers: &mut [T]) -> Result<()> {
        let at = self.header.data_offset + first * size_of::<T>();
        self.file
            .read_at(at as u64, bytemuck::cast_slice_mut(numbers))
    }

    /// Tells the system that `count` numbers from number `first` on will be read soon.
    pub fn announce(&self, first: usize, count: usize) {
        let at = self.header.data_offset + first * size_of::<T>();
        self.file
            .announce(at as u64, (count * size_of::<T>()) as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    fn bytes_of(array: &Array2<f32>) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, array.view().into_dyn()).unwrap();
        bytes
    }

    #[test]
    fn arrays_round_trip_whole_and_in_parts() {
        let array = Array2::from_shape_fn((3, 5), |(r, c)| (r * 5 + c) as f32);
        let bytes = bytes_of(&array);
        assert_eq!(decode::<f32>(&bytes).unwrap(), array.clone().into_dyn());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        write(&path, array.view().into_dyn()).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
        let file = ArrayFile::<f32>::open(&path).unwrap();
        assert_eq!(file.shape(), [3, 5]);
        let mut part = [0.0; 2];
        file.read(7, &mut part).unwrap();
        assert_eq!(part, [7.0, 8.0]);
    }

    #[test]
    fn a_transposed_view_is_written_in_c_order() {
        let array = Array2::from_shape_fn((2, 3), |(r, c)| (r * 3 + c) as f32);
        let mut bytes = Vec::new();
        encode(&mut bytes, array.t().into_dyn()).unwrap();
        assert_eq!(
            decode::<f32>(&bytes).unwrap(),
            array.t().to_owned().into_dyn()
        );
    }

    #[test]
    fn foreign_arrays_are_refused_with_a_reason() {
        let good = bytes_of(&Array2::zeros((2, 2)));
        let edit = |from: &str, to: &str| {
            let text: Vec<u8> = good.clone();
            let at = text
                .windows(from.len())
                .position(|w| w == from.as_bytes())
                .unwrap();
            let mut text = text;
            text[at..at + from.len()].copy_from_slice(to.as_bytes());
            decode::<f32>(&text).unwrap_err().to_string()
        };
        assert!(edit("'<f4'", "'>f4'").contains(">f4"));
        assert!(edit("'<f4'", "'<i4'").contains("<i4"));
        assert!(edit("False", "True ").contains("Fortran"));
        assert!(edit("(2, 2,", "(2, 9,").contains("72 bytes"));
        let cut = decode::<f32>(&good[..good.len() - 1]).unwrap_err();
        assert!(cut.to_string().contains("truncated"));
        assert!(
            decode::<f32>(b"PK\x03\x04")
                .unwrap_err()
                .to_string()
                .contains("NUMPY")
        );
        let mut huge = good.clone();
        huge[6] = 2;
        huge[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(
            decode::<f32>(&huge)
                .unwrap_err()
                .to_string()
                .contains("claims")
        );
    }

    /// Thirty of them took the parser half a minute.
    #[test]
    fn nested_brackets_are_refused_at_once() {
        let mut bytes = bytes_of(&Array2::zeros((2, 2)));
        let shape = bytes.iter().position(|&byte| byte == b'(').unwrap();
        bytes[shape..shape + 40].fill(b'[');
        let refused = decode::<f32>(&bytes).unwrap_err().to_string();
        assert!(refused.contains("41 opening brackets"), "{refused}");
    }

    #[test]
    fn a_shape_beyond_all_memory_is_refused() {
        let mut bytes = Vec::new();
        write_header::<f32>(&mut bytes, &[usize::MAX, 4]).unwrap();
        assert!(decode::<f32>(&bytes).is_err());
    }
}
