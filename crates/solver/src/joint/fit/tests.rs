use rodsight_geometry::{
    Camera, Cylinder, Distortion, Image, Intrinsics, Line3, Mat3, MountedCamera, Pose, Samples,
    Vec3,
};

use super::*;
use crate::Roi;
use crate::joint::bands::{INSIDE_PX, Ray, Window, stretches};
use crate::joint::crossing::distance;
use crate::joint::light::Light;
use crate::joint::pool::{self, Block};
use crate::joint::state::{BEND, LAMPS, Shadow, of_shadow};

fn cameras() -> [MountedCamera; 2] {
    let intrinsics = Intrinsics {
        width_px: 160,
        height_px: 120,
        fx_px: 150.0,
        fy_px: 150.0,
        cx_px: 80.0,
        cy_px: 60.0,
    };
    let lens = Distortion::BrownConrady([-0.1, 0.02, 0.001, -0.001, 0.0]);
    let camera = Camera::new(intrinsics, lens).expect("a camera");
    [-0.2, 0.2].map(|y_m| {
        let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        MountedCamera::new(camera, Pose::new(axes, Vec3::new(0.0, y_m, 0.0)))
    })
}

fn rod(radius_m: f64) -> Cylinder {
    Cylinder {
        axis: Line3::new(Vec3::new(1.0, 0.02, 0.0), &Vec3::new(0.2, 0.3, 1.0)),
        radius_m,
    }
}

const WHOLE: Roi = Roi {
    x_px: 0,
    y_px: 0,
    width_px: 160,
    height_px: 120,
};

/// A matt rod lit from the camera, sampled once a pixel.
fn image(mounted: &MountedCamera, cylinder: &Cylinder) -> Image {
    let value = |index: usize| {
        let place =
            rodsight_geometry::Pixel::new((index % 160) as f64 + 0.5, (index / 160) as f64 + 0.5);
        let (origin_m, direction) = mounted.ray(&place).expect("a ray");
        let ray = Ray {
            origin_m,
            direction,
        };
        let t = distance(&State::new(*cylinder, 0.3), &ray).0 / cylinder.radius_m;
        let inside = 0.3 + 0.1 * t + 0.5 * (1.0 - t * t).max(0.0).sqrt();
        let light = if t.abs() < 1.0 { inside } else { 0.1 };
        // sRGB.
        (65535.0 * (1.055 * libm::pow(light, 1.0 / 2.4) - 0.055)) as u16
    };
    let samples = Samples::U16((0..160 * 120).map(value).collect());
    Image::new(160, 120, 1, samples).expect("an image")
}

/// The likelihood of a state at its best shading, and its derivatives.
fn profile(state: &State, blocks: &[Block]) -> Sums {
    let unlike = Alike::default();
    let mut lit = Lit::dark(blocks.len());
    for _ in 0..12 {
        lit = sums(state, blocks, &lit, &unlike).lit(&lit, &SVector::zeros());
    }
    sums(state, blocks, &lit, &unlike)
}

/// The pixels around the limbs of a rod, all worth as much.
fn around(truth: &Cylinder) -> Vec<Block> {
    let mut all = Vec::new();
    for (eye, mounted) in cameras().iter().enumerate() {
        let image = image(mounted, truth);
        let light = Light::of(&image, WHOLE);
        let axes = [[1.0, 0.0, 0.0]; 2];
        let window = Window {
            inside_px: INSIDE_PX,
            blur_px2: 0.1,
            row_step: 1,
            block_step: 1,
        };
        let found = stretches(mounted, &light, &axes, &State::new(*truth, 0.1), &window);
        all.extend(pool::blocks(eye, &found.expect("stretches")));
    }
    let cuts = all.iter_mut().flat_map(|block: &mut Block| &mut block.cuts);
    for sample in cuts.flatten().flat_map(|cut| &mut cut.samples) {
        sample.weight = 1.0;
    }
    all
}

/// Off the truth by a little of all of the rod's unknowns and of blur.
fn nearby(truth: Cylinder) -> State {
    let mut off = SVector::<f64, UNKNOWNS>::zeros();
    let values = [2e-3, -1e-3, 2e-3, 3e-3, 1e-3, 0.03, -0.05, 0.2, -0.1];
    off.fixed_rows_mut::<9>(0).copy_from_slice(&values);
    let mut state = State::new(truth, 0.4);
    state.bend_per_m = Some(Vec3::zeros());
    state.moved(&off)
}

/// By how much the score is off the slope of the likelihood, as a share of how steep it may be by chance; `None` where nothing is.
fn off_slope(state: &State, blocks: &[Block], here: &Sums, k: usize) -> Option<f64> {
    let mut step = SVector::zeros();
    step[k] = 1e-5;
    let [more, less] = [step, -step].map(|step| profile(&state.moved(&step), blocks).cost);
    let slope = (less - more) / 2e-5;
    let scale = (here.normal[(k, k)] * 2.0 * here.cost).sqrt();
    (scale > 0.0).then_some((here.score[k] - slope).abs() / scale)
}

/// Of rods that are wide and of one so narrow that each limb is within the other's blur, behind lenses that bend lines.
#[test]
fn derivatives_are_those_of_the_likelihood() {
    for radius_m in [0.06, 0.008] {
        let truth = rod(radius_m);
        let blocks = around(&truth);
        let mut state = nearby(truth);
        let shadow = |amount, angle_rad| {
            Some(Shadow {
                amount,
                angle_rad,
                within_rad: [0.1, 1.0],
            })
        };
        state.shadows = [
            [shadow(0.4, 0.4), None],
            [shadow(-0.2, 0.6), shadow(0.7, 0.5)],
        ];
        let here = profile(&state, &blocks);
        for k in (0..UNKNOWNS).filter(|k| ![11, 12].contains(k)) {
            let off = off_slope(&state, &blocks, &here, k);
            // Nothing rises inside so narrow a rod, and no shadow can be told.
            if off.is_none() && k >= of_shadow(0, 0) && radius_m < 0.01 {
                continue;
            }
            // That shading is across the radius is left out of its derivative; it tells where all of the rod is a limb.
            let most = if k == RADIUS && radius_m < 0.01 {
                2.5e-2
            } else {
                2e-2
            };
            assert!(
                off.is_some_and(|off| off < most),
                "radius {radius_m}, unknown {k}: {off:?}"
            );
        }
    }
}

/// One lamp before the rod and two, of which one ends before a limb. How blur changes the end of a light that is there but for less
/// than none is left out, and how the rod's place changes azimuths.
#[test]
fn derivatives_by_lamps_are_those_of_the_likelihood() {
    let truth = rod(0.06);
    let blocks = around(&truth);
    for lamps_rad in [[Some(0.4), None], [Some(2.1), Some(3.9)]] {
        let state = State {
            bend_per_m: None,
            lamps_rad,
            ..nearby(truth)
        };
        let here = profile(&state, &blocks);
        let lamps = LAMPS..LAMPS + lamps_rad.iter().flatten().count();
        for k in (0..BEND).chain(ROD..ROD + 2).chain(lamps) {
            let off = off_slope(&state, &blocks, &here, k);
            assert!(
                off.is_some_and(|off| off < 3e-2),
                "{lamps_rad:?}, unknown {k}: {off:?}"
            );
        }
    }
}

#[test]
fn turns_and_shifts_move_rays_as_they_say() {
    let mut state = State::new(rod(0.05), 0.3);
    let ray = Ray {
        origin_m: Vec3::new(0.0, -0.2, 0.0),
        direction: Vec3::new(1.0, 0.15, 0.2).normalize(),
    };
    state.bend_per_m = Some(Vec3::new(0.2, -0.1, 0.0));
    state.bend_per_m = Some(
        state
            .moved(&SVector::zeros())
            .bend_per_m
            .unwrap_or_default(),
    );
    let (_, slopes) = distance(&state, &ray);
    let places = [0, 1, 2, 3, BEND, BEND + 1];
    for (k, slope) in places.into_iter().zip(slopes) {
        let mut step = SVector::zeros();
        step[k] = 1e-6;
        let [more, less] = [step, -step].map(|step| distance(&state.moved(&step), &ray).0);
        let found = (more - less) / 2e-6;
        assert!((found - slope).abs() < 2e-4, "{k}: {slope} {found}");
    }
}
