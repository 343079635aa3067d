//! Folders as public libraries and programs name them: roles, and the reason for every file.

use std::fs;

use super::*;

struct Folder(tempfile::TempDir);

impl Folder {
    fn with(names: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, b"").unwrap();
        }
        Self(folder)
    }

    fn survey(&self) -> MaterialSet {
        survey(self.0.path()).unwrap()
    }

    fn recipe(&self) -> Recipe {
        self.survey().recipe.unwrap()
    }

    fn refused(&self) -> String {
        self.survey().recipe.unwrap_err().to_string()
    }
}

fn why(set: &MaterialSet, file: &str) -> String {
    let found = set
        .files
        .iter()
        .find(|found| found.file == Path::new(file))
        .unwrap();
    format!("{} {}: {}", found.used, found.role, found.why)
}

#[test]
fn the_name_of_the_asset_plays_no_role() {
    let rusty = Folder::with(&[
        "rusty_metal_02_ao_1k.jpg",
        "rusty_metal_02_diff_1k.jpg",
        "rusty_metal_02_disp_1k.png",
        "rusty_metal_02_nor_gl_1k.exr",
        "rusty_metal_02_spec_1k.png",
        "rusty_metal_02_wet_1k.png",
    ]);
    let set = rusty.survey();
    assert!(why(&set, "rusty_metal_02_ao_1k.jpg").starts_with("false ambient occlusion"));
    assert!(why(&set, "rusty_metal_02_spec_1k.png").starts_with("false specular"));
    assert!(why(&set, "rusty_metal_02_wet_1k.png").starts_with("false unknown"));
    assert!(why(&set, "rusty_metal_02_nor_gl_1k.exr").contains("height map gives the relief"));
    let roles: Vec<&str> = set.defaults.iter().map(|role| role.role).collect();
    assert_eq!(roles, ["roughness", "metallic"]);
    let recipe = set.recipe.unwrap();
    assert_eq!(
        (recipe.surface.metallic, recipe.surface.roughness),
        (None, None)
    );
    let wood = Folder::with(&[
        "textures/rough_wood_ao_2k.png",
        "textures/rough_wood_disp_2k.png",
    ]);
    assert_eq!(wood.recipe().surface.roughness, None);
    let last = Folder::with(&[
        "disp_rough_metal.png",
        "ao_rough_metal.png",
        "diff_rough_metal.png",
    ]);
    let recipe = last.recipe();
    assert_eq!(recipe.relief.height, Some("disp_rough_metal.png".into()));
    assert_eq!(
        (recipe.surface.metallic, recipe.surface.roughness),
        (None, None)
    );
}

#[test]
fn gloss_and_packed_maps_fill_what_is_missing() {
    let gloss = Folder::with(&[
        "W_GLOSS_3K.jpg",
        "W_DISP16_3K.tif",
        "W_DISP_3K.jpg",
        "W_COL_3K.jpg",
    ]);
    let set = gloss.survey();
    assert!(why(&set, "W_GLOSS_3K.jpg").contains("1 − gloss"));
    assert!(why(&set, "W_DISP_3K.jpg").contains("W_DISP16_3K.tif is more precise"));
    assert_eq!(
        set.recipe.unwrap().surface.gloss,
        Some(Scalar::Map("W_GLOSS_3K.jpg".into()))
    );
    let both = Folder::with(&["x_gloss.png", "x_rough.png", "x_height.png"]);
    assert!(why(&both.survey(), "x_gloss.png").contains("roughness map takes precedence"));
    let packed = Folder::with(&["rock_arm_2k.png", "rock_disp_2k.png", "rock_metal_2k.png"]);
    let set = packed.survey();
    let said = why(&set, "rock_arm_2k.png");
    assert!(
        said.contains("green roughness") && said.contains("metalness has a map of its own"),
        "{said}"
    );
    let recipe = set.recipe.unwrap();
    assert_eq!(recipe.surface.packed, Some("rock_arm_2k.png".into()));
    let needless = Folder::with(&["r_orm.png", "r_disp.png", "r_metal.png", "r_rough.png"]);
    assert!(why(&needless.survey(), "r_orm.png").starts_with("false packed"));
}

#[test]
fn the_larger_and_the_more_precise_file_go_first() {
    let sizes = Folder::with(&["bark_disp_1k.png", "bark_disp_4k.png", "bark_disp_2k.png"]);
    let set = sizes.survey();
    assert!(why(&set, "bark_disp_2k.png").contains("bark_disp_4k.png is larger"));
    assert_eq!(
        set.recipe.unwrap().relief.height,
        Some("bark_disp_4k.png".into())
    );
    let kinds = Folder::with(&["height.png", "height.exr", "albedo.png"]);
    assert_eq!(kinds.recipe().relief.height, Some("height.exr".into()));
    let words = Folder::with(&[
        "x_Albedo.jpg",
        "x_Diffuse.jpg",
        "x_Displacement.exr",
        "x_Bump.jpg",
    ]);
    let set = words.survey();
    assert!(why(&set, "x_Diffuse.jpg").contains("is more specific"));
    assert!(why(&set, "x_Bump.jpg").starts_with("false height"));
    let variants = Folder::with(&["W_COL_VAR2_3K.jpg", "W_COL_VAR1_3K.jpg", "W_DISP_3K.jpg"]);
    let set = variants.survey();
    assert!(why(&set, "W_COL_VAR2_3K.jpg").contains("another variant"));
}

#[test]
fn two_materials_are_refused_by_naming_both() {
    let pair = Folder::with(&["a_height.png", "b_height.png"]).refused();
    assert!(
        pair.contains("a_height.png") && pair.contains("b_height.png"),
        "{pair}"
    );
    let whole = Folder::with(&[
        "bark_disp_1k.png",
        "bark_diff_1k.png",
        "bark_ao_1k.png",
        "moss_disp_1k.png",
        "moss_diff_1k.png",
        "moss_ao_1k.png",
    ]);
    let error = whole.refused();
    assert!(
        error.contains("bark_disp_1k.png") && error.contains("moss_disp_1k.png"),
        "{error}"
    );
}

#[test]
fn normal_maps_stand_in_for_heights() {
    let haven = Folder::with(&[
        "bark_brown_02_2k.blend",
        "textures/bark_brown_02_diff_2k.jpg",
        "textures/bark_brown_02_nor_gl_2k.exr",
        "textures/bark_brown_02_nor_dx_2k.exr",
        "textures/bark_brown_02_bump_2k.png",
    ]);
    let set = haven.survey();
    assert_eq!(set.naming, Some("Poly Haven"));
    assert!(why(&set, "bark_brown_02_2k.blend").contains("no image"));
    assert!(why(&set, "textures/bark_brown_02_bump_2k.png").contains("true slopes"));
    let recipe = set.recipe.unwrap();
    assert_eq!(
        recipe.relief.normal,
        Some("textures/bark_brown_02_nor_gl_2k.exr".into())
    );
    assert_eq!(
        (recipe.relief.height, recipe.relief.normal_y),
        (None, NormalY::Up)
    );
    let plain = Folder::with(&["normal_gl.png", "normal_dx.png"]).recipe();
    assert_eq!(plain.relief.normal, Some("normal_gl.png".into()));
    let bump = Folder::with(&["x_bump.png", "x_color.png"]).survey();
    assert!(why(&bump, "x_bump.png").contains("depth is not known"));
}

#[test]
fn files_that_cannot_be_read_and_folders_are_named() {
    let odd = Folder::with(&[
        "height.png",
        "roughness.tga",
        "notes.txt",
        "Thumbs/1k/x.png",
        "preview.jpg",
    ]);
    let set = odd.survey();
    assert!(why(&set, "roughness.tga").contains(".tga are not read"));
    assert!(why(&set, "notes.txt").contains("no image"));
    assert!(why(&set, "Thumbs").contains("not looked into"));
    assert!(why(&set, "preview.jpg").starts_with("false preview"));
    let none = Folder::with(&["albedo.png"]).refused();
    assert!(
        none.contains("no relief among its maps: albedo.png (albedo)"),
        "{none}"
    );
    let unknown = Folder::with(&["holiday.jpg"]).refused();
    assert!(unknown.contains("no map in it"), "{unknown}");
    let inner = Folder::with(&["readme.txt", "2K/x_height.png", "2K/x_color.png"]);
    assert_eq!(inner.recipe().relief.height, Some("2K/x_height.png".into()));
}

#[test]
fn unreals_letters_count_where_every_map_has_one() {
    let unreal = Folder::with(&["T_Rock_D.png", "T_Rock_N.png", "T_Rock_ORM.png"]).recipe();
    assert_eq!(unreal.surface.albedo, Color::Map("T_Rock_D.png".into()));
    assert_eq!(unreal.relief.normal, Some("T_Rock_N.png".into()));
    assert_eq!(unreal.surface.packed, Some("T_Rock_ORM.png".into()));
    let other = Folder::with(&["rock_D.png", "rock_N.png", "rock_height.png"]).survey();
    assert!(why(&other, "rock_N.png").starts_with("false unknown"));
}

#[test]
fn files_of_any_list_say_what_they_show() {
    let shown = |names: &[&str]| {
        let files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
        shown_by_names(&files)
    };
    assert_eq!(
        shown(&[
            "tiles/tiles_col_1k.png",
            "tiles/tiles_disp_1k.png",
            "tiles/tiles_nor_gl_1k.exr",
            "tiles/tiles_opacity_1k.png",
            "tiles/tiles_mask_1k.png",
            "tiles/tiles_rough_1k.png",
            "tiles/tiles_x_1k.png",
        ]),
        [
            Some(Shown::Color),
            Some(Shown::Height),
            Some(Shown::Normal),
            Some(Shown::Opacity),
            Some(Shown::Other),
            Some(Shown::Other),
            None,
        ]
    );
    // The asset's own name says nothing of its maps.
    assert_eq!(
        shown(&["metal_color.png", "metal_height.png"]),
        [Some(Shown::Color), Some(Shown::Height)]
    );
    assert_eq!(
        shown(&["T_Rock_D.png", "T_Rock_H.png"])[1],
        Some(Shown::Height)
    );
    assert_eq!(shown(&[]), []);
}
