//! The sections of a scene.

/// Sections of a scene, in the order of their stages.
pub const SECTIONS: [&str; 9] = [
    "bake", "import", "exemplar", "textons", "gram", "knn", "mesh", "synth", "render",
];
