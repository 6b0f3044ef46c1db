//! The keys between radiance and files: lens, motion, colour filters, output.

use std::path::PathBuf;

use rodsight_scene::{
    Aperture, BayerPattern, Demosaic, ImageFormat, Lens, Output, Scene, SceneFile, Sensor,
};

const SMALL: &str = r#"
schema = 1
id = "small"
mode = "air"
rig_file = "rigs/paper.toml"
KEYS

[[rod]]
id = "cable"
centre_m = [2.3, 0, -0.9]
direction = [0, 0, 2]
length_m = 2
radius_m = 0.05
albedo = [0.8, 0.4, 0.1]

[target]
rod = "cable"
"#;

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/x.toml")
}

fn load(keys: &str) -> Result<Scene, String> {
    Scene::from_toml(&SMALL.replace("KEYS", keys), &path()).map_err(|error| error.to_string())
}

#[test]
fn absent_keys_are_a_perfect_camera_and_are_not_written() {
    let scene = load("").unwrap();
    assert_eq!(scene.lens, Lens::default());
    assert!(scene.motion.is_none() && scene.colour_matrix.is_none());
    assert_eq!(scene.output, Output::default());
    let text = SceneFile::from_scene(&scene).to_toml();
    for key in ["lens", "motion", "colour_matrix", "output", "bayer"] {
        assert!(!text.contains(key), "{key}");
    }
}

#[test]
fn every_key_is_read_and_comes_back_to_the_last_bit() {
    let scene = load(
        "colour_matrix = [[1.6, -0.5, -0.1], [-0.2, 1.4, -0.2], [0.0, -0.6, 1.6]]\n\
         [lens]\nvignetting = [-0.1, 0.02]\npsf_sigma_px = 0.6\n\
         aperture = { f_number = 2.8, focal_length_m = 0.008, focus_m = 2.3 }\n\
         [motion]\nexposure_s = 0.01\nvelocity_m_per_s = [0.3, 0, -0.1]\nturn_deg_per_s = [1, 2.3, -7]\n\
         [sensor.emva]\nbayer = { pattern = \"gbrg\", demosaic = \"bilinear\" }\n\
         [output]\nformat = \"jpeg\"\njpeg_quality = 85\nraw = true\n",
    )
    .unwrap();
    assert_eq!(
        scene.lens.aperture,
        Some(Aperture {
            f_number: 2.8,
            focal_length_m: 0.008,
            focus_m: 2.3
        })
    );
    let motion = scene.motion.unwrap();
    assert!((motion.turn_rad_per_s.z + 0.122_173_047_639_603_06).abs() < 1e-16);
    let Sensor::Emva(emva) = scene.sensor else {
        panic!("{:?}", scene.sensor)
    };
    let bayer = emva.bayer.unwrap();
    assert_eq!(
        (bayer.pattern, bayer.demosaic),
        (BayerPattern::Gbrg, Demosaic::Bilinear)
    );
    assert_eq!(scene.output.format, ImageFormat::Jpeg);
    let text = SceneFile::from_scene(&scene).to_toml();
    let again = Scene::from_toml(&text, &path()).unwrap();
    assert_eq!(format!("{scene:?}"), format!("{again:?}"));
}

#[test]
fn messages_name_key_expected_and_found() {
    for (keys, parts) in [
        (
            "[lens]\nvignetting = [-1.5, 0.2]",
            ["lens.vignetting", ">= 0 for r up to 1", "-0.3"],
        ),
        (
            "[lens]\nvignetting = [nan, 0]",
            ["lens.vignetting[0]", "within -10 to 10", "NaN"],
        ),
        (
            "[lens]\npsf_sigma_px = -1",
            ["lens.psf_sigma_px", "between 0 and 100", "-1"],
        ),
        (
            "[lens]\npsf_sigma = 1",
            ["psf_sigma", "did you mean `psf_sigma_px`", "psf_sigma"],
        ),
        (
            "[lens]\naperture = { f_number = 0, focal_length_m = 0.008, focus_m = 2 }",
            ["lens.aperture.f_number", "between 0.5 and 256", "found 0"],
        ),
        (
            "[lens]\naperture = { f_number = 2, focal_length_m = 8, focus_m = 2 }",
            ["lens.aperture.focal_length_m", "8 mm is 0.008", "found 8"],
        ),
        (
            "[lens]\naperture = { f_number = 2, focal_length_m = 0.008, focus_m = 0.008 }",
            [
                "lens.aperture.focus_m",
                "more than the focal length",
                "found 0.008",
            ],
        ),
        (
            "[motion]\nexposure_s = 0",
            ["motion.exposure_s", "> 0", "found 0"],
        ),
        (
            "[motion]\nexposure_s = 0.01\nvelocity_m_per_s = [0, 1e4, 0]",
            ["motion.velocity_m_per_s[1]", "within -100 to 100", "10000"],
        ),
        (
            "[motion]\nexposure_s = 0.01\nturn_deg_per_s = [0, inf, 0]",
            ["motion.turn_deg_per_s[1]", "within", "inf"],
        ),
        (
            "colour_matrix = [[1, 0, 0], [0, 1, 0], [0, 0.5, 1]]",
            ["colour_matrix[2]", "sum to 1", "1.5"],
        ),
        (
            "[sensor.emva]\nbayer = { pattern = \"rgbg\" }",
            ["sensor.emva", "`rggb`", "rgbg"],
        ),
        (
            "[output]\njpeg_quality = 0",
            ["output.jpeg_quality", "1 to 100", "found 0"],
        ),
        (
            "[output]\nformat = \"tiff\"",
            ["output.format", "`png` or `jpeg`", "tiff"],
        ),
        (
            "bits = 16\n[output]\nformat = \"jpeg\"",
            ["output.format", "\"png\" with bits = 16", "\"jpeg\""],
        ),
        (
            "[output]\nraw = true",
            ["output.raw", "[sensor.emva]", "[sensor.plain]"],
        ),
    ] {
        let message = load(keys).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{keys}\n{message}\n{part}");
        }
    }
}
