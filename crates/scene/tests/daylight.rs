//! Daylight in scene files.

use std::path::{Path, PathBuf};

use rodsight_scene::{Scene, SceneFile};

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/paper.toml")
}

fn load(table: &str) -> Result<Scene, String> {
    let text = std::fs::read_to_string(path()).expect("shipped");
    let text = format!("{text}\n[daylight]\n{table}\n");
    Scene::from_toml(&text, &path()).map_err(|error| error.to_string())
}

#[test]
fn daylight_comes_down_to_the_rig_and_reads_back() {
    let table =
        "irradiance_w_per_m2 = [1, 2, 3]\ndepth_m = 10\ndiffuse_attenuation_per_m = [0.3, 0.1, 0]";
    let scene = load(table).expect("a scene");
    let daylight = scene.daylight.expect("daylight");
    for (found, expected) in
        daylight
            .irradiance_w_per_m2
            .into_iter()
            .zip([libm::exp(-3.0), 2.0 * libm::exp(-1.0), 3.0])
    {
        assert!((found / expected - 1.0).abs() < 1e-14, "{found}");
    }
    let resolved = SceneFile::from_scene(&scene).to_toml();
    let again = Scene::from_toml(&resolved, &path()).expect("a resolved scene loads");
    assert_eq!(again.daylight, scene.daylight);
    // Kirk: 525 nm of IB.
    let kirk = load("irradiance_w_per_m2 = [1, 1, 1]")
        .expect("a scene")
        .daylight;
    let [_, green, _] = kirk.expect("daylight").diffuse_attenuation_per_m;
    assert!((green - (0.0516_f64.powi(2) + 0.256 * 0.0516 * 0.125).sqrt()).abs() < 1e-12);
}

#[test]
fn bad_daylight_is_refused_with_key_and_reason() {
    for (table, key) in [
        ("depth_m = 3", "irradiance_w_per_m2"),
        (
            "irradiance_w_per_m2 = [1, -1, 1]",
            "daylight.irradiance_w_per_m2[1]",
        ),
        (
            "irradiance_w_per_m2 = [1, 1, 1]\ndepth_m = -1",
            "daylight.depth_m",
        ),
        (
            "irradiance_w_per_m2 = [1, 1, 1]\ndiffuse_attenuation_per_m = [nan, 0, 0]",
            "daylight.diffuse_attenuation_per_m[0]",
        ),
    ] {
        let message = load(table).expect_err(table);
        assert!(
            message.contains(key) && message.contains("expected") || message.contains("missing"),
            "{message}"
        );
    }
}
