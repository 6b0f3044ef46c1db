//! Scenes that cannot be rendered: code 2, a message that names file and key, and no output folder.

use crate::harness::{SMALL, folder, rodsight_in};

/// Renders the small scene with one thing changed.
fn changed(from: &str, to: &str, says: &[&str]) {
    assert!(SMALL.contains(from), "{from} in the scene");
    let folder = folder();
    std::fs::write(
        folder.path().join("scene.toml"),
        SMALL.replacen(from, to, 1),
    )
    .unwrap();
    let run = rodsight_in(folder.path(), &["render", "scene.toml", "-o", "deep/out"]);
    run.failed(2, &[&["rodsight: "][..], says].concat());
    assert!(!folder.path().join("deep").exists(), "{to}");
}

#[test]
fn scene_with_an_unknown_key_names_the_nearest() {
    changed(
        "radius_m = 0.05",
        "radius = 0.05",
        &["scene.toml:", "rod[0].radius", "did you mean `radius_m`?"],
    );
    changed(
        "mode = \"single\"",
        "mode = \"singel\"",
        &["scene.toml:", "did you mean `single`?"],
    );
    changed(
        "[seabed]",
        "[sea_bed]",
        &["scene.toml:", "did you mean `seabed`?"],
    );
    changed(
        "name = \"IB\"",
        "name = \"1B\"",
        &["scene.toml", "water.name", "1B", "IB"],
    );
}

#[test]
fn scene_with_impossible_numbers_names_the_key() {
    let water = "name = \"IB\"";
    let coefficients = "absorption_per_m = [0.2, -0.05, 0.04]\nscattering_per_m = [0.1, 0.1, 0.1]";
    changed(
        water,
        coefficients,
        &["scene.toml", "water.absorption_per_m[1]", "found -0.05"],
    );
    changed(
        "length_m = 2.9",
        "length_m = 0.0",
        &["scene.toml", "rod[0].length_m", "> 0", "found 0"],
    );
    changed(
        "radius_m = 0.05",
        "radius_m = -0.05",
        &["rod[0].radius_m", "found -0.05"],
    );
    changed(
        "radius_m = 0.05",
        "radius_m = nan",
        &["rod[0].radius_m", "found NaN"],
    );
    changed(
        "radius_m = 0.05",
        "radius_m = \"5 cm\"",
        &["rod[0].radius_m", "5 cm"],
    );
    changed(
        "direction = [-0.023, 0.029, 0.111]",
        "direction = [0.0, 0.0, 0.0]",
        &["rod[0].direction", "zero length"],
    );
    changed(
        "albedo = [0.90, 0.30, 0.04]",
        "albedo = [1.90, 0.30, 0.04]",
        &["rod[0].albedo[0]", "between 0 and 1"],
    );
    changed(
        "fx_px = 391.644404911",
        "fx_px = nan",
        &["rig.left.fx_px", "NaN"],
    );
    changed(
        "[1, 0, 0]",
        "[1, 1, 0]",
        &["rig.left.rig_from_camera.rotation", "orthonormal"],
    );
    changed(
        "fibonacci = 55",
        "fibonacci = 64",
        &["sampling.edge.fibonacci", "the nearest is 55", "found 64"],
    );
    changed(
        "width_px = 480",
        "width_px = 4000000000",
        &[
            "scene.toml",
            "left camera",
            "at most 67108864 px",
            "4000000000×270",
        ],
    );
}

#[test]
fn scene_with_a_rod_behind_the_camera_says_so() {
    changed(
        "centre_m = [2.26,",
        "centre_m = [-2.26,",
        &["scene.toml", "rod[0]", "wholly behind both"],
    );
    changed(
        "along_m = 0.0",
        "along_m = 9.0",
        &["target.along_m", "within the rod's length", "found 9"],
    );
    changed(
        "rod = \"cable\"",
        "rod = \"cabel\"",
        &["target.rod", "\"cable\"", "\"cabel\""],
    );
}

#[test]
fn scene_of_a_later_version_says_what_this_one_does() {
    changed(
        "schema = 1",
        "schema = 2",
        &["scene.toml", "schema: expected 1, found 2"],
    );
    changed(
        "mode = \"single\"",
        "mode = \"full\"",
        &[
            "\"small\"",
            "mode \"full\"",
            "not implemented",
            "set mode to \"single\"",
        ],
    );
}

#[test]
fn scene_in_the_dark_says_so() {
    let folder = folder();
    let dark = SMALL.replace("[1.8, 2.0, 0.9]", "[0.0, 0.0, 0.0]");
    std::fs::write(folder.path().join("scene.toml"), dark).unwrap();
    let run = rodsight_in(folder.path(), &["render", "scene.toml", "-o", "out"]);
    assert_eq!(run.code, 2, "{run:?}");
    assert!(
        run.err.contains("light") || run.err.contains("radiant_intensity"),
        "{run:?}"
    );
    assert!(!folder.path().join("out").exists());
}

#[test]
fn scene_that_is_no_file_says_so() {
    let folder = folder();
    rodsight_in(folder.path(), &["render", "no.toml", "-o", "out"])
        .failed(2, &["no.toml: No such file"]);
    rodsight_in(folder.path(), &["render", ".", "-o", "out"]).failed(2, &[".: ", "directory"]);
    std::fs::write(folder.path().join("latin.toml"), b"id = \"caf\xe9\"").unwrap();
    rodsight_in(folder.path(), &["render", "latin.toml", "-o", "out"])
        .failed(2, &["latin.toml", "UTF-8"]);
    std::fs::write(folder.path().join("empty.toml"), "").unwrap();
    rodsight_in(folder.path(), &["render", "empty.toml", "-o", "out"])
        .failed(2, &["empty.toml", "missing field"]);
    assert!(!folder.path().join("out").exists());
}
