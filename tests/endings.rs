//! Names of outputs: none promises another format than is written, and no ending is doubled.

mod program;

use program::{files, refuse, write_capture, write_obj};

/// Command lines whose output has a name of something else; nothing is read before that is told.
const WRONG_NAMES: &[&str] = &[
    "bake --preset weave -o a.npz",
    "bake --preset weave -o a.atlas",
    "bake --preset weave -o a.sample --preview p.jpg",
    "bake --preset weave -o a.sample --surface s.npy",
    "import capture -o a.ply",
    "factor a.sample --rank 3 -o b.npz",
    "export a.sample --to folder -o x.zip",
    "export a.sample --to utia -o x.sample",
    "export a.sample --to bdi -o x.sample",
    "export a.sample --to ptm -o x.png",
    "export m.map.ply --to ply -o x.obj",
    "export m.map.ply --to obj -o x.ply",
    "export m.map.ply --to glb -o x.ply",
    "export m.map.ply --to usda -o x.glb",
    "textons a.sample -o b.sample",
    "textons a.sample -o a.textons.npz --report r.npz",
    "textons a.sample -o a.textons.npz --montage m.gif",
    "gram a.textons.npz -o a.json",
    "knn a.space.npz -o a.sample",
    "exemplar c.png -o x.sample",
    "exemplar c.png -o x.npz",
    "mask c.png --pick 1,1 -o m.jpg",
    "mask c.png --pick 1,1 -o m.png --overlay o.exr",
    "vary distort c.png -o x.sample",
    "mesh bell.obj -o b.stl",
    "mesh bell.obj -o b.ply.gz",
    "mesh bell.obj -o b.ply --report r.ply",
    "synth s.npz k.npz bell.obj -o y.obj",
    "synth s.npz k.npz bell.obj -o y.sample",
    "synth s.npz k.npz bell.obj -o y.ply.gz",
    "synth s.npz k.npz bell.obj -o y.map.ply --report r.npz",
    "synth s.npz k.npz bell.obj -o y.map.ply --pictures p.png",
    "synth s.npz k.npz bell.obj -o y.map.ply --sample a.sample --vertex-colors c.obj",
    "synth s.npz bell.obj --method choosy -o y.faces.ply --glb y.ply",
    "synth s.npz bell.obj --method choosy -o y.faces.ply --levels-out y.json",
    "render a.sample m.map.ply -o f.sample",
    "render a.sample m.map.ply -o f.exr",
    "render a.sample m.map.ply -o f --vertex-colors c.obj",
    "bake-maps a.sample m.map.ply --unwrap -o t.atlas",
    "bake-maps a.sample m.map.ply --unwrap -o t.png",
    "transfer m.map.ply --maps c.png -o c.obj",
    "view a.sample m.map.ply -o v.png",
    "report . -o r.json",
    "init --material capture --mesh bell.obj -o s.json",
    "demo -o d.sample",
];

#[test]
fn names_say_what_is_written() {
    let root = tempfile::tempdir().unwrap();
    write_capture(&root.path().join("capture"));
    write_obj(&root.path().join("bell.obj"), 300);
    let before = files(root.path());
    for line in WRONG_NAMES {
        let words: Vec<&str> = line.split(' ').collect();
        let error = refuse(root.path(), &words, 2);
        assert!(error.contains("end"), "{line}: {error}");
        assert!(error.contains("expected"), "{line}: {error}");
    }
    assert!(files(root.path()) == before);
}
