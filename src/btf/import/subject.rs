//! What an image list is about: the description of its sample, as far as no image is needed for it.

use serde_json::{Value, json};

use crate::btf::import::arrangement::Arrangement;
use crate::btf::import::image_list::ImageList;
use crate::btf::import::options::ImportOptions;
use crate::btf::sample::{Description, FORMAT, Layout, VERSION};
use crate::format::id::ContentId;

/// The images, how they are arranged, and what the user says of them.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    pub(super) list: &'a ImageList,
    pub(super) options: &'a ImportOptions,
    pub(super) arrangement: &'a Arrangement,
}

impl Subject<'_> {
    /// The sample's description; the images tell its width and height, and how many pixels are hot.
    pub(super) fn describe(
        &self,
        (width, height): (u32, u32),
        hot_pixels: Option<usize>,
    ) -> Description {
        let (options, arrangement) = (self.options, self.arrangement);
        let pixels = f64::from(options.preparation.pixels_per_texel());
        let own_name = || self.list.name.clone();
        Description {
            format: FORMAT.into(),
            version: VERSION,
            name: options.name.clone().unwrap_or_else(own_name),
            width,
            height,
            channels: 3,
            dtype: options.dtype,
            texel_mm: options.texel_mm.map(|mm| mm * pixels),
            layout: match arrangement.pairs {
                Some(_) => Layout::Pairs,
                None => Layout::Product,
            },
            views: arrangement.views.clone(),
            lights: arrangement.lights.clone(),
            pairs: arrangement.pairs.clone(),
            tileable: options.tileable,
            id: ContentId::of_bytes(b""),
            source: self.source(hot_pixels),
        }
    }

    /// Where the sample comes from: what is said of every import, then what is said where it was used.
    fn source(&self, hot_pixels: Option<usize>) -> Value {
        // Collect what is said of every import.
        let (list, options, preparation) = (self.list, self.options, &self.options.preparation);
        let mut source = json!({ "kind": list.kind, "handedness": list.handedness,
            "values": options.values.of_family(list.family), "encoding": options.encoding,
            "orientation": options.orientation, "layer": options.layer });
        // Add what was used of the rest.
        let given = [
            ("illuminant", json!(options.illuminant)),
            ("crop", json!(preparation.crop)),
            ("downsample", json!(preparation.downsample)),
            ("keep_views", json!(preparation.keep_views)),
            ("keep_lights", json!(preparation.keep_lights)),
            ("grey_card", json!(preparation.grey_card)),
            (
                "rectified",
                json!(options.photographs.corners.as_ref().map(|_| "corners")),
            ),
            (
                "resampled",
                json!(list.positions.as_ref().map(|_| "near field")),
            ),
            ("hot_pixels", json!(hot_pixels)),
            ("filled", filled(&self.arrangement.filled)),
        ];
        if let Some(fields) = source.as_object_mut() {
            let used = given.into_iter().filter(|(_, value)| !value.is_null());
            fields.extend(used.map(|(name, value)| (name.to_owned(), value)));
            fields.extend(list.facts.clone());
        }
        source
    }
}

/// The interpolated images as [view, light] numbers; null where there are none.
fn filled(pairs: &[[u32; 2]]) -> Value {
    match pairs {
        [] => Value::Null,
        pairs => json!(pairs),
    }
}
