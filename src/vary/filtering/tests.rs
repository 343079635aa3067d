//! Filtering of tiny textures.

use ndarray::Array3;
use rand::Rng;

use super::*;
use crate::index::TexelIndex;
use crate::random;

fn grid(width: u32, height: u32, tileable: bool) -> TexelGrid {
    TexelGrid {
        width,
        height,
        tileable,
    }
}

/// Random colours and a random mask of a few labels.
fn random_texture(grid: TexelGrid, labels: u8) -> (Array3<f32>, Array2<u8>) {
    let mut stream = random::stream(17, "texture", 0, 0);
    let sides = (grid.height as usize, grid.width as usize);
    let mask = Array2::from_shape_fn(sides, |_| stream.gen_range(0..labels));
    let color = |_| stream.gen_range(0.0..1.0);
    let numbers = Array3::from_shape_fn((sides.0, sides.1, 3), color);
    (numbers, mask)
}

fn few() -> FilterOptions {
    FilterOptions {
        mask_window: 5,
        color_window: 3,
        filter_levels: 2,
        ..FilterOptions::default()
    }
}

fn one<'a>(texture: &'a Texture<'a>, mask: &'a Array2<u8>) -> Filtering<'a> {
    Filtering {
        sources: std::slice::from_ref(texture),
        mask: Some(mask),
        shares: None,
        output: mask.dim(),
    }
}

#[test]
fn with_its_own_mask_a_texture_comes_back() {
    for (tileable, labels) in [(true, 2), (false, 2), (false, 3)] {
        let grid = grid(18, 16, tileable);
        let (numbers, mask) = random_texture(grid, labels);
        let texture = Texture {
            grid,
            numbers: &numbers,
            mask: &mask,
        };
        let found = filter(one(&texture, &mask), &few(), Progress::silent()).unwrap();
        assert!(
            found[0].iter().copied().eq(0..18 * 16),
            "{tileable} {labels}"
        );
    }
}

#[test]
fn a_moved_mask_moves_its_texture() {
    let grid = grid(16, 16, true);
    let (numbers, mask) = random_texture(grid, 2);
    let texture = Texture {
        grid,
        numbers: &numbers,
        mask: &mask,
    };
    let moved = Array2::from_shape_fn((16, 16), |(row, col)| {
        mask[[(row + 4) % 16, (col + 6) % 16]]
    });
    let found = filter(one(&texture, &moved), &few(), Progress::silent()).unwrap();
    // Away from the open border of the output everything is the texture's, moved.
    for row in 3..13 {
        for col in 3..13 {
            let expected = ((row + 4) % 16) * 16 + (col + 6) % 16;
            assert_eq!(found[0][row * 16 + col] as usize, expected, "{row} {col}");
        }
    }
}

#[test]
fn every_pixel_takes_a_label_of_the_mask() {
    // Colour says the label: bright is 1.
    let grid = grid(16, 16, false);
    let (mut numbers, _) = random_texture(grid, 2);
    let mask = Array2::from_shape_fn((16, 16), |(row, col)| {
        u8::from(((row + 2) / 4 + col / 4) % 2 == 0)
    });
    for ((row, col, _), number) in numbers.indexed_iter_mut() {
        *number = 0.1 * *number + 0.8 * f32::from(mask[[row, col]]);
    }
    let texture = Texture {
        grid,
        numbers: &numbers,
        mask: &mask,
    };
    let wanted = Array2::from_shape_fn((12, 20), |(row, col)| {
        u8::from((row / 4 + col / 4) % 2 == 0)
    });
    let options = FilterOptions {
        mask_weight: 20.0,
        mask_window: 3,
        ..few()
    };
    let found = filter(one(&texture, &wanted), &options, Progress::silent()).unwrap();
    let labels = found[0]
        .iter()
        .map(|&texel| mask[[texel as usize / 16, texel as usize % 16]]);
    assert!(labels.eq(wanted.iter().copied()));
}

#[test]
fn the_waves_see_what_scan_lines_see() {
    for reach in [0, 1, 3] {
        let grid = grid(7, 5, false);
        let waves = waves(grid, reach);
        let mut visit = [0; 35];
        for (at, wave) in waves.iter().enumerate() {
            wave.iter().for_each(|&pixel| visit[pixel as usize] = at);
        }
        let reach = reach as i32;
        for pixel in (0..35).map(TexelIndex) {
            for drow in -reach..=reach {
                for dcol in -reach..=reach {
                    let Some(near) = grid.offset(pixel, drow, dcol) else {
                        continue;
                    };
                    let before = drow < 0 || (drow == 0 && dcol < 0);
                    if before {
                        assert!(visit[near.index()] < visit[pixel.index()]);
                    }
                }
            }
        }
    }
}

#[test]
fn threads_do_not_count() {
    let grid = grid(20, 16, false);
    let (numbers, mask) = random_texture(grid, 2);
    let texture = Texture {
        grid,
        numbers: &numbers,
        mask: &mask,
    };
    let wanted = Array2::from_shape_fn((16, 24), |(row, col)| u8::from(row * col % 5 < 2));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| filter(one(&texture, &wanted), &few(), Progress::silent()).unwrap())
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn mixed_sources_are_blended_as_they_grow() {
    let grid = grid(16, 16, false);
    let (dark, bright) = (Array3::zeros((16, 16, 1)), Array3::ones((16, 16, 1)));
    let mask = Array2::zeros((16, 16));
    let sources = [&dark, &bright].map(|numbers| Texture {
        grid,
        numbers,
        mask: &mask,
    });
    let shares = Array2::from_elem((8, 12), 0.25);
    let work = Filtering {
        sources: &sources,
        mask: None,
        shares: Some(&shares),
        output: (8, 12),
    };
    let found = filter(work, &few(), Progress::silent()).unwrap();
    assert_eq!((found.len(), found[1].len()), (2, 96));
    let alone = Filtering {
        shares: None,
        ..work
    };
    let said = filter(alone, &few(), Progress::silent())
        .unwrap_err()
        .to_string();
    assert!(said.contains("sources: 2; expected 1"), "{said}");
}

#[test]
fn sizes_are_checked_first() {
    let grid = grid(16, 16, false);
    let (numbers, mask) = random_texture(grid, 2);
    let texture = Texture {
        grid,
        numbers: &numbers,
        mask: &mask,
    };
    let huge = Filtering {
        output: (usize::MAX, 3),
        ..one(&texture, &mask)
    };
    let said = filter(huge, &few(), Progress::silent())
        .unwrap_err()
        .to_string();
    assert!(said.contains("1 to 4194304 pixels"), "{said}");
    let narrow = Array2::zeros((16, 15));
    let wrong = Texture {
        mask: &narrow,
        ..texture
    };
    let said = filter(one(&wrong, &mask), &few(), Progress::silent())
        .unwrap_err()
        .to_string();
    assert!(said.contains("mask: 15×16; expected 16×16"), "{said}");
    let even = FilterOptions {
        mask_window: 4,
        ..few()
    };
    assert!(filter(one(&texture, &mask), &even, Progress::silent()).is_err());
}
