//! Typed indices: the wrong one does not compile.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// A level of a pyramid; 0 is the finest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Level(pub u32);

/// A texel by its flat index, row · width + column, row 0 at the top.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct TexelIndex(pub u32);

/// A texton of a level's vocabulary; [`TextonLabel::NONE`] where there is none.
#[repr(transparent)]
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable, Serialize, Deserialize,
)]
pub struct TextonLabel(pub u16);

impl TextonLabel {
    /// No texton: a vertex in no face, or a map made from a plain image.
    pub const NONE: Self = Self(u16::MAX);
}

macro_rules! as_usize {
    ($($name:ident),*) => {$(
        impl $name {
            /// The index as `usize`, for slices.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}
as_usize!(Level, TexelIndex, TextonLabel);
