//! Which images of a list a run makes, and which it reads for them.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::DVec3;

use crate::btf::import::arrangement::{Arrangement, Slot};
use crate::btf::import::destination::{Destination, InputIds};
use crate::btf::import::fill::Blend;
use crate::btf::import::image_list::ImageList;
use crate::btf::import::list_ids;
use crate::btf::import::near_field::NearPositions;
use crate::btf::import::stations::{NearField, Patch, Station};
use crate::btf::import::subject::Subject;
use crate::btf::parts::{self, NewPart};
use crate::btf::sample::Description;
use crate::error::Result;
use crate::progress::Progress;

/// The images of one run: those of its shard, or all.
pub(super) struct ShardImages {
    /// Those it makes, of all images of the sample.
    pub(super) images: Range<usize>,
    /// Those it prepares for that, in order: the same, or all that near ones are resampled from.
    pub(super) prepared: Vec<usize>,
    /// The cameras and lamps of all images, where they are near; the patch has no texels yet.
    pub(super) near_field: Option<NearField>,
    /// What its part is; `None` where it makes the whole sample.
    pub(super) part: Option<NewPart>,
}

impl ShardImages {
    pub(super) fn of(
        subject: &Subject<'_>,
        destination: Destination<'_>,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let Subject {
            list,
            options,
            arrangement,
        } = subject;
        let near = |positions| near_field(positions, list, arrangement);
        let near_field = list.positions.as_ref().map(near);
        let prepared = |images: Range<usize>| match &near_field {
            Some(near) => near.sources_of(images),
            None => images.collect(),
        };
        let count = arrangement.slots.len();
        let part = destination.part(count, options, |images| {
            let read = files_of(arrangement, &prepared(images));
            Ok(InputIds {
                source: list_ids::of_list(list, arrangement)?,
                own: Some(list_ids::of_files(list, &read, progress)?),
            })
        })?;
        let images = part.as_ref().map_or(0..count, |part| part.images.clone());
        Ok(Self {
            prepared: prepared(images.clone()),
            images,
            near_field,
            part,
        })
    }

    /// The part where it is there already, whole.
    pub(super) fn find(
        &self,
        subject: &Subject<'_>,
        destination: Destination<'_>,
    ) -> Option<Description> {
        let part = self.part.as_ref()?;
        // Only the images tell their size and the hot pixels: the ids say that the images are the same.
        let expected = |found: &Description| {
            let hot_pixels = found.source["hot_pixels"].as_u64();
            let size = (found.width, found.height);
            part.described_in(&subject.describe(size, hot_pixels.map(|count| count as usize)))
        };
        parts::find(destination.path, expected, None)
    }
}

/// The images of the list that some images of the sample are made from, in order.
fn files_of(arrangement: &Arrangement, places: &[usize]) -> Vec<usize> {
    let mut files = BTreeSet::new();
    for &place in places {
        match &arrangement.slots[place] {
            Slot::Read(image) => {
                files.insert(*image);
            }
            Slot::Fill(Blend(shares)) => files.extend(shares.iter().map(|(image, _)| *image)),
        }
    }
    files.into_iter().collect()
}

/// Where the cameras and lamps of the sample's images stood, in their order.
fn near_field(positions: &NearPositions, list: &ImageList, arrangement: &Arrangement) -> NearField {
    let at = |all: &Option<Vec<DVec3>>, image: usize| all.as_ref().map(|all| all[image]);
    let station = |slot: &Slot| match slot {
        Slot::Read(image) => Some(Station {
            view: list.images[*image].view,
            light: list.images[*image].light,
            view_at: at(&positions.cameras, *image),
            light_at: at(&positions.lamps, *image),
        }),
        Slot::Fill(_) => None,
    };
    NearField {
        stations: arrangement.slots.iter().filter_map(station).collect(),
        patch: Patch {
            width: 0,
            height: 0,
            sides_mm: [positions.patch.width, positions.patch.height],
        },
    }
}
