//! The combinations in which an option changes nothing, as command lines.

/// A command line that is refused, and the option it is refused for; `|` where the parser may name either.
pub(super) const COMBINATIONS: &[(&str, &str)] = &[
    // Frames and sweeps.
    ("render a.sample m.ply -o f --frames 24", "frames"),
    ("render a.sample m.ply -o f --frames 1-10", "frames"),
    (
        "render a.sample m.ply -o f --sweep-length 9",
        "sweep-length",
    ),
    ("render a.sample m.ply -o f --sweep-from 9", "sweep-from"),
    ("render a.sample m.ply -o f --sweep-to 9", "sweep-to"),
    (
        "render a.sample m.ply -o f --sweep s.csv --sweep-to 9",
        "sweep-to",
    ),
    (
        "render a.sample m.ply -o f --sweep view-orbit --turns 2",
        "turns",
    ),
    ("render a.sample m.ply -o f --turns 3", "turns"),
    // Lights.
    (
        "render a.sample m.ply -o f --sweep light-azimuth --light point:1,2,3",
        "sweep",
    ),
    (
        "render a.sample m.ply -o f --sweep light-spiral --light point:1,2,3 --light sun:1,2",
        "sweep",
    ),
    (
        "render a.sample m.ply -o f --sweep light-elevation --environment e.exr",
        "sweep",
    ),
    (
        "render a.sample m.ply -o f --sweep light-spiral --environment e.exr",
        "sweep",
    ),
    (
        "render a.sample m.ply -o f --light-azimuth 9 --light sun:1,2",
        "light-azimuth",
    ),
    (
        "render a.sample m.ply -o f --light-azimuth 9 --environment e.exr",
        "light-azimuth",
    ),
    (
        "render a.sample m.ply -o f --light-azimuth 9 --sweep light-azimuth --sweep-from 1",
        "light-azimuth",
    ),
    (
        "render a.sample m.ply -o f --light-elevation 9 --light sun:1,2",
        "light-elevation",
    ),
    (
        "render a.sample m.ply -o f --light-elevation 9 --environment e.exr",
        "light-elevation",
    ),
    (
        "render a.sample m.ply -o f --light-elevation 9 --sweep light-elevation",
        "light-elevation",
    ),
    (
        "render a.sample m.ply -o f --light-elevation 9 --sweep light-spiral",
        "light-elevation",
    ),
    (
        "render a.sample m.ply -o f --irradiance 2 --light sun:1,2,3",
        "irradiance",
    ),
    (
        "render a.sample m.ply -o f --irradiance 2 --environment e.exr",
        "irradiance",
    ),
    (
        "render a.sample m.ply -o f --light-radius 2 --shadows none",
        "light-radius",
    ),
    ("render a.sample m.ply -o f --shadow-rays 8", "shadow-rays"),
    (
        "render a.sample m.ply -o f --shadow-rays 8 --light-radius 1 --shadows none",
        "light-radius",
    ),
    (
        "render a.sample m.ply -o f --environment-encoding srgb",
        "environment-encoding",
    ),
    (
        "render a.sample m.ply -o f --environment-layer a",
        "environment-layer",
    ),
    (
        "render a.sample m.ply -o f --environment-lights 8",
        "environment-lights",
    ),
    (
        "render a.sample m.ply -o f --environment-scale 8",
        "environment-scale",
    ),
    (
        "render a.sample m.ply -o f --environment-azimuth 8",
        "environment-azimuth",
    ),
    // Cameras.
    (
        "render a.sample m.ply -o f --camera-position 1,2,3 --camera-azimuth 9",
        "camera-azimuth",
    ),
    (
        "render a.sample m.ply -o f --sweep view-orbit --sweep-from 1 --camera-azimuth 9",
        "camera-azimuth",
    ),
    (
        "render a.sample m.ply -o f --camera-position 1,2,3 --camera-elevation 9",
        "camera-elevation",
    ),
    (
        "render a.sample m.ply -o f --camera-position 1,2,3 --front x",
        "front",
    ),
    (
        "render a.sample m.ply -o f --camera-position 1,2,3 --camera-target 0,2,3 --front x",
        "front",
    ),
    (
        "render a.sample m.ply -o f --projection orthographic --fov 9",
        "fov",
    ),
    (
        "render a.sample m.ply -o f --projection orthographic --focal-length 9",
        "focal-length",
    ),
    ("render a.sample m.ply -o f --view-height 9", "view-height"),
    // Atlases.
    ("render a.sample m.ply -o f --displace 1", "displace"),
    (
        "render a.sample m.ply -o f --surface-color 1,2,3",
        "surface-color",
    ),
    (
        "bake-maps a.sample m.ply -o t --unwrap --surface-color 1,2,3",
        "surface-color",
    ),
    (
        "bake-maps a.sample m.ply -o t --unwrap --sweep view-orbit",
        "sweep",
    ),
    (
        "bake-maps a.sample m.ply -o t --unwrap --frames 1",
        "frames",
    ),
    ("bake-maps a.sample m.ply -o t --unwrap --size 9x9", "size"),
    ("bake-maps a.sample m.ply -o t --unwrap --mip on", "mip"),
    (
        "bake-maps a.sample m.ply -o t --unwrap --camera-position 1,2,3 --camera-azimuth 9",
        "camera-azimuth",
    ),
    (
        "transfer m.ply --maps c.png -o c.ply --displace 1",
        "displace",
    ),
    (
        "transfer m.ply --maps c.png -o c.ply --transparency mask",
        "transparency",
    ),
    (
        "transfer m.ply --maps c.png -o c.ply --surface-color 1,2,3",
        "surface-color",
    ),
    // Samples.
    ("bake --preset weave -o a.sample --depth 0.1", "depth"),
    (
        "bake --preset weave -o a.sample --terraces keep",
        "terraces",
    ),
    ("bake --preset weave -o a.sample --alpha refuse", "alpha"),
    ("bake m.toml -o a.sample --error 0.1", "error"),
    ("bake m.toml -o a.sample --clamp --dtype f4", "clamp"),
    ("bake --reduce a b -o a.sample --depth 0.1", "depth"),
    ("bake --reduce a b -o a.sample --size 64", "size"),
    ("bake --reduce a b -o a.sample --preset weave", "preset"),
    ("bake m.toml --shard 0/2 -o a --preview p.png", "preview"),
    (
        "textons a.sample -o a.textons.npz --reduce p.npz --textons 9",
        "textons",
    ),
    (
        "textons a.sample -o a.textons.npz --reduce p.npz --memory 1GiB",
        "memory",
    ),
    (
        "textons a.sample -o a.npz --shard 0/2 --montage m.png",
        "montage",
    ),
    (
        "textons a.sample -o a.textons.npz --images all --image-grid 4",
        "image-grid",
    ),
    (
        "knn a.space.npz -o a.knn.npz --search exact --candidates 9",
        "candidates",
    ),
    (
        "exemplar c.png -o x --search exact --candidates 9",
        "candidates",
    ),
    (
        "import --reduce a.0of2 a.1of2 -o a.sample --downsample 2",
        "downsample",
    ),
    (
        "import --reduce a.0of2 a.1of2 -o a.sample --dtype f2",
        "dtype",
    ),
    ("import a.zip -o a.sample --reduce 2", "reduce"),
    (
        "import a.zip -o a.0of2 --shard 0/2 --reduce a.1of2",
        "shard|reduce",
    ),
    ("exemplar c.png -o x --tile --margin 2", "margin"),
    (
        "exemplar c.png -o x --levels 1 --coarse-neighborhood 3",
        "coarse-neighborhood",
    ),
    (
        "exemplar c.png -o x --transition-tolerance 0.1",
        "transition-tolerance",
    ),
    (
        "vary distort c.png -o x --ramp 0 --transition t.png",
        "ramp",
    ),
    (
        "vary warp c.png -o x --mask m.png --warp erode:by=1 --ramp-end 1 --transition t.png",
        "ramp-end",
    ),
    ("vary blend a.png b.png -o x --by mixture --blur 2", "blur"),
    (
        "vary blend a.png b.png -o x --by mixture --threshold 0.5",
        "threshold",
    ),
    (
        "vary blend a.png b.png -o x --by mixture --mask-window 3",
        "mask-window",
    ),
    (
        "vary blend a.png b.png -o x --by mixture --search exact --candidates 9",
        "candidates",
    ),
    (
        "vary warp c.png -o x --mask m.png --warp erode:by=1 --search exact --candidates 9",
        "candidates",
    ),
    (
        "vary distort c.png -o x --search exact --candidates 9",
        "candidates",
    ),
    // Meshes.
    ("mesh a.obj -o b.ply --direction 0,1,0", "direction"),
    ("mesh a.obj -o b.ply --align smooth", "align"),
    ("mesh a.obj -o b.ply --guide g.json", "guide"),
    ("mesh a.obj -o b.ply --keys k.json", "keys"),
    ("mesh a.obj -o b.ply --texel 1", "texel"),
    ("mesh a.obj -o b.ply --orient --levels 4", "levels"),
    ("mesh a.obj -o b.ply --orient --crease 40", "crease"),
    // Methods of synthesis.
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method adaptive --k 3",
        "k",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method coherent --coherence 1.5",
        "coherence",
    ),
    ("synth s.npz k.npz m.ply -o y.map.ply --rings 3", "rings"),
    ("synth s.npz k.npz m.ply -o y.map.ply --window 9", "window"),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --mask-weight 1",
        "mask-weight",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --dimensions 20",
        "dimensions",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method adaptive --metric embedded",
        "metric",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method multiscale --passes 3",
        "passes",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method coherent --levels 2",
        "levels",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method adaptive --neighborhood 7",
        "neighborhood",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --metric gram --spectrum 0.9 --polish 0",
        "spectrum",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --search full --repair-rounds 1",
        "repair-rounds",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --search full --reuse-penalty 1",
        "reuse-penalty",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --search full --k 3",
        "k",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --levels 1 --start-passes 2",
        "start-passes",
    ),
    // Targets of synthesis.
    (
        "synth s.npz k.npz m.ply -o y.map.ply --border wrap",
        "border",
    ),
    (
        "synth s.npz k.npz --grid 9x9 -o y.map.ply --texel 1",
        "texel",
    ),
    (
        "synth s.npz k.npz m.ply --onto atlas -o y.atlas --texel 1",
        "texel",
    ),
    (
        "synth s.npz k.npz --grid 9x9 -o y.map.ply --direction 0,1,0",
        "direction",
    ),
    (
        "synth s.npz k.npz --grid 9x9 -o y.map.ply --guide g.json",
        "guide",
    ),
    (
        "synth s.npz m.ply --method choosy -o y.faces.ply --align smooth",
        "align",
    ),
    ("synth s.npz k.npz m.ply -o y.map.ply --keys k.json", "keys"),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --method coherent --crease 40",
        "crease",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --resolution 512",
        "resolution",
    ),
    ("synth s.npz k.npz m.ply -o y.map.ply --unwrap", "unwrap"),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --charts faces",
        "charts",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --base-faces 99",
        "base-faces",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --subdivisions 1",
        "subdivisions",
    ),
    // Products of synthesis.
    (
        "synth s.npz m.ply --method choosy -o y.faces.ply --resume",
        "resume",
    ),
    (
        "synth s.npz m.ply --method choosy -o y.faces.ply --pictures p",
        "pictures",
    ),
    (
        "synth s.npz m.ply --method choosy -o y.faces.ply --force",
        "force",
    ),
    ("synth s.npz k.npz m.ply -o y.map.ply --glb y.glb", "glb"),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --levels-out y.npz",
        "levels-out",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --displace 1",
        "displace",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --transparency mask",
        "transparency",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --surface-color 1,2,3",
        "surface-color",
    ),
    (
        "synth s.npz k.npz m.ply -o y.map.ply --sample a.sample",
        "sample",
    ),
    // Exports and scenes.
    (
        "export a.sample --to folder -o x --sample b.sample",
        "sample",
    ),
    ("export m.ply --to glb -o x.glb --view 1,2", "view"),
    ("export m.ply --to glb -o x.glb --light 1,2", "light"),
    ("export a.sample --to bdi -o x.btf --rank 8", "rank"),
    ("export a.sample --to folder -o x --scalar f4", "scalar"),
    ("run s.toml --dry-run --no-pages", "no-pages"),
    ("run s.toml --plan --no-pages", "no-pages"),
    ("run s.toml --until synth --no-pages", "no-pages"),
    // Two of a kind.
    ("render a.sample m.ply -o f --half --float", "half|float"),
    (
        "render a.sample m.ply -o f --fov 9 --focal-length 9",
        "fov|focal-length",
    ),
    (
        "factor a.sample -o b.sample --rank 3 --error 0.1",
        "rank|error",
    ),
    ("run s.toml --dry-run --plan", "dry-run|plan"),
    ("run s.toml --verbose --quiet", "verbose|quiet"),
];

/// Command lines near those above in which every option has an effect.
pub(super) const NEIGHBORS: &[&str] = &[
    "render a.sample m.ply -o f --frames 1",
    "render a.sample m.ply -o f --frames 7-7",
    "render a.sample m.ply -o f --frames 24 --camera-path p.json",
    "render a.sample m.ply -o f --frames 24 --sweep s.csv",
    "render a.sample m.ply -o f --sweep light-spiral --turns 2 --light-azimuth 9 --environment e.exr --light sun:1,2",
    "render a.sample m.ply -o f --sweep light-azimuth --light-azimuth 9",
    "render a.sample m.ply -o f --sweep light-azimuth --environment e.exr --light-azimuth 9 --sweep-from 1",
    "render a.sample m.ply -o f --sweep light-elevation --light-azimuth 9",
    "render a.sample m.ply -o f --sweep view-orbit --light point:1,2,3",
    "render a.sample m.ply -o f --sweep s.csv --light point:1,2,3",
    "render a.sample m.ply -o f --irradiance 2 --light sun:1,2,3 --light sun:1,2",
    "render a.sample m.ply -o f --light-radius 2 --shadow-rays 4",
    "render a.sample m.ply -o f --sweep view-orbit --sweep-from 1 --camera-position 1,2,3 --camera-azimuth 9",
    "render a.sample m.ply -o f --camera-path p.json --camera-position 1,2,3 --camera-azimuth 9",
    "render a.sample m.ply -o f --camera-path p.json --camera-position 1,2,3 --front x",
    "render a.sample m.ply -o f --camera-position 1,2,3 --camera-target 1,0,3 --front x",
    "render a.sample m.ply -o f --projection orthographic --view-height 9",
    "bake-maps a.sample m.ply -o t --unwrap --light-azimuth 9 --weights inverse-angle",
    "knn a.space.npz -o a.knn.npz --candidates 9",
    "mesh a.obj -o b.ply --vertices 1000 --crease 40",
    "synth s.npz k.npz m.ply -o y.map.ply --metric gram --spectrum 0.9",
    "synth s.npz k.npz --grid 9x9 -o y.map.ply --border wrap",
    "synth s.npz m.ply --method choosy -o y.faces.ply --sample a.sample --iterations 2",
    "run s.toml --until synth",
    "import a.zip b.zip -o a.0of2 --shard 0/2 --downsample 2",
    "import --reduce a.0of2 a.1of2 -o a.sample",
];
