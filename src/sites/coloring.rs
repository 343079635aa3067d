//! Colour classes: sites of one class read nothing of each other, so that they can be refined
//! together, and the result is that of visiting class after class, site after site.

use crate::error::Result;
use crate::progress::Progress;
use crate::sites::level::Sites;

/// Sites coloured from one look at whether to stop to the next.
const SITES_BETWEEN_CHECKS: usize = 1 << 12;

/// The classes of a level, each its sites ascending.
///
/// The sites of a mesh are coloured greedily in their order, each with the first colour that neither a
/// site it reads nor one that reads it has; those of a flat grid, where samples and neighbours fill the
/// same window, by their rows and columns.
pub fn color_classes<const N: usize, S: Sites<N>>(
    level: &S,
    progress: Progress<'_>,
) -> Result<Vec<Vec<u32>>> {
    if let Some(colors) = level.known_colors() {
        return Ok(classes(&colors));
    }
    let mut words = 2;
    loop {
        if let Some(colors) = greedy_colors(level, words, progress)? {
            return Ok(classes(&colors));
        }
        words *= 2;
    }
}

/// The colours of all sites, `None` when 64 · `words` are too few.
fn greedy_colors<const N: usize, S: Sites<N>>(
    level: &S,
    words: usize,
    progress: Progress<'_>,
) -> Result<Option<Vec<u32>>> {
    const UNCOLORED: u32 = u32::MAX;
    let mut colors = vec![UNCOLORED; level.count()];
    let mut taken = vec![0u64; level.count() * words];
    let (mut near, mut seen) = (Vec::new(), vec![UNCOLORED; level.count()]);
    for site in 0..level.count() {
        if site.is_multiple_of(SITES_BETWEEN_CHECKS) {
            progress.check()?;
        }
        // Mark the colours of all sites that this one reads or is read by.
        collect_read(level, site, &mut near, &mut seen);
        let own = &mut taken[site * words..][..words];
        for &other in &near {
            let color = colors[other as usize];
            if color != UNCOLORED {
                own[color as usize / 64] |= 1 << (color % 64);
            }
        }
        // Take the first free one.
        let Some(color) = first_free(own) else {
            return Ok(None);
        };
        colors[site] = color;
        for &other in &near {
            taken[other as usize * words + color as usize / 64] |= 1 << (color % 64);
        }
    }
    Ok(Some(colors))
}

fn first_free(taken: &[u64]) -> Option<u32> {
    let word = taken.iter().position(|&word| word != u64::MAX)?;
    Some(64 * word as u32 + taken[word].trailing_ones())
}

/// The other sites that choosing at `site` reads, on its level, each once; `seen` tells for which site
/// each was read last.
fn collect_read<const N: usize, S: Sites<N>>(
    level: &S,
    site: usize,
    read: &mut Vec<u32>,
    seen: &mut [u32],
) {
    read.clear();
    seen[site] = site as u32;
    let mut see = |other: u32| {
        if std::mem::replace(&mut seen[other as usize], site as u32) != site as u32 {
            read.push(other);
        }
    };
    let neighbors = level.neighbors(site);
    neighbors.for_each(|neighbor| see(neighbor.site));
    let samples = level.samples(site);
    samples.for_each(|sample| sample.sites().iter().copied().for_each(&mut see));
}

fn classes(colors: &[u32]) -> Vec<Vec<u32>> {
    let count = colors.iter().max().map_or(0, |&most| most as usize + 1);
    let mut classes = vec![Vec::new(); count];
    for (site, &color) in colors.iter().enumerate() {
        classes[color as usize].push(site as u32);
    }
    classes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::Neighborhood;
    use crate::sites::grid::window::SiteGrid;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn no_site_reads_another_of_its_class() {
        let level = fixtures::random_sites(7, 300, 5);
        let classes = color_classes(&level, Progress::silent()).unwrap();
        let total: usize = classes.iter().map(Vec::len).sum();
        assert_eq!(total, 300);
        let mut color = [0; 300];
        for (index, class) in classes.iter().enumerate() {
            assert!(class.is_sorted());
            for &site in class {
                color[site as usize] = index;
            }
        }
        let (mut read, mut seen) = (Vec::new(), vec![u32::MAX; 300]);
        for site in 0..300 {
            collect_read(&level, site, &mut read, &mut seen);
            assert!(!read.is_empty());
            assert!(read.iter().all(|&other| other as usize != site));
            assert!(
                read.iter()
                    .all(|&other| color[other as usize] != color[site])
            );
        }
    }

    #[test]
    fn no_site_of_a_grid_reads_another_of_its_class() {
        let grid = SiteGrid {
            width: 18,
            height: 10,
            toroidal: true,
        };
        let neighborhoods = [Neighborhood::square(5, 3), Neighborhood::square(5, 0)];
        let level = &grid.hierarchy(&neighborhoods).unwrap().levels[0];
        let (mut read, mut seen) = (Vec::new(), vec![u32::MAX; 180]);
        let classes = color_classes(level, Progress::silent()).unwrap();
        assert_eq!(classes.iter().map(Vec::len).sum::<usize>(), 180);
        for class in classes {
            for &site in &class {
                collect_read(level, site as usize, &mut read, &mut seen);
                assert!(read.len() == 24 && read.iter().all(|other| !class.contains(other)));
            }
        }
    }

    #[test]
    fn more_colors_than_a_word_has() {
        // Everyone reads everyone.
        let level = fixtures::random_sites(1, 150, 149);
        assert_eq!(
            color_classes(&level, Progress::silent()).unwrap().len(),
            150
        );
    }
}
