//! What a lens and a shutter do to light: a picture is a mean of pinhole pictures, over the points of the aperture and over the
//! time that the shutter is open. Nothing less knows what lies hidden behind a blurred edge. Works with any backend.

use core::f64::consts::PI;

use rayon::prelude::*;
use rodsight_geometry::{Eye, Mat3, MountedCamera, Pixel, Pose, RigFrame, Vec3};
use rodsight_scene::{Aperture, Motion, Scene};

use crate::exr_file::light_fields;
use crate::frame::{EyeFrame, Frame};
use crate::{RenderError, Renderer};

/// Stands for no surface: what moves there moves with the turn alone, m.
const FAR_M: f64 = 1e4;
/// Times of an exposure between which ways are straight.
const STAGES: [f64; 9] = [-0.5, -0.375, -0.25, -0.125, 0.0, 0.125, 0.25, 0.375, 0.5];
/// With an aperture, at least so many.
const LEAST: f64 = 33.0;
/// More than this is a slip of units rather than a wish.
const MOST: f64 = 2047.0;

/// Renders both eyes as the scene's aperture and motion show them. Light is the mean over aperture and exposure time; geometry is
/// that of the lens's centre in the middle of the exposure.
///
/// The number of renders follows from the largest blur in the picture: two a pixel of motion; two a square pixel of the circle of
/// confusion, and at least 33. A still scene without an aperture is rendered once.
///
/// # Errors
/// As [`Renderer::render`], and a blur that would take more than 2047 renders.
pub fn expose<R: Renderer + ?Sized>(
    renderer: &R,
    scene: &Scene,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Frame, RenderError> {
    if scene.motion.is_none() && scene.lens.aperture.is_none() {
        return renderer.render(scene, progress);
    }
    // Only the first render tells how many there will be.
    let mut frame = renderer.render(scene, &|_| ())?;
    let renders = renders(scene, &frame)?;
    let share = 1.0 / renders as f32;
    for eye in [&mut frame.left, &mut frame.right] {
        gather(eye, None, share);
    }
    for index in 1..renders {
        let done = |part: f64| progress((index as f64 + part) / renders as f64);
        let one = renderer.render(&instant(scene, index, renders)?, &done)?;
        gather(&mut frame.left, Some(&one.left), share);
        gather(&mut frame.right, Some(&one.right), share);
    }
    Ok(frame)
}

/// Adds a share of the light of a render, or takes the share of what is there.
fn gather(sum: &mut EyeFrame, one: Option<&EyeFrame>, share: f32) {
    sum.pixels
        .par_iter_mut()
        .enumerate()
        .for_each(|(index, pixel)| {
            let mut other = one.map_or(*pixel, |eye| eye.pixels[index]);
            let add = |sum: &mut f32, light: f32| {
                let before = if one.is_some() { *sum } else { 0.0 };
                *sum = before + share * light;
            };
            for field in light_fields() {
                let light = *field(&mut other);
                for (sum, light) in field(pixel).iter_mut().zip(light) {
                    add(sum, light);
                }
            }
            add(&mut pixel.snow_cover, other.snow_cover);
        });
}

fn renders(scene: &Scene, frame: &Frame) -> Result<usize, RenderError> {
    let (mut motion_px, mut blur_px) = (0.0_f64, 0.0_f64);
    for eye in Eye::BOTH {
        let mounted = scene.rig.eye(eye);
        let stages = scene.motion.map(|motion| {
            STAGES.map(|time| moved(mounted, &rig_at(&motion, time * motion.exposure_s)))
        });
        let nearest_snow_m = scene.snow.map_or(FAR_M, |snow| snow.range_m[0]);
        let eye_frame = frame.eye(eye);
        let width = eye_frame.width_px as usize;
        let pixels = eye_frame.pixels.par_iter().enumerate();
        let extremes = pixels.map(|(index, truth)| {
            let pixel = Pixel::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let motion_px = stages.map_or(0.0, |stages| {
                let range_m = f64::from(truth.range_m).min(nearest_snow_m);
                let point = mounted
                    .ray(&pixel)
                    .map(|(from_m, along)| from_m + along * range_m);
                point.map_or(0.0, |point_m| path_px(&stages, &point_m))
            });
            let depth_m = f64::from(truth.depth_m);
            (motion_px, depth_m, depth_m)
        });
        let (motion, nearest_m, farthest_m) = extremes.reduce(
            || (0.0, f64::INFINITY, 0.0),
            |a, b| (a.0.max(b.0), a.1.min(b.1), a.2.max(b.2)),
        );
        motion_px = motion_px.max(motion);
        if let Some(aperture) = scene.lens.aperture {
            for depth_m in [nearest_m, farthest_m] {
                blur_px = blur_px.max(aperture.blur_px(mounted, depth_m));
            }
        }
    }
    let mut wanted = libm::ceil(2.0 * motion_px).max(1.0);
    if scene.lens.aperture.is_some() {
        wanted = wanted
            .max(libm::ceil(0.5 * PI * blur_px * blur_px))
            .max(LEAST);
    }
    if wanted <= MOST {
        // Odd: one in the middle, the others in pairs about it.
        Ok(wanted as usize | 1)
    } else {
        Err(RenderError::Blur {
            scene: scene.id.clone(),
            motion_px,
            blur_px,
            renders: wanted,
        })
    }
}

/// Length of a point's way over the image; where it is out of sight its angle at the camera stands for it.
fn path_px(stages: &[MountedCamera], point_m: &Vec3) -> f64 {
    let fx_px = stages[0].camera.intrinsics().fx_px;
    let step_px = |a: &MountedCamera, b: &MountedCamera| {
        if let (Some(from), Some(to)) = (a.project(point_m), b.project(point_m)) {
            return (to - from).norm();
        }
        let seen = |camera: &MountedCamera| camera.rig_from_camera.inverse().point(point_m);
        let (from, to) = (seen(a), seen(b));
        fx_px * libm::atan2(from.cross(&to).norm(), from.dot(&to))
    };
    stages
        .windows(2)
        .map(|pair| step_px(&pair[0], &pair[1]))
        .sum()
}

/// The scene as one of the renders sees it. Renders come in pairs on opposite sides of the lens's centre and of the middle of the
/// exposure, so that nothing is shifted by them; times are equidistant, points of the aperture those of Roberts's R2 sequence.
fn instant(scene: &Scene, index: usize, renders: usize) -> Result<Scene, RenderError> {
    let pair = index.div_ceil(2) as f64;
    let side = if index % 2 == 1 { 1.0 } else { -1.0 };
    let mut scene = scene.clone();
    if let Some(aperture) = scene.lens.aperture {
        // Each pinhole stands for its share of the aperture.
        let share = (renders as f64).sqrt();
        scene.lens.aperture = Some(Aperture {
            f_number: aperture.f_number * share,
            ..aperture
        });
        let part = |step: f64| (0.5 + pair * step).fract();
        let radius_m = 0.5 * side * aperture.diameter_m() * part(0.754_877_666_246_692_7).sqrt();
        let (sin, cos) = libm::sincos(2.0 * PI * part(0.569_840_290_998_053_2));
        let point_m = Pixel::new(radius_m * cos, radius_m * sin);
        for mounted in [&mut scene.rig.left, &mut scene.rig.right] {
            *mounted = mounted
                .through(&point_m, aperture.focus_m)
                .map_err(|error| RenderError::Lens {
                    scene: scene.id.clone(),
                    message: error.to_string(),
                })?;
        }
    }
    if let Some(motion) = scene.motion {
        let now = rig_at(&motion, side * pair / renders as f64 * motion.exposure_s);
        scene.rig.left = moved(&scene.rig.left, &now);
        scene.rig.right = moved(&scene.rig.right, &now);
        for lamp in &mut scene.lamps {
            lamp.position_m = now.point(&lamp.position_m);
            lamp.direction = now.direction(&lamp.direction);
        }
    }
    Ok(scene)
}

/// The rig's pose at a time from the middle of the exposure, in its own frame then.
fn rig_at(motion: &Motion, time_s: f64) -> Pose<RigFrame, RigFrame> {
    let turn = motion.turn_rad_per_s * time_s;
    let angle = turn.norm();
    let rotation = if angle == 0.0 {
        Mat3::identity()
    } else {
        // Rodrigues.
        let (sin, cos) = libm::sincos(angle);
        let cross = (turn / angle).cross_matrix();
        Mat3::identity() + cross * sin + cross * cross * (1.0 - cos)
    };
    Pose::new(rotation, motion.velocity_m_per_s * time_s)
}

fn moved(mounted: &MountedCamera, now: &Pose<RigFrame, RigFrame>) -> MountedCamera {
    let mut mounted = *mounted;
    mounted.rig_from_camera = *now * mounted.rig_from_camera;
    mounted
}
