//! What is kept from frame to frame changes no byte: every frame alone is the sweep's frame.

use super::*;

#[test]
fn frames_alone_are_the_sweeps_frames() {
    let bench = small_ball(DType::F2);
    for (index, sweep) in [
        &["light-azimuth", "--shading", "pixel"][..],
        &["light-azimuth", "--shading", "pixel", "--shadows", "pixel"],
        &["view-orbit", "--shading", "pixel", "--texels", "bilinear"],
        &["view-orbit", "--weights", "inverse-angle"],
        &["view-orbit", "--weights", "quadratic"],
        &[
            "light-azimuth",
            "--shading",
            "pixel",
            "--weights",
            "quadratic",
        ],
    ]
    .into_iter()
    .enumerate()
    {
        let options = ["--size", "40x30", "--frames", "4", "--mip", "on", "--sweep"];
        let options = [&options[..], sweep].concat();
        let whole = files(&bench.render(&format!("whole-{index}"), &options));
        let alone = format!("alone-{index}");
        for shard in ["0/4", "1/4", "2/4", "3/4"] {
            bench.render(&alone, &[&options[..], &["--shard", shard]].concat());
        }
        assert_eq!(whole, files(&bench.path(&alone)), "{sweep:?}");
    }
}
