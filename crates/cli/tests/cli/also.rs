//! `rodsight solve --also`: one rod in several pairs.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use crate::harness::{Run, SMALL, rodsight, solve, text};

/// The small scene from 0.3 m higher.
pub(crate) fn heaved() -> &'static Path {
    static HEAVED: OnceLock<PathBuf> = OnceLock::new();
    HEAVED.get_or_init(|| {
        let base = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-heaved");
        std::fs::create_dir_all(&base).unwrap();
        let scene = base.join("small.toml");
        let [left, right] = ["-0.5", "0.5"].map(|y| format!("[0.0, {y}, -1.0]"));
        let [up_left, up_right] = ["-0.5", "0.5"].map(|y| format!("[0.0, {y}, -1.3]"));
        let moved = SMALL.replace(&left, &up_left).replace(&right, &up_right);
        let moved = moved.replace("seed = 1\n", "seed = 2\n");
        assert_ne!(moved, SMALL);
        std::fs::write(&scene, moved).unwrap();
        let pair = base.join("pair");
        rodsight(&["render", text(&scene), "-o", text(&pair)]).done();
        pair
    })
}

const MOVE: &str = "rig_from_moved = { rpy_deg = [0, 0, 0], translation_m = [0, 0, -0.3] }\n";

/// Solves with a further pair that a file of this text describes beside the pair's images.
fn also(name: &str, content: &str, more: &[&str]) -> Run {
    let file = heaved().join(format!("{name}.toml"));
    std::fs::write(&file, content).unwrap();
    solve(&[&["--also", text(&file), "--json"], more].concat())
}

fn described(rest: &str) -> String {
    format!("schema = 1\nleft = \"left.png\"\nright = \"right.png\"\n{rest}")
}

fn depth_sigma_m(answer: &Value) -> f64 {
    answer["observability"]["depth_sigma_m"].as_f64().unwrap()
}

#[test]
fn a_further_pair_makes_the_rod_surer() {
    let one = solve(&["--json"]).json();
    let two = also("plain", &described(MOVE), &[]).json();
    assert_eq!(two["status"], "ok", "{two}");
    assert!(
        depth_sigma_m(&two) < 0.9 * depth_sigma_m(&one),
        "{one} {two}"
    );
    // A rig that was calibrated where it went says the same.
    let still = "rig_from_moved = { rpy_deg = [0, 0, 0], translation_m = [0, 0, 0] }\n";
    let of_rig = described(&format!("rig = \"rig.toml\"\n{still}"));
    let same = also("of_rig", &of_rig, &[]).json();
    let off = (depth_sigma_m(&same) / depth_sigma_m(&two) - 1.0).abs();
    assert!(off < 1e-6, "{off}");
    // Who is not sure of the move is less sure of the rod.
    let doubtful = "sigma = { translation_m = 0.01, rotation_deg = 0.2 }\n";
    let doubtful = also("doubtful", &described(&format!("{MOVE}{doubtful}")), &[]).json();
    let times = depth_sigma_m(&doubtful) / depth_sigma_m(&two);
    assert!((1.01..3.0).contains(&times), "{times}: {doubtful}");
}

#[test]
fn a_wrong_move_is_refused() {
    let wrong = MOVE.replace("[0, 0, -0.3]", "[0, 0.04, -0.3]");
    let run = also("wrong", &described(&wrong), &[]);
    assert_eq!(run.code, 3, "{run:?}");
    let answer: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(
        answer["observability"]["refusal"], "pairs_contradict",
        "{answer}"
    );
}

#[test]
fn files_that_are_none_say_what_was_expected() {
    let fails = |name: &str, content: &str, says: &[&str]| {
        let file = format!("{name}.toml");
        also(name, content, &[]).failed(2, &[&[file.as_str()], says].concat());
    };
    fails("empty", "", &["schema"]);
    fails(
        "other",
        &described(MOVE).replace("= 1", "= 2"),
        &["schema: expected 1, found 2"],
    );
    fails(
        "key",
        &described(&format!("{MOVE}sigmas = 1\n")),
        &["sigmas"],
    );
    fails(
        "none",
        &described("rig_from_moved = { translation_m = [0, 0, 0] }\n"),
        &["rig_from_moved.rotation: expected exactly one of"],
    );
    fails(
        "sigma",
        &described(&format!(
            "{MOVE}sigma = {{ translation_m = -1, rotation_deg = 0 }}\n"
        )),
        &["sigma.translation_m: expected a standard deviation, 0 or more, found -1"],
    );
    let region = "[roi_left]\nx_px = 0\ny_px = 0\nwidth_px = 481\nheight_px = 1\n";
    let region = described(&format!("{MOVE}{region}"));
    also("region", &region, &[]).failed(2, &["pair 2: left region: expected"]);
    let lost = described(MOVE).replace("left.png", "lost.png");
    also("lost", &lost, &[]).failed(2, &["lost.png"]);
    let small = heaved().join("small.png");
    image::RgbImage::new(32, 32).save(&small).unwrap();
    let size = described(MOVE).replace("left.png", text(&small));
    fails("size", &size, &["small.png", "32"]);
    solve(&["--also", "nowhere.toml"]).failed(2, &["nowhere.toml"]);
}

#[test]
fn methods_of_one_pair_say_so() {
    for method in ["paper", "paper-bisector"] {
        also("method", &described(MOVE), &["--method", method])
            .failed(2, &["--also", method, "expected --method joint"]);
    }
}
