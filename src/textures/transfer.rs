//! A channel of the sample onto a decorated surface: each texel of an atlas, or each vertex of a mesh, takes
//! the channel's value at its own texture coordinate.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::maps::atlas_map::AtlasMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::{TexelPoints, padding};
use crate::textures::channel::{SampleChannel, unit_vector};
use crate::textures::frames::{TangentFrames, in_frame, sample_frame};
use crate::textures::growth::grown;
use crate::textures::texture::Texture;

/// How far the nearest chart's tangent frame is looked for, in texels: farther than images are padded.
const FRAMES_REACH: u32 = 2 * PADDED;

/// How far images are padded across the borders of charts, in texels.
pub const PADDED: u32 = 8;

/// An atlas ready to take channels.
pub struct Canvas<'a> {
    map: &'a AtlasMap,
    points: TexelPoints,
    /// Texels outside charts, each with the texel inside that it repeats.
    padding: Vec<(u32, u32)>,
}

impl<'a> Canvas<'a> {
    /// Of a map, whose texels are found on its mesh again.
    pub fn new(map: &'a AtlasMap) -> Result<Self> {
        let atlas = map.atlas();
        let points = TexelPoints::new(&map.mesh, &atlas, map.width, map.height)?;
        let charts = map.chart.iter().enumerate();
        let strange = charts.filter(|(texel, chart)| points.is_inside(*texel) != (**chart >= 0));
        if let Some((texel, chart)) = strange.min_by_key(|(texel, _)| *texel) {
            let width = map.width as usize;
            let place = format!("chart, row {}, column {}", texel / width, texel % width);
            return Err(Error::data(place, chart.to_string())
                .expected("charts that cover the texels whose centres they contain"));
        }
        Ok(Self {
            padding: padding(&points, &atlas, &map.mesh, PADDED),
            map,
            points,
        })
    }

    /// Carries a channel onto the atlas; its grid is that of the map's sample.
    pub fn carry(&self, channel: &SampleChannel) -> Result<Texture> {
        let [width, height] = self.map.exemplar;
        if [channel.grid.width, channel.grid.height] != [width, height] {
            let found = format!("{}×{} texels", channel.grid.width, channel.grid.height);
            return Err(Error::data(format!("channel `{}`", channel.name), found)
                .expected(format!("{width}×{height}, as the atlas' sample has")));
        }
        let mut texture = match channel.kind {
            ChannelKind::Normal => self.carry_normals(channel),
            _ => self.carry_numbers(channel),
        };
        check_alpha(&texture, self.map)?;
        let mut filled: Vec<bool> = self.map.chart.iter().map(|&chart| chart >= 0).collect();
        for &(outside, _) in &self.padding {
            filled[outside as usize] = true;
        }
        texture.fill_rest(&filled);
        Ok(texture)
    }

    fn blank(&self, channel: &SampleChannel) -> Texture {
        Texture {
            name: channel.name.clone(),
            kind: channel.kind,
            count: channel.count,
            low: channel.low,
            high: channel.high,
            precision: channel.precision,
            width: self.map.width,
            height: self.map.height,
            numbers: vec![0.0; self.map.len() * channel.count],
        }
    }

    fn carry_numbers(&self, channel: &SampleChannel) -> Texture {
        let mut texture = self.blank(channel);
        let texels = texture.numbers.par_chunks_exact_mut(channel.count);
        texels.zip(&self.map.coords).for_each(|(texel, coord)| {
            if let Some(coord) = coord {
                texel.copy_from_slice(&channel.at(*coord)[..channel.count]);
            }
        });
        texture.copy(&self.padding);
        texture
    }

    /// Normals are turned into the tangent space of the texel that shows them: a padded texel lies beside
    /// another chart than the one it repeats.
    fn carry_normals(&self, channel: &SampleChannel) -> Texture {
        let map = self.map;
        let mut texture = self.blank(channel);
        let frames = TangentFrames::new(&map.mesh, &map.vertex_normals, &map.corner_uvs);
        let turned = |from: usize, shown: usize| {
            let coord = map.coords[from]?;
            let triangle = self.points.triangle[shown];
            let own = sample_frame(map.normal[from], map.orientation[from]);
            let normal = own * Vec3::from(unit_vector(channel.at(coord)));
            let frame = frames.at(triangle, self.points.weights[shown]);
            Some(in_frame(&frame, normal).to_array())
        };
        let texels = texture.numbers.par_chunks_exact_mut(channel.count);
        texels.enumerate().for_each(|(at, texel)| {
            if self.points.is_inside(at)
                && let Some(normal) = turned(at, at)
            {
                texel.copy_from_slice(&normal);
            }
        });
        let is_inside = |texel: usize| self.points.is_inside(texel);
        let near = grown([map.width, map.height], is_inside, FRAMES_REACH);
        let mut shown_by: Vec<u32> = (0..map.len() as u32).collect();
        for (outside, inside) in near {
            shown_by[outside as usize] = inside;
        }
        for &(outside, inside) in &self.padding {
            let shown = shown_by[outside as usize] as usize;
            if is_inside(shown)
                && let Some(normal) = turned(inside as usize, shown)
            {
                texture.numbers[outside as usize * channel.count..][..3].copy_from_slice(&normal);
            }
        }
        texture
    }
}

/// Refuses an alpha that leaves nothing to be seen.
fn check_alpha(texture: &Texture, map: &AtlasMap) -> Result<()> {
    let mut inside = texture
        .numbers
        .iter()
        .zip(&map.chart)
        .filter(|(_, chart)| **chart >= 0);
    if texture.kind == ChannelKind::Alpha && inside.all(|(alpha, _)| *alpha <= 0.0) {
        return Err(
            Error::data(format!("channel `{}`", texture.name), "0 at every texel")
                .expected("texels that are not wholly transparent")
                .advice("white is opaque: invert the image if it says how transparent texels are"),
        );
    }
    Ok(())
}

/// The value of a channel at every vertex of a map: colours in linear light, normals as unit vectors of mesh
/// space, all else as it stands. Of one number, the first of three.
pub fn onto_vertices(channel: &SampleChannel, map: &SurfaceTextonMap) -> Vec<[f32; 3]> {
    let vertices = (0..map.coords.len()).into_par_iter();
    let value = |vertex: usize| {
        let value = channel.at(map.coords[vertex]);
        match channel.kind {
            ChannelKind::Normal => {
                let frame = sample_frame(map.normals[vertex], map.orientations[vertex]);
                (frame * Vec3::from(unit_vector(value))).to_array()
            }
            _ => value,
        }
    };
    vertices.map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Encoding, FloatImage, Precision};
    use crate::maps::atlas_map::tests::square;

    fn channel(kind: ChannelKind, of: impl Fn(usize) -> Vec<f32>) -> SampleChannel {
        let data: Vec<f32> = (0..32).flat_map(of).collect();
        let image = FloatImage {
            width: 8,
            height: 4,
            channels: data.len() as u32 / 32,
            data,
            encoding: Encoding::Data,
            precision: Precision::Bits8,
        };
        SampleChannel::of_image(kind.name().into(), kind, image, square().grid()).unwrap()
    }

    #[test]
    fn texels_take_the_value_at_their_coordinate() {
        let map = square();
        let canvas = Canvas::new(&map).unwrap();
        let texture = canvas
            .carry(&channel(ChannelKind::Height, |at| vec![at as f32 / 64.0]))
            .unwrap();
        for (texel, &number) in texture.numbers.iter().enumerate() {
            // Beyond the surface's border its nearest texel is repeated.
            let (row, col) = ((texel / 4).max(1), (texel % 4).min(2));
            assert_eq!(number, (row * 8 + col) as f32 / 64.0);
        }
    }

    #[test]
    fn normals_turn_with_the_field_and_the_chart() {
        let mut map = square();
        let leaning = channel(ChannelKind::Normal, |_| vec![0.8, 0.5, 0.9]);
        let at = |map: &AtlasMap| {
            let canvas = Canvas::new(map).unwrap();
            Vec3::from_slice(canvas.carry(&leaning).unwrap().texel(5))
        };
        // Along s; the texture's u runs along x, as s does.
        let [x, _, z] = unit_vector([0.6, 0.0, 0.8]);
        assert!((at(&map) - Vec3::new(x, 0.0, z)).length() < 1e-5);
        map.orientation
            .iter_mut()
            .for_each(|s| *s = Vec3::Y * s.length());
        assert!((at(&map) - Vec3::new(0.0, x, z)).length() < 1e-5);
        // A chart that lies turned by a quarter: u runs along −y.
        let mut turned = square();
        let quarter = |uv: glam::Vec2| glam::Vec2::new(0.75 - uv.y, uv.x);
        turned
            .corner_uvs
            .iter_mut()
            .flatten()
            .for_each(|uv| *uv = quarter(*uv));
        assert!((at(&turned) - Vec3::new(0.0, x, z)).length() < 1e-5);
        // A mirrored chart: u runs along −x.
        let mut mirrored = square();
        let mirror = |uv: glam::Vec2| glam::Vec2::new(0.75 - uv.x, uv.y);
        mirrored
            .corner_uvs
            .iter_mut()
            .flatten()
            .for_each(|uv| *uv = mirror(*uv));
        assert!((at(&mirrored) - Vec3::new(-x, 0.0, z)).length() < 1e-5);
    }

    #[test]
    fn normals_are_padded_and_charts_must_fit() {
        let map = square();
        let canvas = Canvas::new(&map).unwrap();
        let leaning = channel(ChannelKind::Normal, |at| {
            vec![0.3 + 0.01 * at as f32, 0.5, 0.9]
        });
        let texture = canvas.carry(&leaning).unwrap();
        assert_eq!(texture.texel(7), texture.texel(6));
        assert_eq!(texture.texel(0), texture.texel(4));
        assert_ne!(texture.texel(0), texture.texel(7));
        let mut other = square();
        other.chart[4] = -1;
        let text = Canvas::new(&other).err().unwrap().to_string();
        assert!(text.contains("chart, row 1, column 0: -1"), "{text}");
    }

    #[test]
    fn alpha_that_hides_everything_and_other_samples_are_refused() {
        let map = square();
        let canvas = Canvas::new(&map).unwrap();
        let refused = |channel: &SampleChannel| canvas.carry(channel).unwrap_err().to_string();
        assert!(refused(&channel(ChannelKind::Alpha, |_| vec![0.0])).contains("0 at every texel"));
        let mut other = channel(ChannelKind::Mask, |_| vec![0.5]);
        other.grid.width = 9;
        assert!(refused(&other).contains("9×4"));
    }
}
