//! Numbers on the faces of a level.

/// A row of numbers per face, any number of channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceValues {
    /// Numbers per face.
    pub channels: usize,
    /// The rows, face after face.
    pub numbers: Vec<f32>,
}

impl FaceValues {
    /// Zeros.
    pub fn zeros(faces: usize, channels: usize) -> Self {
        Self {
            channels,
            numbers: vec![0.0; faces * channels],
        }
    }

    /// Faces in all.
    pub fn count(&self) -> usize {
        self.numbers.len() / self.channels.max(1)
    }

    /// The numbers of a face.
    #[inline]
    pub fn row(&self, face: usize) -> &[f32] {
        &self.numbers[face * self.channels..][..self.channels]
    }

    /// The numbers of a face.
    #[inline]
    pub fn row_mut(&mut self, face: usize) -> &mut [f32] {
        &mut self.numbers[face * self.channels..][..self.channels]
    }

    /// Adds `share` of others' numbers.
    #[must_use]
    pub fn plus(mut self, share: f32, other: &Self) -> Self {
        for (own, other) in self.numbers.iter_mut().zip(&other.numbers) {
            *own += share * other;
        }
        self
    }
}
