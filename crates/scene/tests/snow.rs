//! Marine snow in scene files.

use std::path::Path;

use rodsight_scene::{Scene, SceneFile, Snow};

fn scene_path() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/paper.toml")
}

fn load(table: &str) -> Result<Scene, String> {
    let path = scene_path();
    let text = std::fs::read_to_string(&path).expect("shipped");
    Scene::from_toml(&format!("{text}\n[snow]\n{table}\n"), &path).map_err(|e| e.to_string())
}

#[test]
fn snow_has_defaults_and_reads_back() {
    let scene = load("number_per_m3 = 1000").expect("a scene");
    let snow = scene.snow.expect("snow");
    assert_eq!(
        snow,
        Snow {
            number_per_m3: 1000.0,
            diameter_m: [5e-4, 5e-3],
            exponent: 3.0,
            albedo: [0.3; 3],
            range_m: [0.15, 5.0],
            seed: None,
        }
    );
    let resolved = SceneFile::from_scene(&scene).to_toml();
    let again = Scene::from_toml(&resolved, &scene_path()).expect("a resolved scene loads");
    assert_eq!(again.snow, scene.snow);
    let seeded = load("number_per_m3 = 2\nseed = 7").expect("a scene");
    assert_eq!(seeded.snow.and_then(|snow| snow.seed), Some(7));
}

#[test]
fn bad_snow_is_refused_with_key_and_reason() {
    for (table, key, expected) in [
        ("", "number_per_m3", "missing"),
        ("number_per_m3 = -1", "snow.number_per_m3", "> 0"),
        (
            "number_per_m3 = 1e9",
            "snow.number_per_m3",
            "at most 190986 to a distance of 5 m",
        ),
        (
            "number_per_m3 = 1\ndiameter_m = [1e-5, 1e-3]",
            "snow.diameter_m[0]",
            "2e-4",
        ),
        (
            "number_per_m3 = 1\ndiameter_m = [2e-3, 1e-3]",
            "snow.diameter_m[1]",
            "0.002",
        ),
        (
            "number_per_m3 = 1\nexponent = nan",
            "snow.exponent",
            "between 0 and 6",
        ),
        (
            "number_per_m3 = 1\nalbedo = [0.1, 0.1, 1.1]",
            "snow.albedo[2]",
            "between 0 and 1",
        ),
        (
            "number_per_m3 = 1\nrange_m = [0.001, 3]",
            "snow.range_m[0]",
            "largest diameter",
        ),
        (
            "number_per_m3 = 1\nrange_m = [2, 1]",
            "snow.range_m[1]",
            "more than the nearest, 2",
        ),
        ("number_per_m3 = 1\nnumber = 3", "number", "number_per_m3"),
    ] {
        let message = load(table).expect_err(table);
        assert!(
            message.contains(key) && message.contains(expected),
            "{message}"
        );
    }
}

/// Quantiles of d^(−q): their moments are those of the integrals ∫ d^(m−q) / ∫ d^(−q).
#[test]
fn diameters_follow_the_power_law() {
    let (from, to): (f64, f64) = (5e-4, 5e-3);
    for exponent in [0.0, 1.0, 2.0, 3.0, 4.5] {
        let snow = Snow {
            exponent,
            ..load("number_per_m3 = 1")
                .expect("a scene")
                .snow
                .expect("snow")
        };
        let integral = |power: f64| {
            if (power + 1.0).abs() < 1e-9 {
                libm::log(to / from)
            } else {
                (libm::pow(to, power + 1.0) - libm::pow(from, power + 1.0)) / (power + 1.0)
            }
        };
        let steps = 100_000;
        for moment in [1.0, 2.0] {
            let sum: f64 = (0..steps)
                .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
                .map(|share| libm::pow(snow.diameter_quantile_m(share), moment))
                .sum();
            let expected = integral(moment - exponent) / integral(-exponent);
            let found = sum / f64::from(steps);
            assert!(
                (found / expected - 1.0).abs() < 1e-4,
                "{exponent} {moment}: {found} {expected}"
            );
        }
    }
}
