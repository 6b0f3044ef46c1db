//! What is written is read back to the bit.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Eye, Image, Samples, Vec3};
use rodsight_render::{
    CpuRenderer, PairPaths, Renderer, Truth, develop, read_exr, read_image, write_image,
    write_jpeg, write_pair,
};
use rodsight_scene::{ImageFormat, Output, Scene};

fn scene() -> Scene {
    let mut scene = common::wet(16);
    scene.rods.push(common::orange_rod(
        Vec3::new(2.2, -0.1, -0.9),
        Vec3::new(0.2, 0.3, 1.0),
        0.05,
    ));
    scene
}

/// As bits: +∞ is equal to itself, and so would NaN be.
fn bits(frame: &rodsight_render::EyeFrame) -> Vec<u32> {
    frame
        .pixels
        .iter()
        .flat_map(common::numbers)
        .map(f32::to_bits)
        .collect()
}

#[test]
fn pair_is_read_back_to_the_bit() {
    let scene = scene();
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let paths: PairPaths =
        write_pair(folder.path(), &scene, Some(&frame), &developed, &truth).unwrap();
    for (eye, exr, png) in [
        (Eye::Left, &paths.left_exr, &paths.left_image),
        (Eye::Right, &paths.right_exr, &paths.right_image),
    ] {
        let back = read_exr(exr).unwrap();
        assert_eq!(
            (back.width_px, back.height_px),
            (frame.eye(eye).width_px, frame.eye(eye).height_px)
        );
        assert!(bits(&back) == bits(frame.eye(eye)), "{}", eye.name());
        assert_eq!(&read_image(png).unwrap(), developed.eye(eye));
    }
    let text = std::fs::read_to_string(&paths.truth_json).unwrap();
    let back: Truth = serde_json::from_str(&text).unwrap();
    assert_eq!(back, truth);
    let left_over: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .filter(|name| name.to_string_lossy().ends_with(".part"))
        .collect();
    assert!(left_over.is_empty(), "{left_over:?}");
}

#[test]
fn channels_of_the_exr_are_these() {
    let scene = scene();
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let paths = write_pair(folder.path(), &scene, Some(&frame), &developed, &truth).unwrap();
    let meta = exr::meta::MetaData::read_from_file(&paths.left_exr, true).unwrap();
    let channels = &meta.headers[0].channels.list;
    let names: Vec<String> = channels
        .iter()
        .map(|c| format!("{} {:?}", c.name, c.sample_type))
        .collect();
    assert_eq!(
        names,
        [
            "B F32",
            "G F32",
            "R F32",
            "backscatter.B F32",
            "backscatter.G F32",
            "backscatter.R F32",
            "beyond_model U32",
            "clean.B F32",
            "clean.G F32",
            "clean.R F32",
            "depth_m F32",
            "direct.B F32",
            "direct.G F32",
            "direct.R F32",
            "disparity_px F32",
            "forward.B F32",
            "forward.G F32",
            "forward.R F32",
            "instance U32",
            "material U32",
            "normal.X F32",
            "normal.Y F32",
            "normal.Z F32",
            "occluded U32",
            "range_m F32",
            "snow.B F32",
            "snow.G F32",
            "snow.R F32",
            "snow_cover F32",
            "transmission.B F32",
            "transmission.G F32",
            "transmission.R F32",
        ]
    );
}

#[test]
fn images_of_all_kinds_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = rodsight_testkit::SplitMix64::new(3);
    for channels in [1_u8, 3] {
        let count = 37 * 21 * usize::from(channels);
        let narrow = Samples::U8((0..count).map(|_| rng.next_u64() as u8).collect());
        let wide = Samples::U16((0..count).map(|_| rng.next_u64() as u16).collect());
        for samples in [narrow, wide] {
            let image = Image::new(37, 21, channels, samples).unwrap();
            let path = folder.path().join("image.png");
            write_image(&path, &image).unwrap();
            assert_eq!(read_image(&path).unwrap(), image);
        }
    }
}

#[test]
fn files_that_are_none_of_ours_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "no image").unwrap();
    for message in [
        read_image(&path).unwrap_err().to_string(),
        read_exr(&path).unwrap_err().to_string(),
        read_exr(&folder.path().join("gone.exr"))
            .unwrap_err()
            .to_string(),
    ] {
        assert!(
            message.contains("notes.txt") || message.contains("gone.exr"),
            "{message}"
        );
    }
}

/// JPEG images and raw codes beside them; a later run in the other format leaves no image of this one.
#[test]
fn jpeg_and_raw_images_are_written_and_taken_away_again() {
    let mut scene = scene();
    scene.bits = 8;
    scene.output = Output {
        format: ImageFormat::Jpeg,
        jpeg_quality: 95,
        raw: true,
    };
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let developed = develop(&frame, &scene).unwrap();
    let truth = Truth::of(&scene, &frame, developed.gain).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let paths = write_pair(folder, &scene, None, &developed, &truth).unwrap();
    assert_eq!(paths.left_image, folder.join("left.jpg"));
    assert_eq!(PairPaths::found_in(folder).right_image, paths.right_image);
    let back = read_image(&paths.right_image).unwrap();
    let (Samples::U8(back), Samples::U8(sent)) = (back.samples(), developed.right.samples()) else {
        panic!("8 bits")
    };
    let differences = back
        .iter()
        .zip(sent)
        .map(|(a, b)| f64::from(a.abs_diff(*b)));
    let mean = differences.sum::<f64>() / sent.len() as f64;
    assert!(mean > 0.0 && mean < 4.0, "{mean}");
    let raw = developed.raw.as_ref().unwrap();
    assert_eq!(&read_image(&paths.left_raw).unwrap(), &raw[0]);

    scene.output = Output::default();
    let developed = develop(&frame, &scene).unwrap();
    write_pair(folder, &scene, None, &developed, &truth).unwrap();
    for gone in [
        &paths.left_image,
        &paths.right_image,
        &paths.left_raw,
        &paths.right_raw,
    ] {
        assert!(!gone.exists(), "{}", gone.display());
    }
    assert_eq!(
        PairPaths::found_in(folder).left_image,
        folder.join("left.png")
    );

    let wide = Image::new(2, 1, 1, Samples::U16(vec![1, 2])).unwrap();
    let error = write_jpeg(&folder.join("wide.jpg"), &wide, 90).unwrap_err();
    assert!(
        error.to_string().contains("expected an image of 8 bits"),
        "{error}"
    );
}
