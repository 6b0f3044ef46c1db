//! Scenes the tests share, built in code so that a change of the shipped scenes moves no test.
#![expect(
    unreachable_pub,
    reason = "each test binary compiles this module for itself"
)]
#![allow(
    dead_code,
    clippy::allow_attributes,
    clippy::print_stdout,
    reason = "no test binary uses all of it; what is skipped is said"
)]

pub mod compare;

use rodsight_geometry::{
    Camera, Distortion, Eye, Intrinsics, MountedCamera, Pose, Rig, Vec3, radians, rotation_from_rpy,
};
use rodsight_optics::Medium;
use rodsight_scene::{
    EdgeSampling, Exposure, Lamp, Lens, Material, Mode, Output, Rod, Sampling, Scene, Sensor,
    Target,
};

/// The founding rig at a fraction 1/`shrink` of its resolution.
pub fn rig(shrink: u32) -> Rig {
    let scale = f64::from(shrink);
    let intrinsics = Intrinsics {
        width_px: 1920 / shrink,
        height_px: 1080 / shrink,
        fx_px: 1566.5776 / scale,
        fy_px: 1566.5776 / scale,
        cx_px: 960.0 / scale,
        cy_px: 540.0 / scale,
    };
    let camera = Camera::new(intrinsics, Distortion::None).unwrap();
    let mounted = |y_m: f64| {
        let axes = rotation_from_rpy(radians(90.0), 0.0, radians(90.0));
        MountedCamera::new(camera, Pose::new(axes, Vec3::new(0.0, y_m, -1.0)))
    };
    Rig {
        left: mounted(-0.5),
        right: mounted(0.5),
    }
}

/// Nothing but a rig in a vacuum.
pub fn empty(shrink: u32) -> Scene {
    Scene {
        id: "test".to_owned(),
        seed: 1,
        rig: rig(shrink),
        mode: Mode::Air,
        water_label: "vacuum".to_owned(),
        medium: Medium::vacuum(),
        ambient_radiance: [0.0; 3],
        daylight: None,
        background_radiance: [0.0; 3],
        lamps: Vec::new(),
        rods: Vec::new(),
        occluders: Vec::new(),
        props: Vec::new(),
        seabed: None,
        snow: None,
        exposure: Exposure::Fixed(1.0),
        white_balance: [1.0; 3],
        colour_matrix: None,
        lens: Lens::default(),
        motion: None,
        output: Output::default(),
        sensor: Sensor::Plain {
            noise_sigma_dn: 0.0,
        },
        bits: 16,
        sampling: Sampling {
            edge: EdgeSampling::Fibonacci { points: 233 },
            airlight_points: 16,
        },
        target: Target {
            rod: 0,
            along_m: 0.0,
            pick_eye: Eye::Left,
        },
    }
}

/// A straight rod that is not lit but shines.
pub fn flat_rod(centre_m: Vec3, direction: Vec3, radius_m: f64) -> Rod {
    Rod {
        id: "rod".to_owned(),
        centre_m,
        direction: direction.normalize(),
        length_m: 8.0,
        radius_m,
        bend: None,
        material: Material::Flat([0.8, 0.5, 0.2]),
        finish: rodsight_scene::Finish::default(),
        fouling: None,
    }
}

/// A lamp that shines everywhere.
pub fn bare_lamp(position_m: Vec3, radiant_intensity_w_per_sr: [f64; 3]) -> Lamp {
    Lamp {
        position_m,
        direction: Vec3::x(),
        radiant_intensity_w_per_sr,
        inner_half_angle_rad: core::f64::consts::PI,
        outer_half_angle_rad: core::f64::consts::PI,
    }
}

/// Water of type IB-like turbidity, two lamps, a textured floor.
pub fn wet(shrink: u32) -> Scene {
    let mut scene = empty(shrink);
    scene.mode = Mode::Single;
    scene.medium = Medium::new(
        [0.23, 0.05, 0.04],
        [0.12, 0.125, 0.13],
        rodsight_optics::Phase::petzold3(),
    )
    .unwrap();
    for y_m in [-0.9, 0.9] {
        scene
            .lamps
            .push(bare_lamp(Vec3::new(0.1, y_m, -1.35), [1.8, 2.0, 0.9]));
    }
    scene.seabed = Some(rodsight_scene::Seabed {
        z_m: 0.15,
        albedo: [0.42, 0.36, 0.26],
        texture_contrast: 0.25,
        texture_scale_m: 0.15,
        ripples: None,
        clutter: None,
    });
    scene.exposure = Exposure::Auto {
        quantile: 0.99,
        level: 0.8,
    };
    scene.sensor = Sensor::Emva(rodsight_scene::Emva {
        full_well_e: 10_500.0,
        read_noise_e: 2.5,
        dark_e: 0.2,
        prnu: 0.006,
        dsnu_e: 1.0,
        adc_bits: 12,
        pattern_seed: 0,
        bayer: None,
    });
    scene
}

/// A straight matt rod.
pub fn orange_rod(centre_m: Vec3, direction: Vec3, radius_m: f64) -> Rod {
    Rod {
        length_m: 3.0,
        material: Material::Lambert([0.9, 0.3, 0.04]),
        ..flat_rod(centre_m, direction, radius_m)
    }
}

/// Every number of a pixel.
pub fn numbers(p: &rodsight_render::PixelTruth) -> [f32; 32] {
    let triples = [
        p.radiance,
        p.direct,
        p.forward,
        p.backscatter,
        p.clean,
        p.transmission,
        p.normal,
        p.snow,
    ];
    let mut all = [0.0; 32];
    for (three, values) in all.chunks_exact_mut(3).zip(triples) {
        three.copy_from_slice(&values);
    }
    all[24..].copy_from_slice(&[
        p.depth_m,
        p.range_m,
        p.disparity_px,
        f32::from(p.instance),
        f32::from(p.material),
        f32::from(u8::from(p.occluded)),
        f32::from(u8::from(p.beyond_model)),
        p.snow_cover,
    ]);
    all
}

/// Two rods over sand, one before the other.
pub fn crossing(shrink: u32) -> Scene {
    let mut scene = wet(shrink);
    scene.rods.push(orange_rod(
        Vec3::new(2.2, -0.1, -0.9),
        Vec3::new(0.2, 0.3, 1.0),
        0.05,
    ));
    scene.rods.push(orange_rod(
        Vec3::new(1.6, 0.0, -0.9),
        Vec3::new(0.1, 1.0, 0.1),
        0.04,
    ));
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 21 };
    scene
}

fn lens(distortion: Distortion) -> Camera {
    let i = Intrinsics {
        width_px: 240,
        height_px: 136,
        fx_px: 196.0,
        fy_px: 193.0,
        cx_px: 121.5,
        cy_px: 66.0,
    };
    Camera::new(i, distortion).unwrap()
}

/// A lens of a machine-vision camera.
pub const BROWN: Distortion = Distortion::BrownConrady([-0.12, 0.03, 0.001, -0.002, 0.0]);
/// A wide lens.
pub const KANNALA: Distortion = Distortion::KannalaBrandt([0.02, -0.004, 0.001, 0.0]);

/// A scene through another lens, 240 px wide.
pub fn distorted(distortion: Distortion, mut scene: Scene) -> Scene {
    scene.rig.left.camera = lens(distortion);
    scene.rig.right.camera = lens(distortion);
    scene
}

/// The graphics backend, on a card or a software driver. Without an adapter it says so and there is none, unless
/// `RODSIGHT_REQUIRE_GPU=1` demands one.
pub fn gpu() -> Option<rodsight_render::GpuRenderer> {
    use rodsight_render::{AdapterChoice, GpuRenderer, RenderError};
    match GpuRenderer::new(AdapterChoice::HardwareOrSoftware) {
        Ok(renderer) => Some(renderer),
        Err(error @ RenderError::NoAdapter { .. })
            if std::env::var("RODSIGHT_REQUIRE_GPU").as_deref() != Ok("1") =>
        {
            println!("SKIPPED: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// The scene at a fraction of its resolution.
pub fn shrunk(mut scene: Scene, shrink: u32) -> Scene {
    let scale = f64::from(shrink);
    for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
        let i = *mounted.camera.intrinsics();
        let intrinsics = Intrinsics {
            width_px: i.width_px / shrink,
            height_px: i.height_px / shrink,
            fx_px: i.fx_px / scale,
            fy_px: i.fy_px / scale,
            cx_px: i.cx_px / scale,
            cy_px: i.cy_px / scale,
        };
        mounted.camera = Camera::new(intrinsics, *mounted.camera.distortion()).unwrap();
    }
    scene
}

/// A pair of every backend that this machine has.
pub fn on_each(scene: &Scene) -> Vec<rodsight_render::Frame> {
    use rodsight_render::{CpuRenderer, Renderer};
    let cpu: Box<dyn Renderer> = Box::new(CpuRenderer);
    let gpu = gpu().map(|gpu| -> Box<dyn Renderer> { Box::new(gpu) });
    let all = core::iter::once(cpu).chain(gpu);
    all.map(|renderer| renderer.render(scene, &|_| ()).unwrap())
        .collect()
}
