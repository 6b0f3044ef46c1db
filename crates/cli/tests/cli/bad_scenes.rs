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
