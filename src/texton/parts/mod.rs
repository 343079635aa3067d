//! Parts of a texton analysis, `PART.npz`: what the images of one shard contribute, and how parts are joined.
//!
//! In: a study and a shard, or the parts of all shards. Out: a file, or what the whole analysis would have made of
//! all images. Where images are chosen, a part holds the appearance vectors of its images; where all are taken,
//! the dot products of its blocks of images. Both are written as they are made. What they hold is the same
//! numbers that one run works with, bit for bit, whatever the number of shards.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`work`] | what is shared, and how |
//! | [`job`] | what parts say of themselves |
//! | [`writing`], [`part`] | one part, written and read |
//! | [`joined`] | all parts together |

mod job;
mod joined;
mod part;
mod work;
mod writing;

pub use job::FORMAT;
pub use joined::Parts;
pub use part::PartFile;
pub use writing::{PartReport, write_part};

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Parts, write_part};
    use crate::btf::direction::Direction;
    use crate::btf::sample::{Description, Sample};
    use crate::btf::writer::SampleWriter;
    use crate::progress::Progress;
    use crate::shard::Shard;
    use crate::texton::representatives::ImageVectors;
    use crate::texton::{Study, TextonOptions, analysis};

    /// Thirty images of 8 × 8 texels.
    fn write_sample(path: &Path) -> Sample {
        let lights: Vec<Direction> = (0..30)
            .map(|i| Direction::from_angles(0.04 * f64::from(i), f64::from(i)))
            .collect();
        let description = Description {
            tileable: true,
            ..Description::product(
                "waves",
                [8, 8],
                vec![Direction::from_angles(0.0, 0.0)],
                lights,
            )
        };
        let mut writer = SampleWriter::create(path, description).unwrap();
        for image in 0..30 {
            let number = |at: usize| ((at * at + image * (at % 7)) % 31) as f32 / 31.0;
            let numbers: Vec<f32> = (0..8 * 8 * 3).map(number).collect();
            writer.push(&numbers).unwrap();
        }
        writer.finish().unwrap();
        Sample::open(path).unwrap()
    }

    /// What little memory leads to: folded vectors of images, a sketched level.
    #[test]
    fn parts_of_every_route_join_to_the_same_vocabulary() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let sample = write_sample(&at("a.sample"));
        let options: TextonOptions =
            toml::from_str("textons = 6\nlevels = 2\nimages = 7\nimage-grid = 3").unwrap();
        let quiet = Progress::silent();
        for routes in [(1, ImageVectors::Folded), (1, ImageVectors::Exact)] {
            let study = Study::decided(&sample, &options, routes, None).unwrap();
            let whole = analysis::find(&study, None, quiet).unwrap().vocabulary;
            let whole = whole.write(&at("whole.npz")).unwrap();
            let paths = ["p0.npz", "p1.npz", "p2.npz"].map(at);
            for (index, path) in (0..).zip(&paths) {
                let shard = Shard { index, count: 3 };
                assert!(!write_part(&study, shard, path, quiet).unwrap().is_kept);
                assert!(write_part(&study, shard, path, quiet).unwrap().is_kept);
            }
            let parts = Parts::open(&paths, &sample).unwrap();
            let options = parts.options.clone();
            let study = parts.study(&sample, &options, None).unwrap();
            let joined = analysis::find(&study, Some(parts), quiet)
                .unwrap()
                .vocabulary;
            assert_eq!(
                joined.write(&at("joined.npz")).unwrap(),
                whole,
                "{routes:?}"
            );
        }
        // Machines that choose other routes make no common analysis.
        let routes = [
            (0, ImageVectors::Exact),
            (1, ImageVectors::Folded),
            (1, ImageVectors::Exact),
        ];
        let paths = ["r0.npz", "r1.npz", "r2.npz"].map(at);
        for ((index, path), routes) in (0..).zip(&paths).zip(routes) {
            let study = Study::decided(&sample, &options, routes, None).unwrap();
            write_part(&study, Shard { index, count: 3 }, path, quiet).unwrap();
        }
        let refused = Parts::open(&paths, &sample)
            .map(drop)
            .unwrap_err()
            .to_string();
        for says in [
            "r1.npz is made for another --memory (sketched levels 1, image vectors folded; the first: sketched \
             levels 0, image vectors exact)",
            "r2.npz is made for another --memory (sketched levels 1, image vectors exact;",
            "give every shard the same options and --memory",
        ] {
            assert!(refused.contains(says), "{refused}");
        }
        let all = TextonOptions {
            images: Some("all".parse().unwrap()),
            ..options
        };
        let study = Study::decided(&sample, &all, (1, ImageVectors::Exact), None).unwrap();
        let shard = Shard { index: 0, count: 2 };
        let refused = write_part(&study, shard, &at("p.npz"), quiet).unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("the finest 1 of 2 levels would be sketched"),
            "{refused}"
        );
    }
}
