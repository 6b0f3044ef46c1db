//! Images made on the adapter against what `develop` makes of the same adapter's radiance, sample by sample.
//!
//! Without an adapter these tests say that they were skipped, and pass; with `RODSIGHT_REQUIRE_GPU=1` they fail.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    clippy::print_stdout,
    reason = "helpers of tests may panic, and say how well it went"
)]

mod common;

use rodsight_geometry::{Camera, Distortion, Eye, Image, Intrinsics, Samples};
use rodsight_render::{
    CpuRenderer, Developed, Frame, GpuRenderer, RenderError, Renderer, develop, expose,
};
use rodsight_scene::{
    Aperture, Bayer, BayerPattern, Demosaic, EdgeSampling, Emva, Exposure, Mode, Output, Scene,
    Sensor,
};
use rodsight_testkit::{Tolerance, compare_images};

/// Of 8 bits: all within 1, and of a thousand pixels one.
const EIGHT_BITS: f64 = 1e-3;
/// Of 16 bits: all within 1, and of a hundred pixels one, as a digit is 1.5e-5 of full scale and the light has its rounding of 6e-8 several
/// times.
const SIXTEEN_BITS: f64 = 0.01;

fn samples(image: &Image) -> Vec<f32> {
    match image.samples() {
        Samples::U8(values) => values.iter().map(|v| f32::from(*v)).collect(),
        Samples::U16(values) => values.iter().map(|v| f32::from(*v)).collect(),
    }
}

fn compare_image(actual: &Image, expected: &Image) -> Result<String, String> {
    let differing = match expected.samples() {
        Samples::U8(_) => EIGHT_BITS,
        Samples::U16(_) => SIXTEEN_BITS,
    };
    let shape = [
        expected.height_px(),
        expected.width_px(),
        expected.channels().into(),
    ];
    let compare = |max_abs, bad_fraction| {
        let tolerance = Tolerance {
            max_rel: 0.0,
            max_abs,
            bad_fraction,
            bounded_by: "f32 against f64, then rounded to whole numbers",
        };
        let shape = shape.map(|size| size as usize);
        compare_images(&samples(actual), &samples(expected), shape, tolerance)
            .map_err(|error| error.to_string())
    };
    compare(1.0, 0.0)?;
    let report = compare(0.0, differing)?;
    Ok(format!("{} of {}", report.bad_pixels, report.pixels))
}

fn compare(actual: &Developed, expected: &Developed) -> Result<String, String> {
    if (actual.gain / expected.gain - 1.0).abs() > 1e-6 {
        return Err(format!("gain {} instead of {}", actual.gain, expected.gain));
    }
    let mut pairs: Vec<(&Image, &Image)> = Eye::BOTH
        .iter()
        .map(|&eye| (actual.eye(eye), expected.eye(eye)))
        .collect();
    match (&actual.raw, &expected.raw) {
        (Some(actual), Some(expected)) => pairs.extend(actual.iter().zip(expected)),
        (None, None) => {}
        _ => return Err("raw images of one alone".to_owned()),
    }
    let reports: Result<Vec<String>, String> = pairs
        .iter()
        .map(|(actual, expected)| compare_image(actual, expected))
        .collect();
    reports.map(|reports| reports.join(", "))
}

fn long_way(gpu: &GpuRenderer, scene: &Scene) -> Result<Developed, RenderError> {
    develop(&expose(gpu, scene, &|_| ())?, scene)
}

fn check(gpu: &GpuRenderer, name: &str, scene: &Scene) -> [Developed; 2] {
    let actual = gpu.shoot(scene, &|_| ()).unwrap();
    let expected = long_way(gpu, scene).unwrap();
    match compare(&actual, &expected) {
        Ok(report) => println!("{name}: {report} pixels differ"),
        Err(message) => panic!("{name} on {}: {message}", gpu.adapter()),
    }
    [actual, expected]
}

fn shipped(name: &str) -> Scene {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scene = common::shrunk(Scene::load(&folder.join(name)).unwrap(), 8);
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 21 };
    scene
}

fn emva(scene: &mut Scene) -> &mut Emva {
    let Sensor::Emva(emva) = &mut scene.sensor else {
        panic!("another sensor");
    };
    emva
}

/// Some rods in turbid water, through colour filters with a matrix, raw images too.
fn mosaic(pattern: BayerPattern, demosaic: Demosaic) -> Scene {
    let mut scene = shipped("crossing_rods.toml");
    emva(&mut scene).bayer = Some(Bayer { pattern, demosaic });
    scene.colour_matrix = Some([[1.4, -0.3, -0.1], [-0.2, 1.3, -0.1], [0.0, -0.4, 1.4]]);
    scene.output = Output {
        raw: true,
        ..scene.output
    };
    scene
}

/// Noise on 16 bits behind a blurring lens with dark corners.
fn plain() -> Scene {
    let mut scene = shipped("paper.toml");
    scene.sensor = Sensor::Plain {
        noise_sigma_dn: 2.0,
    };
    scene.bits = 16;
    scene.lens.vignetting = Some([-0.3, 0.05]);
    scene.lens.psf_sigma_px = 0.8;
    scene
}

/// Fewer pixels than a word's or a workgroup's worth makes whole.
fn tiny(mut scene: Scene) -> Scene {
    let intrinsics = Intrinsics {
        width_px: 37,
        height_px: 23,
        fx_px: 30.0,
        fy_px: 30.0,
        cx_px: 18.5,
        cy_px: 11.5,
    };
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        mounted.camera = Camera::new(intrinsics, Distortion::None).unwrap();
    }
    scene
}

#[test]
fn images_are_those_of_the_long_way() {
    let Some(gpu) = common::gpu() else { return };
    for name in [
        "paper.toml",
        "snowstorm.toml",
        "flat_port.toml",
        "sunlit_pipe.toml",
    ] {
        let [actual, expected] = check(&gpu, name, &shipped(name));
        // Between radiance and the sample that is picked nothing is computed but a product.
        assert_eq!(actual.gain, expected.gain, "{name}");
    }
    check(&gpu, "plain, 16 bits", &plain());
    check(&gpu, "plain, 16 bits, tiny", &tiny(plain()));
    let shown = |pattern, demosaic| {
        let scene = mosaic(pattern, demosaic);
        for (size, scene) in [("tiny", tiny(scene.clone())), ("", scene)] {
            let [images, _] = check(&gpu, &format!("{pattern:?} {demosaic:?} {size}"), &scene);
            assert!(images.raw.is_some());
        }
    };
    shown(BayerPattern::Rggb, Demosaic::Malvar);
    shown(BayerPattern::Gbrg, Demosaic::Bilinear);
}

/// The sample of any rank is the one that sorting finds.
#[test]
fn exposure_is_exact_at_any_quantile_and_dark_where_there_is_no_light() {
    let Some(gpu) = common::gpu() else { return };
    let mut scene = tiny(shipped("paper.toml"));
    let mut gains = Vec::new();
    for quantile in [1e-9, 0.01, 0.37, 0.5, 0.99, 1.0] {
        scene.exposure = Exposure::Auto {
            quantile,
            level: 0.8,
        };
        let gain = gpu.shoot(&scene, &|_| ()).unwrap().gain;
        assert_eq!(gain, long_way(&gpu, &scene).unwrap().gain, "{quantile}");
        gains.push(gain);
    }
    assert!(gains.is_sorted_by(|a, b| a > b), "{gains:?}");
    scene.lamps.clear();
    let error = gpu.shoot(&scene, &|_| ()).unwrap_err();
    assert!(matches!(error, RenderError::Dark { .. }), "{error}");
    scene.exposure = Exposure::Fixed(2.0);
    assert_eq!(gpu.shoot(&scene, &|_| ()).unwrap().gain, 2.0);
}

#[test]
fn bytes_depend_on_neither_the_run_nor_the_tiles() {
    let Some(gpu) = common::gpu() else { return };
    let scene = tiny(shipped("snowstorm.toml"));
    let first = gpu.shoot(&scene, &|_| ()).unwrap();
    let mut renderer = gpu;
    for tile_pixels in [1 << 19, 300, 1] {
        renderer = renderer.with_tile_pixels(tile_pixels);
        let again = renderer.shoot(&scene, &|_| ()).unwrap();
        assert!(again == first, "{tile_pixels} pixels a tile");
    }
}

#[test]
fn images_alone_come_back() {
    let Some(gpu) = common::gpu() else { return };
    let read = |scene: &Scene| {
        let before = gpu.bytes_read();
        gpu.shoot(scene, &|_| ()).unwrap();
        gpu.bytes_read() - before
    };
    // 851 pixels an eye, four at a time, three words of the exposure, and two of loops.
    let scene = tiny(shipped("paper.toml"));
    assert_eq!(read(&scene), 2 * 213 * 12 + 12 + 8);
    // Codes of a mosaic two at a time.
    let scene = tiny(mosaic(BayerPattern::Rggb, Demosaic::Malvar));
    assert_eq!(read(&scene), 2 * (213 * 12 + 426 * 4) + 12 + 8);
}

/// What the adapter does not do goes by way of a frame, to the byte, as the number of bytes read tells.
#[test]
fn means_over_renders_and_huge_wells_take_the_long_way() {
    let Some(gpu) = common::gpu() else { return };
    let scene = tiny(shipped("paper.toml"));
    let mut blurred = scene.clone();
    blurred.lens.aperture = Some(Aperture {
        f_number: 8.0,
        focal_length_m: 0.008,
        focus_m: 2.3,
    });
    let mut deep = scene;
    emva(&mut deep).full_well_e = 2e7;
    for (name, scene) in [("aperture", blurred), ("2e7 electrons", deep)] {
        let before = gpu.bytes_read();
        let images = gpu.shoot(&scene, &|_| ()).unwrap();
        assert!(gpu.bytes_read() - before > 2 * 851 * 76, "{name}");
        assert!(images == long_way(&gpu, &scene).unwrap(), "{name}");
    }
    // As the reference always does.
    let scene = tiny(plain());
    let frame = expose(&CpuRenderer, &scene, &|_| ()).unwrap();
    assert!(CpuRenderer.shoot(&scene, &|_| ()).unwrap() == develop(&frame, &scene).unwrap());
}

/// Everything that the comparison is there to find.
#[test]
fn comparison_finds_shifts_gains_swaps_and_other_noise() {
    let mut scene = mosaic(BayerPattern::Rggb, Demosaic::Malvar);
    scene.mode = Mode::Air;
    let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
    let right = develop(&frame, &scene).unwrap();
    compare(&right, &right).unwrap();
    let fails = |name: &str, change: &dyn Fn(&mut Scene, &mut Frame), says: &str| {
        let (mut scene, mut frame) = (scene.clone(), frame.clone());
        scene.exposure = Exposure::Fixed(right.gain);
        change(&mut scene, &mut frame);
        let wrong = develop(&frame, &scene).unwrap();
        let message = compare(&wrong, &right).expect_err(name);
        assert!(message.contains(says), "{name}: {message}");
    };
    let brighter = |_: &mut Scene, f: &mut Frame| {
        for pixel in f.left.pixels.iter_mut().chain(&mut f.right.pixels) {
            pixel.radiance = pixel.radiance.map(|v| 1.01 * v);
        }
    };
    fails(
        "shift by 1 px",
        &|_, f| f.left.pixels.rotate_right(1),
        "differ",
    );
    fails("gain of 1 %", &brighter, "differ");
    fails(
        "exposure 1 % longer",
        &|s, _| s.exposure = Exposure::Fixed(1.01 * right.gain),
        "gain",
    );
    fails(
        "swapped eyes",
        &|_, f| core::mem::swap(&mut f.left, &mut f.right),
        "differ",
    );
    fails("another seed", &|s, _| s.seed += 1, "differ");
    fails(
        "another specimen",
        &|s, _| emva(s).pattern_seed += 1,
        "differ",
    );
    fails("no raw images", &|s, _| s.output.raw = false, "raw");
    fails("16 bits", &|s, _| s.bits = 16, "differ");
}
