//! `rodsight inspect`.

use std::path::Path;

use crate::harness::{folder, names, pair, read_json, rodsight, text};

fn copy(to: &Path, files: &[&str]) {
    for file in files {
        std::fs::copy(pair().join(file), to.join(file)).unwrap();
    }
}

const IMAGES: [&str; 3] = ["left.png", "right.png", "truth.json"];

#[test]
fn inspect_draws_a_sheet_and_a_page() {
    let folder = folder();
    copy(
        folder.path(),
        &[&IMAGES[..], &["left.exr", "right.exr"]].concat(),
    );
    let run = rodsight(&["inspect", text(folder.path())]);
    assert!(
        run.done().contains("inspect.png") && run.out.contains("radius, mm: 50.0"),
        "{run:?}"
    );
    let page = std::fs::read_to_string(folder.path().join("inspect.html")).unwrap();
    assert!(page.contains("light scattered by the water"));
    assert!(rodsight_render::read_image(&folder.path().join("inspect.png")).is_ok());
    let truth = rodsight(&["inspect", text(folder.path()), "--json"]).json();
    assert_eq!(truth, read_json(&pair().join("truth.json")));
}

#[test]
fn inspect_without_channels_says_what_is_missing() {
    let folder = folder();
    copy(folder.path(), &IMAGES);
    let run = rodsight(&["inspect", text(folder.path())]);
    assert!(run.done().contains("no left.exr, right.exr"), "{run:?}");
    assert_eq!(
        names(folder.path()),
        [
            "inspect.html",
            "inspect.png",
            "left.png",
            "right.png",
            "truth.json"
        ]
    );
}

#[test]
fn inspect_of_what_is_no_pair_says_so() {
    let folder = folder();
    let inspect = || rodsight(&["inspect", text(folder.path())]);
    inspect().failed(
        2,
        &[
            "truth.json",
            "expected the truth written by `rodsight render`",
            "No such file",
        ],
    );
    std::fs::write(folder.path().join("truth.json"), "{\"schema\": 1}").unwrap();
    inspect().failed(2, &["truth.json", "missing field"]);
    copy(folder.path(), &["truth.json"]);
    inspect().failed(2, &["left.png", "No such file"]);
    copy(folder.path(), &IMAGES);
    std::fs::write(folder.path().join("left.exr"), "no EXR").unwrap();
    inspect().failed(2, &["left.exr"]);
    std::fs::remove_file(folder.path().join("left.exr")).unwrap();
    image::RgbImage::new(12, 8)
        .save(folder.path().join("right.png"))
        .unwrap();
    inspect().failed(
        2,
        &[
            "right.png",
            "expected 480×270 px as in truth.json, found 12×8",
        ],
    );
    let mut truth = read_json(&pair().join("truth.json"));
    truth["grasp"]["rod"] = 7.into();
    std::fs::write(folder.path().join("truth.json"), truth.to_string()).unwrap();
    inspect().failed(2, &["truth.json", "grasp on rod 7 of 1"]);
    truth["rig"]["left"]["fx_px"] = (-1.0).into();
    std::fs::write(folder.path().join("truth.json"), truth.to_string()).unwrap();
    inspect().failed(2, &["truth.json", "left.fx_px", "-1"]);
    assert_eq!(
        names(folder.path()),
        ["left.png", "right.png", "truth.json"]
    );
}
