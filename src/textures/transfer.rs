//! A channel of the sample onto a decorated surface: each texel of an atlas, or each vertex of a mesh, takes
//! the channel's value at its own texture coordinate.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::maps::atlas_map::AtlasMap;
use crate::maps::atlas_map::description::LARGEST;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::{MOST_TEXELS, TexelPoints, padding};
use crate::progress::Progress;
use crate::textures::channel::{SampleChannel, unit_vector};
use crate::textures::fine_texels::FineTexels;
use crate::textures::frames::{TangentFrames, in_frame, sample_frame};
use crate::textures::growth::grown;
use crate::textures::texel_sites::TexelSites;
use crate::textures::texture::Texture;

/// How far the nearest chart's tangent frame is looked for, in texels: farther than images are padded.
const FRAMES_REACH: u32 = 2 * PADDED;

/// How far images are padded across the borders of charts, in texels.
pub const PADDED: u32 = 8;

/// An atlas ready to take channels.
pub struct Canvas<'a> {
    map: &'a AtlasMap,
    texels: FineTexels<'a>,
    /// Texels outside charts, each with the texel inside that it repeats.
    padding: Vec<(u32, u32)>,
}

impl<'a> Canvas<'a> {
    /// For textures that have `finer` times as many columns and rows as the map, which is 1 or more.
    pub fn new(map: &'a AtlasMap, finer: u32) -> Result<Self> {
        check_finer([map.width, map.height], finer)?;
        let atlas = map.atlas();
        let texels = FineTexels::new(map, &atlas, finer)?;
        Ok(Self {
            padding: padding(&texels.points, &atlas, &map.mesh, PADDED),
            map,
            texels,
        })
    }

    /// Carries channels onto the atlas; their grid is that of the map's sample.
    pub fn carry_all(
        &self,
        channels: &[SampleChannel],
        progress: Progress<'_>,
    ) -> Result<Vec<Texture>> {
        progress.begin("channels", channels.len() as u64);
        let mut textures = Vec::with_capacity(channels.len());
        for channel in channels {
            textures.push(self.carry(channel)?);
            progress.advance(1)?;
        }
        progress.end();
        Ok(textures)
    }

    /// Carries one channel.
    pub fn carry(&self, channel: &SampleChannel) -> Result<Texture> {
        let [width, height] = self.map.header.exemplar;
        if [channel.grid.width, channel.grid.height] != [width, height] {
            let found = format!("{}×{} texels", channel.grid.width, channel.grid.height);
            return Err(Error::data(format!("channel `{}`", channel.name), found)
                .expected(format!("{width}×{height}, as the atlas' sample has")));
        }
        let mut texture = match channel.kind {
            ChannelKind::Normal => self.carry_normals(channel),
            _ => self.carry_numbers(channel),
        };
        let is_inside = |texel: usize| self.texels.points.is_inside(texel);
        check_alpha(&texture, is_inside)?;
        texture.fill_beyond(&self.padding, is_inside);
        Ok(texture)
    }

    /// The texels inside charts, as points that are shaded one by one.
    pub fn sites(&self) -> TexelSites {
        TexelSites::new(self.map, &self.texels.points)
    }

    /// Where the texels lie on the mesh.
    pub fn points(&self) -> &TexelPoints {
        &self.texels.points
    }

    /// Texels outside charts, each with the texel inside that it repeats.
    pub fn padding(&self) -> &[(u32, u32)] {
        &self.padding
    }

    fn blank(&self, channel: &SampleChannel) -> Texture {
        let points = &self.texels.points;
        Texture {
            name: channel.name.clone(),
            kind: channel.kind,
            count: channel.count,
            low: channel.low,
            high: channel.high,
            precision: channel.precision,
            width: points.width,
            height: points.height,
            numbers: vec![0.0; points.triangle.len() * channel.count],
        }
    }

    fn carry_numbers(&self, channel: &SampleChannel) -> Texture {
        let mut texture = self.blank(channel);
        let texels = texture
            .numbers
            .par_chunks_exact_mut(channel.count)
            .enumerate();
        texels
            .filter(|(at, _)| self.texels.points.is_inside(*at))
            .for_each(|(at, texel)| {
                for source in self.texels.sources(at) {
                    let value = channel.at(source.coord);
                    texel
                        .iter_mut()
                        .zip(value)
                        .for_each(|(sum, value)| *sum += source.share * value);
                }
            });
        texture.copy(&self.padding);
        texture
    }

    /// Normals are turned into the tangent space of the texel that shows them: a padded texel lies beside
    /// another chart than the one it repeats.
    fn carry_normals(&self, channel: &SampleChannel) -> Texture {
        let (map, points) = (self.map, &self.texels.points);
        let mut texture = self.blank(channel);
        let frames = TangentFrames::new(&map.mesh, &map.vertex_normals, &map.corner_uvs);
        let turned = |from: usize, shown: usize| {
            let frame = frames.at(points.triangle[shown], points.weights[shown]);
            in_frame(&frame, self.normal_at(channel, from)).to_array()
        };
        let texels = texture
            .numbers
            .par_chunks_exact_mut(channel.count)
            .enumerate();
        texels
            .filter(|(at, _)| points.is_inside(*at))
            .for_each(|(at, texel)| texel.copy_from_slice(&turned(at, at)));
        let is_inside = |texel: usize| points.is_inside(texel);
        let near = grown([points.width, points.height], is_inside, FRAMES_REACH);
        let mut shown_by: Vec<u32> = (0..points.triangle.len() as u32).collect();
        for (outside, inside) in near {
            shown_by[outside as usize] = inside;
        }
        for &(outside, inside) in &self.padding {
            let shown = shown_by[outside as usize] as usize;
            if is_inside(shown) {
                let normal = turned(inside as usize, shown);
                texture.numbers[outside as usize * channel.count..][..3].copy_from_slice(&normal);
            }
        }
        texture
    }

    /// The normal that a texel inside a chart shows, in mesh space and of any length.
    fn normal_at(&self, channel: &SampleChannel, texel: usize) -> Vec3 {
        let sources = self.texels.sources(texel);
        let turned = sources.map(|source| {
            let frame = sample_frame(
                self.map.normal[source.texel],
                self.map.orientation[source.texel],
            );
            source.share * (frame * Vec3::from(unit_vector(channel.at(source.coord))))
        });
        turned.sum()
    }
}

/// Refuses textures that no image can hold, or none at all: those of `finer` times the sides of an atlas.
pub fn check_finer([width, height]: [u32; 2], finer: u32) -> Result<()> {
    let of_sides = LARGEST / width.max(height).max(1);
    let texels = u64::from(width) * u64::from(height);
    let of_texels = (MOST_TEXELS / texels.max(1)).isqrt() as u32;
    let most = of_sides.min(of_texels);
    if (1..=most).contains(&finer) {
        return Ok(());
    }
    Err(Error::option(
        "finer",
        finer.to_string(),
        format!(
            "1 to {most}: texture maps have up to {MOST_TEXELS} texels and {LARGEST} columns and rows"
        ),
    ))
}

/// Refuses an alpha that leaves nothing to be seen.
fn check_alpha(texture: &Texture, is_inside: impl Fn(usize) -> bool) -> Result<()> {
    let mut seen = (0..texture.numbers.len()).filter(|&texel| is_inside(texel));
    if texture.kind == ChannelKind::Alpha && seen.all(|texel| texture.numbers[texel] <= 0.0) {
        return Err(
            Error::data(format!("channel `{}`", texture.name), "0 at every texel")
                .expected("texels that are not wholly transparent")
                .advice("white is opaque: invert the image if it stores transparency"),
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
        SampleChannel::of_image(kind.name().into(), kind, image, square().grid(), 1).unwrap()
    }

    #[test]
    fn texels_take_the_value_at_their_coordinate() {
        let map = square();
        let canvas = Canvas::new(&map, 1).unwrap();
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
            let canvas = Canvas::new(map, 1).unwrap();
            Vec3::from_slice(canvas.carry(&leaning).unwrap().texel(5))
        };
        // Along s; the texture's u runs along x, as s does.
        let [x, _, z] = unit_vector([0.6, 0.0, 0.8]);
        assert!((at(&map) - Vec3::new(x, 0.0, z)).length() < 1e-5);
        map.orientation
            .iter_mut()
            .for_each(|s| *s = Vec3::Y * s.length());
        assert!((at(&map) - Vec3::new(0.0, x, z)).length() < 1e-5);
        // A chart that lies rotated by a quarter: u runs along −y.
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
        let canvas = Canvas::new(&map, 1).unwrap();
        let leaning = channel(ChannelKind::Normal, |at| {
            vec![0.3 + 0.01 * at as f32, 0.5, 0.9]
        });
        let texture = canvas.carry(&leaning).unwrap();
        assert_eq!(texture.texel(7), texture.texel(6));
        assert_eq!(texture.texel(0), texture.texel(4));
        assert_ne!(texture.texel(0), texture.texel(7));
        let mut other = square();
        other.chart[4] = -1;
        let text = Canvas::new(&other, 1).err().unwrap().to_string();
        assert!(text.contains("chart, row 1, column 0: -1"), "{text}");
    }

    #[test]
    fn alpha_that_hides_everything_and_other_samples_are_refused() {
        let map = square();
        let canvas = Canvas::new(&map, 1).unwrap();
        let refused = |channel: &SampleChannel| canvas.carry(channel).unwrap_err().to_string();
        assert!(refused(&channel(ChannelKind::Alpha, |_| vec![0.0])).contains("0 at every texel"));
        let mut other = channel(ChannelKind::Mask, |_| vec![0.5]);
        other.grid.width = 9;
        assert!(refused(&other).contains("9×4"));
    }

    #[test]
    fn finer_textures_go_on_between_the_texels() {
        let map = square();
        // Four texels of the channel on each side of one of the sample: a ramp along s and t.
        let of = |at: usize| ((at % 32) as f32 + 0.5) / 64.0 + (15.5 - (at / 32) as f32) / 32.0;
        let image = FloatImage {
            width: 32,
            height: 16,
            channels: 1,
            data: (0..32 * 16).map(of).collect(),
            encoding: Encoding::Data,
            precision: Precision::Bits16,
        };
        let kind = ChannelKind::Mask;
        let channel = |detail| {
            SampleChannel::of_image("m".into(), kind, image.clone(), map.grid(), detail).unwrap()
        };
        for finer in [1, 2, 4] {
            let canvas = Canvas::new(&map, finer).unwrap();
            let texture = canvas.carry(&channel(finer)).unwrap();
            assert_eq!([texture.width, texture.height], [4 * finer; 2]);
            let columns = texture.width as usize;
            for (texel, &number) in texture.numbers.iter().enumerate() {
                if !canvas.texels.points.is_inside(texel) {
                    continue;
                }
                let place = |at: usize| (at as f32 + 0.5) / finer as f32;
                let (s, t) = (place(texel % columns), 4.0 - place(texel / columns));
                let wanted = 4.0 * s / 64.0 + 4.0 * t / 32.0;
                // Next to the sample's border its other side follows.
                if s > 0.5 && t < 3.5 && t > 0.5 {
                    assert!(
                        (number - wanted).abs() < 1e-4,
                        "{finer}, {s}, {t}: {number}, {wanted}"
                    );
                }
            }
        }
        for finer in [0, 5000] {
            assert!(
                Canvas::new(&map, finer)
                    .err()
                    .unwrap()
                    .to_string()
                    .contains("--finer")
            );
        }
    }
}
