//! Numbers that are worked on side by side, one per lane, in loops that the compiler turns into vector instructions.

use macro_rules_attribute::attribute_alias;

attribute_alias! {
    // Compiles a function for AVX-512, for AVX2, for NEON and for any processor; each call takes the best that the
    // machine has.
    #[apply(vectorized!)] = #[multiversion::multiversion(targets(
        "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi1+bmi2",
        "x86_64+avx2+fma+bmi1+bmi2",
        "aarch64+neon"
    ))];
}

/// Lanes: numbers of 32 bits in one register of AVX-512, two of AVX2 or four of NEON.
pub const LANES: usize = 16;

/// One number per lane.
pub type LaneBlock = [f32; LANES];

/// The sum of all lanes, not inlined, so that the loops that fill the block keep it in whole vectors.
#[inline(never)]
pub fn sum_apart(lanes: &LaneBlock) -> f32 {
    sum_of_lanes(*lanes)
}

/// The sum of all lanes, as a tree.
#[inline(always)]
pub fn sum_of_lanes(lanes: LaneBlock) -> f32 {
    let (mut eight, mut four) = ([0.0; 8], [0.0; 4]);
    for lane in 0..8 {
        eight[lane] = lanes[lane] + lanes[lane + 8];
    }
    for lane in 0..4 {
        four[lane] = eight[lane] + eight[lane + 4];
    }
    (four[0] + four[2]) + (four[1] + four[3])
}

/// The smallest of all lanes, none of them NaN.
#[inline(always)]
pub fn least_of_lanes(mut lanes: LaneBlock) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = smaller(lanes[lane], lanes[lane + half]);
        }
        half /= 2;
    }
    lanes[0]
}

/// The smaller of two numbers, neither of them NaN, in one instruction.
#[inline(always)]
pub fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_summed_and_compared() {
        let lanes: LaneBlock = std::array::from_fn(|lane| ((lane * 7 + 3) % LANES) as f32);
        assert_eq!(sum_of_lanes(lanes), 120.0);
        assert_eq!(sum_apart(&lanes), 120.0);
        assert_eq!(least_of_lanes(lanes), 0.0);
    }
}
