//! Which sites need to choose again: those that read something changed since their last choice. The others would choose
//! the same, and are skipped.

use crate::sites::level::Sites;

/// When each site last changed, in colour classes visited so far.
#[derive(Clone, Debug)]
pub struct Changes {
    /// 0 before the first class.
    last: Vec<u32>,
    now: u32,
    classes: u32,
}

impl Changes {
    /// Nothing has happened yet to sites that are visited in `classes` classes, again and again.
    pub fn new(sites: usize, classes: usize) -> Self {
        Self {
            last: vec![0; sites],
            now: 0,
            classes: classes as u32,
        }
    }

    /// The next class is visited.
    pub fn next_class(&mut self) {
        self.now += 1;
    }

    /// A site of the present class takes another coordinate.
    pub fn changed(&mut self, site: usize) {
        self.last[site] = self.now;
    }

    /// Whether a site of the present class has chosen before, and neither it nor anything it reads
    /// has changed in its last visit or since.
    #[inline]
    pub fn is_settled<const N: usize, S: Sites<N>>(&self, level: &S, site: usize) -> bool {
        let Some(visit) = self
            .now
            .checked_sub(self.classes)
            .filter(|&visit| visit > 0)
        else {
            return false;
        };
        let unchanged = |other: u32| self.last[other as usize] < visit;
        let mut neighbors = level.neighbors(site);
        let mut samples = level.samples(site);
        unchanged(site as u32)
            && neighbors.all(|neighbor| unchanged(neighbor.site))
            && samples.all(|sample| sample.sites().iter().all(|&site| unchanged(site)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Progress;
    use crate::sites::coloring::color_classes;
    use crate::synthesis::tests::fixtures;

    #[test]
    fn a_site_settles_until_something_it_reads_changes() {
        let level = fixtures::random_sites(7, 300, 5);
        let classes = color_classes(&level, Progress::silent()).unwrap();
        let mut changes = Changes::new(300, classes.len());
        for class in &classes {
            changes.next_class();
            assert!(!changes.is_settled(&level, class[0] as usize));
        }
        let (first, read) = (
            classes[0][0] as usize,
            level.neighbors(classes[0][0] as usize).next().unwrap().site,
        );
        changes.next_class();
        assert!(changes.is_settled(&level, first));
        for (index, class) in classes.iter().enumerate() {
            if index > 0 {
                changes.next_class();
            }
            if class.contains(&read) {
                changes.changed(read as usize);
            }
        }
        changes.next_class();
        assert!(!changes.is_settled(&level, first));
    }
}
