//! What a map shows, by the words that public libraries and programs use for it.

use std::ops::Range;

use crate::btf::bake::maps::folder::names::Word;
use crate::btf::bake::maps::normals::NormalY;
use crate::btf::bake::maps::packed::PackedOrder;

/// What a map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Albedo,
    Height,
    Roughness,
    Gloss,
    Metallic,
    Normal(NormalY),
    Packed(PackedOrder),
    /// Something a bake has no use for.
    Other(Other),
}

/// What a bake has no use for: what it is, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Other {
    pub(super) name: &'static str,
    pub(super) why: &'static str,
}

impl Role {
    /// What a report calls it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Height => "height",
            Self::Roughness => "roughness",
            Self::Gloss => "gloss",
            Self::Metallic => "metallic",
            Self::Normal(NormalY::Up) => "normal, green up (OpenGL)",
            Self::Normal(NormalY::Down) => "normal, green down (DirectX)",
            Self::Normal(NormalY::Auto) => "normal",
            Self::Packed(_) => "packed",
            Self::Other(other) => other.name,
        }
    }
}

/// What a name says: a role, and how far from the best of its kind such a map is (0: the best).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Told {
    pub(super) role: Role,
    pub(super) rank: u32,
    /// The place of the last word that tells it.
    pub(super) at: usize,
}

/// What a report calls pictures of a material.
pub(super) const PREVIEW: &str = "preview";

/// What a report calls maps of opacity.
pub(super) const OPACITY: &str = "opacity";

/// The most words that stand for one role, as `occlusion roughness metallic`.
const LONGEST: usize = 4;

/// What the own words of a name say; the last of them that say anything count.
pub(super) fn told(words: &[Word], own: Range<usize>) -> Option<Told> {
    let own = own.start..without_workflow(words, own);
    own.clone()
        .rev()
        .find_map(|last| {
            let spans = (1..=LONGEST)
                .rev()
                .filter_map(|length| (last + 1).checked_sub(length));
            let mut spans = spans.filter(|&first| first >= own.start);
            let (role, rank) = spans.find_map(|first| role_of(&words[first..=last]))?;
            let role = match role {
                Role::Normal(NormalY::Auto) => Role::Normal(convention(words, own.clone(), last)),
                role => role,
            };
            Some(Told {
                role,
                rank,
                at: last,
            })
        })
        .or_else(|| lone_convention(words, own))
}

/// Poliigon ends names with the workflow they are made for, as `NRM_2K_METALNESS`: where own words end
/// without it.
fn without_workflow(words: &[Word], own: Range<usize>) -> usize {
    let Some(last) = own.end.checked_sub(1).filter(|&last| last > own.start + 1) else {
        return own.end;
    };
    let is_workflow = ["metalness", "specular", "dielectric"].contains(&words[last].text.as_str());
    let after_size = super::names::resolution(&words[last - 1].text).is_some();
    if is_workflow && after_size && told(words, own.start..last).is_some() {
        last
    } else {
        own.end
    }
}

/// Where green points, by a word beside the one that says `normal`.
fn convention(words: &[Word], own: Range<usize>, at: usize) -> NormalY {
    let after = at + 1..own.end;
    let before = at.saturating_sub(1).max(own.start)..at;
    let mut beside = after.chain(before).map(|place| green(&words[place].text));
    beside.find_map(|found| found).unwrap_or(NormalY::Auto)
}

/// Where two normal maps are all there is, `normal` is what they share and only `gl` and `dx` are own.
fn lone_convention(words: &[Word], own: Range<usize>) -> Option<Told> {
    let at = own.start;
    let found = words[own].first().and_then(|word| green(&word.text))?;
    let before = &words[at.checked_sub(1)?..at];
    matches!(role_of(before), Some((Role::Normal(_), _))).then_some(Told {
        role: Role::Normal(found),
        rank: 0,
        at,
    })
}

fn green(word: &str) -> Option<NormalY> {
    match word {
        "gl" | "ogl" | "opengl" => Some(NormalY::Up),
        "dx" | "directx" | "d3d" => Some(NormalY::Down),
        _ => None,
    }
}

/// The role that words together stand for, with its rank.
fn role_of(words: &[Word]) -> Option<(Role, u32)> {
    let joined: String = words.iter().map(|word| word.text.as_str()).collect();
    // `scratched_metal_roughness` is a roughness map of scratched metal, `MetalRoughness` holds two maps.
    let apart = words.len() == 2 && !words[1].glued;
    known(&joined, apart).or_else(|| known(without_number(&joined), apart))
}

/// A word without the bits of its numbers (`disp16`) or the number of a variant (`col1`).
fn without_number(word: &str) -> &str {
    let bits = ["16", "32"].iter().find_map(|bits| word.strip_suffix(bits));
    bits.unwrap_or_else(|| {
        word.strip_suffix(|c: char| c.is_ascii_digit())
            .unwrap_or(word)
    })
}

fn known(word: &str, apart: bool) -> Option<(Role, u32)> {
    let best = |role| Some((role, 0));
    match word {
        "color" | "colour" | "albedo" | "alb" | "col" | "basecolor" | "basecolour" | "basecol"
        | "albedomap" | "colormap" => best(Role::Albedo),
        "diff" | "diffuse" | "dif" | "diffusecolor" | "diffusemap" => Some((Role::Albedo, 1)),
        "displacement" | "disp" | "displ" | "dsp" | "height" | "heightmap" | "hgt"
        | "displacementmap" => best(Role::Height),
        "bump" | "bumpmap" => Some((Role::Height, BUMP)),
        "roughness" | "rough" | "rgh" | "roughnessmap" => best(Role::Roughness),
        "gloss" | "glossiness" | "glossy" | "gls" | "smoothness" | "glossmap" => best(Role::Gloss),
        "metalness" | "metallic" | "metal" | "metallness" | "metalic" | "metallicmap" => {
            best(Role::Metallic)
        }
        "normal" | "normals" | "nor" | "nrm" | "nml" | "norm" | "normalmap" => {
            best(Role::Normal(NormalY::Auto))
        }
        "normalgl" | "nrmgl" | "norgl" => best(Role::Normal(NormalY::Up)),
        "normaldx" | "nrmdx" | "nordx" => best(Role::Normal(NormalY::Down)),
        _ => packed(word, apart)
            .or_else(|| other(word))
            .map(|role| (role, 0)),
    }
}

/// The rank of bump maps among height maps: they say where it is high, not how high.
pub(super) const BUMP: u32 = 1;

fn packed(word: &str, apart: bool) -> Option<Role> {
    let order = match word {
        "arm"
        | "orm"
        | "aorm"
        | "occlusionroughnessmetallic"
        | "occlusionroughnessmetalness"
        | "aoroughnessmetallic"
        | "aoroughnessmetalness"
        | "aoroughmetal"
        | "ambientocclusionroughnessmetallic" => "orm",
        "mra" | "mrao" | "metallicroughnessao" | "metallicroughnessocclusion" => "mro",
        "rma" | "rmao" | "roughnessmetallicao" | "roughnessmetallicocclusion" => "rmo",
        "metallicroughness" | "metalnessroughness" | "metalroughness" | "metalrough" if !apart => {
            "xrm"
        }
        _ => return None,
    };
    order.parse().ok().map(Role::Packed)
}

fn other(word: &str) -> Option<Role> {
    let (name, why) = match word {
        // What the bake makes of the relief.
        "ao" | "occlusion" | "ambientocclusion" | "occ" | "ambientocc" => {
            ("ambient occlusion", "the bake traces its own shadows")
        }
        "cavity" | "cav" | "cavitymap" => ("cavity", "the relief has its own cavities"),
        "edge" | "edges" | "curvature" | "curv" | "convexity" | "concavity" | "edgemask" => {
            ("edge", "the relief has its own edges")
        }
        // What the bake has no layer for.
        "specular" | "spec" | "spc" | "refl" | "reflection" | "reflectance" | "reflectivity"
        | "specularlevel" | "speclevel" | "specularcolor" | "ior" | "f0" => (
            "specular",
            "the coat has one reflectance everywhere (`reflectance` of a material.toml), metals are marked by a metalness map",
        ),
        "opacity" | "opac" | "alpha" | "transparency" | "mask" | "alphamask" | "opacitymask"
        | "alphamasked" | "cutout" => (OPACITY, "the surface is opaque"),
        "emission" | "emissive" | "emit" | "emis" | "emiss" | "glow" | "emissivecolor" => (
            "emission",
            "a sample holds what is reflected, not what glows",
        ),
        "translucency"
        | "translucent"
        | "sss"
        | "subsurface"
        | "scattering"
        | "transmission"
        | "transmissive"
        | "thickness"
        | "subsurfacecolor"
        | "subsurfacescattering" => ("translucency", "the bake lets no light through the surface"),
        "fuzz" | "sheen" | "anisotropy" | "aniso" | "anisotropyangle" | "anisotropylevel"
        | "clearcoat" | "coat" | "clearcoatroughness" | "coatroughness" | "direction" | "flow"
        | "tangent" | "overlay" | "brush" | "detail" => {
            ("another property", "the bake has no such layer")
        }
        // What shows or names parts of the material.
        "id" | "idmap" | "idmask" | "matid" | "materialid" | "colorid" => (
            "id mask",
            "it identifies parts and is not a property of the material",
        ),
        "preview" | "previews" | "thumb" | "thumbnail" | "thumbs" | "sphere" | "ball"
        | "render" | "renders" | "rendered" | "icon" | "promo" | "cover" | "screenshot" => {
            (PREVIEW, "it shows the material and is not a map of it")
        }
        // What is stored in a form that is not read.
        "vectordisplacement" | "vdisp" | "vdm" => (
            "vector displacement",
            "a height field moves along its normal only",
        ),
        "normalbump" | "bumpnormal" | "normalos" | "objectspacenormal" | "normalobject"
        | "worldspacenormal" | "normalworld" => (
            "another normal map",
            "only tangent-space normals of the relief are used",
        ),
        "maskmap" | "metallicsmoothness" | "metallicgloss" | "metallicglossiness"
        | "metallicsmooth" => (
            "packed, gloss in alpha",
            "alpha channels of maps are not read; split the file into metallic and gloss maps",
        ),
        _ => return None,
    };
    Some(Role::Other(Other { name, why }))
}

/// The role of an Unreal name, `T_Bricks_N`: only where every image is named so.
pub(super) fn unreal(words: &[Word], own: Range<usize>) -> Option<Told> {
    let at = words
        .iter()
        .rposition(|word| super::names::resolution(&word.text).is_none())?;
    let role = match words[at].text.as_str() {
        "d" | "bc" | "c" => Role::Albedo,
        "n" => Role::Normal(NormalY::Auto),
        "r" => Role::Roughness,
        "m" => Role::Metallic,
        "h" => Role::Height,
        "s" => other("specular")?,
        "e" => other("emission")?,
        "o" => other("opacity")?,
        _ => return told(words, own),
    };
    Some(Told { role, rank: 0, at })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::btf::bake::maps::folder::names::words_of;

    fn role(name: &str) -> Option<Role> {
        let words = words_of(Path::new(name));
        told(&words, 0..words.len()).map(|told| told.role)
    }

    #[test]
    fn the_words_of_libraries_are_known() {
        for (name, wanted) in [
            ("Bark014_2K-PNG_Displacement.png", "height"),
            ("WoodFine_DISP16_3K.tif", "height"),
            ("WoodFine_COL_VAR1_3K.jpg", "albedo"),
            ("WoodFine_GLOSS_3K.jpg", "gloss"),
            ("WoodFine_REFL_3K.jpg", "specular"),
            ("Tiles003_NRM_2K_METALNESS.png", "normal"),
            ("Tiles003_METALNESS_2K_METALNESS.png", "metallic"),
            ("sjfnbeaa_2K_Normal_LOD0.jpg", "normal"),
            ("bark_nor_gl_2k.exr", "normal, green up (OpenGL)"),
            ("rusty-metal_normal-dx.png", "normal, green down (DirectX)"),
            ("Plate_ambientOcclusion.jpg", "ambient occlusion"),
            ("rock_arm_4k.jpg", "packed"),
            ("Wall_OcclusionRoughnessMetallic.png", "packed"),
            ("Wall_Base_Color.png", "albedo"),
            ("Wall_MetallicRoughness.png", "packed"),
            ("scratched_metal_roughness.png", "roughness"),
            ("Wall_NormalBump.jpg", "another normal map"),
            ("Wall_IDMAP_2K.png", "id mask"),
            ("Wall_preview.jpg", "preview"),
            ("Wall_sss.jpg", "translucency"),
        ] {
            assert_eq!(role(name).map(Role::name), Some(wanted), "{name}");
        }
        assert_eq!(role("Wall_0123.png"), None);
    }

    #[test]
    fn a_convention_alone_counts_after_a_shared_normal() {
        let words = words_of(Path::new("normal_dx.png"));
        let found = told(&words, 1..2).map(|told| told.role);
        assert_eq!(found, Some(Role::Normal(NormalY::Down)));
    }

    #[test]
    fn single_letters_are_unreals() {
        let words = words_of(Path::new("T_Bricks_N.png"));
        assert_eq!(told(&words, 0..words.len()), None);
        assert_eq!(
            unreal(&words, 1..3).map(|told| told.role.name()),
            Some("normal")
        );
    }
}
