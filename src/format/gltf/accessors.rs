//! The numbers that accessors refer to, checked against their buffers first.

use std::borrow::Cow;
use std::rc::Rc;

use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::View;

use crate::error::{Error, Result};

/// The buffers of a file, and how numbers are read from them.
pub(super) struct Accessors<'a> {
    buffers: Vec<Rc<Cow<'a, [u8]>>>,
    /// The most values that one without a buffer may have.
    most: usize,
}

impl<'a> Accessors<'a> {
    pub fn new(buffers: Vec<Rc<Cow<'a, [u8]>>>, most: usize) -> Self {
        Self { buffers, most }
    }

    /// Vectors of floats, or of 8- or 16-bit integers: normalised ones lie in [−1, 1], others are numbers
    /// as they stand (quantised positions). Sparse values are put in.
    pub fn numbers<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>> {
        // Check the type.
        let right = match N {
            2 => Dimensions::Vec2,
            3 => Dimensions::Vec3,
            _ => Dimensions::Vec4,
        };
        let kind = accessor.data_type();
        if kind == DataType::U32 || accessor.dimensions() != right {
            return Err(Error::data(
                format!("accessor {}", accessor.index()),
                format!("{:?} of {kind:?}", accessor.dimensions()),
            )
            .expected(format!("{right:?} of F32, or of 8- or 16-bit integers")));
        }
        // Read the values that the view holds; without one, all are zero.
        let number = number_of(kind, accessor.normalized());
        let size = kind.size();
        let vector = |bytes: &[u8]| std::array::from_fn(|k| number(&bytes[k * size..]));
        let mut vectors: Vec<[f32; N]> = match accessor.view() {
            Some(view) => {
                let items = self.items(
                    accessor,
                    &view,
                    accessor.offset(),
                    size * N,
                    accessor.count(),
                )?;
                items.map(vector).collect()
            }
            None if accessor.sparse().is_some() && accessor.count() <= self.most => {
                vec![[0.0; N]; accessor.count()]
            }
            None => return Err(without_values(accessor)),
        };
        // Put in the sparse values.
        self.put_sparse(accessor, &mut vectors, vector)?;
        Ok(vectors)
    }

    /// Puts the values in that an accessor names one by one.
    fn put_sparse<T>(
        &self,
        accessor: &Accessor<'_>,
        values: &mut [T],
        value: impl Fn(&[u8]) -> T,
    ) -> Result<()> {
        let Some(sparse) = accessor.sparse() else {
            return Ok(());
        };
        let (places, changed, count) = (sparse.indices(), sparse.values(), sparse.count());
        let (width, index) = index_of(places.index_type());
        let places = self.items(accessor, &places.view(), places.offset(), width, count)?;
        let size = accessor.size();
        let changed = self.items(accessor, &changed.view(), changed.offset(), size, count)?;
        let length = values.len();
        for (place, bytes) in places.map(index).zip(changed) {
            let slot = values.get_mut(place as usize).ok_or_else(|| {
                let found = format!("sparse index {place}");
                Error::data(format!("accessor {}", accessor.index()), found)
                    .expected(format!("below {length} values"))
            })?;
            *slot = value(bytes);
        }
        Ok(())
    }

    /// Vertex indices, each below `vertices`.
    pub fn indices(&self, accessor: &Accessor<'_>, vertices: usize) -> Result<Vec<u32>> {
        let (width, index) = match accessor.data_type() {
            DataType::U8 => index_of(IndexType::U8),
            DataType::U16 => index_of(IndexType::U16),
            DataType::U32 => index_of(IndexType::U32),
            other => {
                return Err(
                    Error::data("indices", format!("{other:?}")).expected("unsigned integers")
                );
            }
        };
        let view = accessor.view().ok_or_else(|| without_values(accessor))?;
        let items = self.items(accessor, &view, accessor.offset(), width, accessor.count())?;
        let mut indices: Vec<u32> = items.map(index).collect();
        self.put_sparse(accessor, &mut indices, index)?;
        match indices.iter().find(|&&index| index as usize >= vertices) {
            Some(index) => Err(Error::data("indices", format!("vertex index {index}"))
                .expected(format!("below {vertices} vertices"))),
            None => Ok(indices),
        }
    }

    /// The bytes of each of `count` items of `size` bytes, checked against the buffer first.
    fn items<'b>(
        &'b self,
        accessor: &Accessor<'_>,
        view: &View<'_>,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'b [u8]> + use<'a, 'b>> {
        // Check the stride.
        let fault = |found: &str| Error::data(format!("accessor {}", accessor.index()), found);
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(fault("items that overlap").expected(format!("a stride of {size} or more")));
        }
        // Check that all items lie inside the buffer.
        let whole = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        let bytes = end
            .and_then(|end| whole.get(view.offset()..end))
            .and_then(|bytes| bytes.get(offset..));
        let needed = match count {
            0 => Some(0),
            count => stride
                .checked_mul(count - 1)
                .and_then(|n| n.checked_add(size)),
        };
        match (bytes, needed) {
            (Some(bytes), Some(needed)) if needed <= bytes.len() => {
                Ok((0..count).map(move |item| &bytes[item * stride..item * stride + size]))
            }
            _ => Err(fault("reaches beyond its buffer").expected("values inside the buffer")),
        }
    }
}

fn without_values(accessor: &Accessor<'_>) -> Error {
    Error::data(format!("accessor {}", accessor.index()), "no buffer view").expected("values")
}

/// How one number is read from the bytes that begin with it.
fn number_of(kind: DataType, normalised: bool) -> impl Fn(&[u8]) -> f32 {
    let most = match (normalised, kind) {
        (true, DataType::U8) => 255.0,
        (true, DataType::I8) => 127.0,
        (true, DataType::U16) => 65535.0,
        (true, DataType::I16) => 32767.0,
        _ => 1.0,
    };
    let least = if normalised { -1.0 } else { f32::NEG_INFINITY };
    move |b| match kind {
        DataType::U8 => f32::from(b[0]) / most,
        DataType::I8 => (f32::from(b[0] as i8) / most).max(least),
        DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])) / most,
        DataType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])) / most).max(least),
        DataType::U32 | DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    }
}

/// Bytes of an index, and how it is read.
fn index_of(kind: IndexType) -> (usize, fn(&[u8]) -> u32) {
    match kind {
        IndexType::U8 => (1, |b| u32::from(b[0])),
        IndexType::U16 => (2, |b| u32::from(u16::from_le_bytes([b[0], b[1]]))),
        IndexType::U32 => (4, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
    }
}
