//! Images, rigs and parameters that cannot be used: code 2 and a message that names the file, what was expected, what was found.

use std::path::Path;

use image::{DynamicImage, GrayImage, RgbImage};

use crate::harness::{folder, pair, solve, text};

/// What may stand where an image should, and what is said of it.
fn bad_images(folder: &Path) -> Vec<(std::path::PathBuf, Vec<&'static str>)> {
    let good = std::fs::read(pair().join("left.png")).unwrap();
    let mut corrupt = good.clone();
    corrupt[good.len() / 2] ^= 0x55;
    let small = folder.join("small.png");
    RgbImage::new(12, 8).save(&small).unwrap();
    // A header that promises thirty gigabytes.
    let mut huge = good.clone();
    huge[16..24].copy_from_slice(&[0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0]);
    let checksum = crc32(&huge[12..29]);
    huge[29..33].copy_from_slice(&checksum.to_be_bytes());
    let expected = "expected a PNG or JPEG image, found";
    let mut cases = vec![
        (folder.join("missing.png"), vec!["No such file"]),
        (folder.to_owned(), vec!["directory"]),
        (pair().join("left.exr"), vec![expected, "OpenExr"]),
        (pair().join("rig.toml"), vec![expected, "something else"]),
        (
            small,
            vec!["expected 480×270 px as in the rig, found 12×8", "rig.toml"],
        ),
    ];
    for (name, bytes, says) in [
        ("empty.png", &[][..], vec![expected, "something else"]),
        (
            "text.png",
            b"left = \"right\"\n",
            vec![expected, "something else"],
        ),
        (
            "truncated.png",
            &good[..good.len() / 2],
            vec![expected, "a broken one"],
        ),
        ("header.png", &good[..20], vec![expected, "a broken one"]),
        ("corrupt.png", &corrupt, vec![expected, "a broken one"]),
        (
            "huge.png",
            &huge,
            vec!["expected at most", "found 100000×100000"],
        ),
        (
            "stump.jpg",
            b"\xff\xd8\xff\xe0\x00\x10JFIF\x00",
            vec![expected, "a broken one"],
        ),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        cases.push((path, says));
    }
    cases
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| {
        if crc & 1 == 1 {
            (crc >> 1) ^ 0xedb8_8320
        } else {
            crc >> 1
        }
    };
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), step)
    })
}

#[test]
fn bad_image_is_named_whichever_eye_it_is_for() {
    let folder = folder();
    for (path, says) in bad_images(folder.path()) {
        for eye in ["--left", "--right"] {
            let trace = folder.path().join("trace");
            let run = solve(&[
                eye,
                text(&path),
                "--json",
                "--method",
                "paper",
                "--trace",
                text(&trace),
            ]);
            run.failed(2, &[&[text(&path)][..], &says].concat());
            assert!(!trace.exists());
        }
    }
}

type Convert = fn(&DynamicImage) -> DynamicImage;

#[test]
fn image_of_any_common_kind_is_accepted() {
    let folder = folder();
    let save = |name: &str, image: &DynamicImage| {
        let path = folder.path().join(name);
        image.save(&path).unwrap();
        text(&path).to_owned()
    };
    let both = ["left", "right"].map(|eye| image::open(pair().join(format!("{eye}.png"))).unwrap());
    let [left, right] = &both;
    let kinds: [(&str, Convert); 5] = [
        ("grey.png", |i| i.to_luma8().into()),
        ("grey16.png", |i| i.to_luma16().into()),
        ("rgb16.png", |i| i.to_rgb16().into()),
        ("rgba.png", |i| i.to_rgba8().into()),
        ("grey_alpha.png", |i| i.to_luma_alpha8().into()),
    ];
    for (name, convert) in kinds {
        let [left, right] = [("l", left), ("r", right)]
            .map(|(eye, image)| save(&format!("{eye}_{name}"), &convert(image)));
        let run = solve(&["--left", &left, "--right", &right, "--json"]);
        // A grey rod against grey sand may be refused, with a reason, but it is no error.
        assert!(
            run.err.is_empty() && matches!(run.code, 0 | 3),
            "{name}: {run:?}"
        );
        assert!(name.starts_with("grey") || run.code == 0, "{name}: {run:?}");
    }
    // One eye grey, the other in colour.
    let grey = save("one.png", &GrayImage::from(left.to_luma8()).into());
    assert!(matches!(solve(&["--left", &grey, "--json"]).code, 0 | 3));
}

#[test]
fn exchanged_images_are_refused_or_far_off_but_no_error() {
    let file = |name: &str| text(&pair().join(name)).to_owned();
    let run = solve(&[
        "--left",
        &file("right.png"),
        "--right",
        &file("left.png"),
        "--pick",
        "100,150",
        "--json",
    ]);
    assert_eq!((run.code, run.err.as_str()), (3, ""), "{run:?}");
}

#[test]
fn bad_rig_is_named_with_its_key() {
    let folder = folder();
    let good = std::fs::read_to_string(pair().join("rig.toml")).unwrap();
    let exchanged = good
        .replace("[left", "[middle")
        .replace("[right", "[left")
        .replace("[middle", "[right");
    let once = |from: &str, to: &str| {
        assert!(good.contains(from), "{from} in {good}");
        good.replacen(from, to, 1)
    };
    let cases: [(&str, String, &[&str]); 15] = [
        (
            "nan.toml",
            once("fx_px = 391.644404911", "fx_px = nan"),
            &["left.fx_px", "NaN"],
        ),
        (
            "negative.toml",
            once("fx_px = 391.644404911", "fx_px = -391.6"),
            &["left.fx_px", "-391.6"],
        ),
        (
            "skew.toml",
            once("0.0, 0.0, 1.0", "0.1, 0.0, 1.0"),
            &["left.rig_from_camera.rotation", "orthonormal"],
        ),
        (
            "mirror.toml",
            once("0.0, 0.0, 1.0", "0.0, 0.0, -1.0"),
            &[
                "left.rig_from_camera.rotation",
                "right-handed",
                "determinant -1",
            ],
        ),
        (
            "nan_r.toml",
            once("0.0, 0.0, 1.0", "0.0, 0.0, nan"),
            &["left.rig_from_camera.rotation", "NaN"],
        ),
        (
            "inf_t.toml",
            once("translation_m = [0.0", "translation_m = [inf"),
            &["left.rig_from_camera.translation_m", "finite", "inf"],
        ),
        (
            "exchanged.toml",
            exchanged,
            &["right.rig_from_camera", "are left and right exchanged?"],
        ),
        (
            "same.toml",
            good.replace("-0.5", "0.5"),
            &["different places", "the same place"],
        ),
        (
            "mm.toml",
            good.replace("0.5, ", "500.0, "),
            &["at most 20 m", "millimetres"],
        ),
        (
            "unknown.toml",
            once("fx_px", "fx_pix"),
            &["unknown field `fx_pix`", "did you mean `fx_px`?"],
        ),
        (
            "none.toml",
            once("cy_px", "# cy_px"),
            &["missing field `cy_px`"],
        ),
        (
            "schema.toml",
            once("schema = 1", "schema = 7"),
            &["schema: expected 1, found 7"],
        ),
        ("broken.toml", "left = [".to_owned(), &[":1"]),
        (
            "empty.yaml",
            String::new(),
            &["OpenCV", "Kalibr", "no keys"],
        ),
        (
            "rig.json",
            good.clone(),
            &["expected a rig file (.toml)", "found .json"],
        ),
    ];
    for (name, content, says) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        solve(&["--rig", text(&path)]).failed(2, &[&[text(&path)][..], says].concat());
    }
    let missing = folder.path().join("no.toml");
    solve(&["--rig", text(&missing)]).failed(2, &[text(&missing), "No such file"]);
    let binary = pair().join("left.png");
    solve(&["--rig", text(&binary)]).failed(2, &[text(&binary), "expected a rig file"]);
}

#[test]
fn bad_calibration_of_other_tools_is_named_with_its_key() {
    let folder = folder();
    let kalibr = "cam0:\n  camera_model: omni\n  intrinsics: [1, 1, 1, 1]\n  resolution: [480, 270]\ncam1:\n  T_cn_cnm1: [1]\n";
    let opencv = "M1: [1, 2, 3]\nD1: [0, 0, 0, 0]\nimage_width: 480\nimage_height: 270\n";
    for (name, content, says) in [
        (
            "camchain.yaml",
            kalibr,
            ["cam0.camera_model", "expected pinhole, found \"omni\""],
        ),
        ("stereo.yml", opencv, ["M1", "3×3 camera matrix"]),
        ("broken.yml", "a: [1, 2\nb: }", ["broken.yml:", ""]),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        solve(&["--rig", text(&path)]).failed(2, &[&[text(&path)][..], &says].concat());
    }
}

#[test]
fn bad_parameters_are_named_with_their_file() {
    let folder = folder();
    let path = folder.path().join("params.toml");
    for (content, says) in [
        (
            "canny_lo = 3.0",
            ["unknown field `canny_lo`", "did you mean `canny_low`?"],
        ),
        (
            "canny_low = -3.0",
            ["canny_low: expected a positive number", "found -3"],
        ),
        ("canny_low = nan", ["canny_low", "NaN"]),
        (
            "hough_threshold = { votes = -1 }",
            ["votes", "hough_threshold"],
        ),
        (
            "hough_theta_step_deg = 1e-9",
            ["hough_theta_step_deg: expected 0.02 to 45", "found"],
        ),
        (
            "segmentation = \"magic\"",
            ["unknown variant `magic`", "`otsu`"],
        ),
        ("min_support = 99999999999999999999", ["min_support", ":1"]),
        ("= 3", ["params.toml:1", ""]),
    ] {
        std::fs::write(&path, content).unwrap();
        solve(&["--method", "paper", "--params", text(&path)])
            .failed(2, &[&[text(&path)][..], &says].concat());
    }
}
