//! Numbers that begin at a cache line of the processor, so that SIMD lanes do not cross lines.
//!
//! In: their number. Out: a slice to fill.

use bytemuck::{Pod, Zeroable};

/// A line of the cache.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Line([f32; 16]);

/// A buffer that is used again and again.
#[derive(Clone, Debug, Default)]
pub struct AlignedNumbers(Vec<Line>);

impl AlignedNumbers {
    /// `length` numbers, whatever they were before.
    pub fn of_length(&mut self, length: usize) -> &mut [f32] {
        let lines = length.div_ceil(16);
        if lines > self.0.len() {
            self.0.resize(lines, Line([0.0; 16]));
        }
        &mut bytemuck::cast_slice_mut(&mut self.0)[..length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_begin_at_a_line_and_are_as_many_as_asked_for() {
        let mut numbers = AlignedNumbers::default();
        for length in [1, 16, 1000, 7] {
            let slice = numbers.of_length(length);
            assert_eq!(slice.len(), length);
            assert!(slice.as_ptr().addr().is_multiple_of(64));
        }
    }
}
