//! `rodsight demo`, once, at full size.

use crate::harness::{folder, names, rodsight, rodsight_in, text};

#[test]
fn demo_makes_one_page_and_the_files_around_it() {
    let folder = folder();
    // As in the help: no arguments but --json, and the default folder.
    let printed = rodsight_in(folder.path(), &["demo", "--json"]).json();
    let demo = folder.path().join("rodsight-demo");
    let found = names(&demo);
    for name in [
        "index.html",
        "result.json",
        "left.png",
        "right.png",
        "rig.toml",
        "scene.toml",
        "truth.json",
        "overlay-left.png",
        "overlay-right.png",
        "closeup-left.png",
        "closeup-right.png",
        "figure6-left-a-edges.png",
        "figure6-right-d-refined.png",
    ] {
        assert!(found.iter().any(|f| f == name), "{name} in {found:?}");
    }
    assert!(
        !found
            .iter()
            .any(|name| name.contains(".exr") || name.contains(".part")),
        "{found:?}"
    );
    let result: serde_json::Value =
        serde_json::from_slice(&std::fs::read(demo.join("result.json")).unwrap()).unwrap();
    assert_eq!(result, printed);
    assert_eq!(result["truth"]["scene"], "paper");
    let methods = result["methods"].as_array().unwrap();
    let by: Vec<&str> = methods
        .iter()
        .map(|m| m["estimate"]["method"].as_str().unwrap())
        .collect();
    assert_eq!(by, ["paper", "paper-bisector", "joint"]);
    for method in methods {
        assert_eq!(method["estimate"]["status"], "ok");
        // The path of the example in the help.
        let offset_m = method["errors"]["axis_offset_m"].as_f64().unwrap();
        assert!((1e-6..5e-3).contains(&offset_m), "{offset_m}");
    }
    page_is_self_contained(&std::fs::read_to_string(demo.join("index.html")).unwrap());

    // What it wrote is a pair like any other.
    let run = rodsight(&["inspect", text(&demo)]);
    assert!(run.done().contains("no left.exr, right.exr"), "{run:?}");
    let pick = &result["truth"]["grasp"]["pick_px"];
    let file = |name: &str| text(&demo.join(name)).to_owned();
    let args = [
        "solve",
        "--left",
        &file("left.png"),
        "--right",
        &file("right.png"),
        "--rig",
        &file("rig.toml"),
    ];
    let pick = format!("{},{}", pick[0], pick[1]);
    let run = rodsight(&[&args[..], &["--pick", &pick]].concat());
    assert!(run.done().contains("joint: ok"));
}

fn page_is_self_contained(page: &str) {
    for absent in ["http:", "https:", "<script", "<link", "@import", "url("] {
        assert!(!page.contains(absent), "{absent} in the page");
    }
    let pictures = page.matches("<img ").count();
    assert!(pictures >= 14, "{pictures}");
    assert_eq!(page.matches("src=\"data:image").count(), pictures);
    assert_eq!(page.matches("alt=\"").count(), pictures);
    assert!(page.len() < 8_000_000, "{}", page.len());
    for text in [
        "paper-bisector",
        "Provenance",
        "figure 6",
        "error: axis angle",
    ] {
        assert!(page.contains(text), "{text}");
    }
}
