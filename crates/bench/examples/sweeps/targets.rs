//! How a value changes a scene. What a sweep draws itself is drawn by dice of its own, alike at each value.

use rodsight_geometry::{
    Cylinder, Eye, Line3, Pixel, Pose, Side, Vec3, radians, rotation_from_rpy,
};
use rodsight_solver::CalibrationSigma;

use crate::asked::dice::{Dice, Random};
use crate::painted::draft::{Draft, Trial};
use crate::painted::kinds;
use crate::painted::limbs::Limbs;
use crate::painted::painter::{Ball, Scene, Texture, rig};

/// Noise under which there is not more contrast over noise but less contrast, of 1: 2.5 of 255 codes, so that the dark end of the
/// scale cuts off none of it.
const CONTRAST_NOISE_SIGMA: f64 = 0.01;

pub(crate) fn same_place(_: &mut Draft, _: f64) {}

pub(crate) fn same_looks(_: &mut Trial, _: f64) {}

fn own_dice(scene: &Scene) -> Dice {
    Dice(Random::new(scene.seed ^ 0x7F4A_7C15_0BAD_5EED))
}

/// Haze over a background of one brightness: the painter's haze is, and a slope behind it would stay a contrast in the thickest.
pub(crate) fn haze(trial: &mut Trial, value: f64) {
    trial.scene.background_slope = [0.0; 2];
    trial.scene.haze_per_m = value;
}

/// Noise as the scale bears it, then as much haze as it takes; where there is too little contrast for that, less noise.
pub(crate) fn contrast(trial: &mut Trial, value: f64) {
    let scene = &mut trial.scene;
    scene.background_slope = [0.0; 2];
    let drawn_per_m = scene.haze_per_m;
    scene.noise_sigma = CONTRAST_NOISE_SIGMA;
    let mut at = |haze_per_m: f64| {
        scene.haze_per_m = haze_per_m;
        Limbs::of(scene).contrast_to_noise().unwrap_or(0.0)
    };
    let most = at(drawn_per_m);
    if most > value {
        let (mut low, mut high) = (drawn_per_m, 12.0);
        for _ in 0..16 {
            let middle = f64::midpoint(low, high);
            if at(middle) > value {
                low = middle;
            } else {
                high = middle;
            }
        }
        scene.haze_per_m = f64::midpoint(low, high);
    } else {
        scene.noise_sigma *= most / value;
    }
}

/// A direction at an angle to the baseline, which is y, turned about it by chance.
pub(crate) fn baseline_angle(draft: &mut Draft, value: f64) {
    let turn_rad = radians(own_dice(&draft.scene).within(-35.0, 35.0));
    let (sin, cos) = libm::sincos(radians(value));
    turn_to(
        draft,
        Vec3::new(sin * libm::sin(turn_rad), cos, sin * libm::cos(turn_rad)),
    );
}

pub(crate) fn obliquity(draft: &mut Draft, value: f64) {
    let mut dice = own_dice(&draft.scene);
    let side = dice.one_of(&[-1.0, 1.0]);
    let (roll_sin, roll_cos) = libm::sincos(radians(dice.within(-60.0, 60.0)));
    let (sin, cos) = libm::sincos(radians(value));
    turn_to(draft, Vec3::new(side * sin, cos * roll_sin, cos * roll_cos));
}

fn turn_to(draft: &mut Draft, direction: Vec3) {
    let rod = &mut draft.scene.rods[0];
    rod.axis = Line3::new(rod.axis.point_m, &direction);
}

pub(crate) fn baseline(draft: &mut Draft, value: f64) {
    let mut rig = rig();
    for (mounted, side) in [(&mut rig.left, -0.5), (&mut rig.right, 0.5)] {
        let pose = &mounted.rig_from_camera;
        mounted.rig_from_camera = Pose::new(*pose.rotation(), Vec3::new(0.0, side * value, -1.0));
    }
    draft.scene.rig = rig;
    draft.believed = rig;
}

pub(crate) fn distance(draft: &mut Draft, value: f64) {
    draft.scene.rods[0].axis.point_m.x = value;
}

pub(crate) fn lamp(trial: &mut Trial, value: f64) {
    let mut dice = own_dice(&trial.scene);
    let side_rad = dice.one_of(&[0.0, core::f64::consts::PI]);
    let scene = &mut trial.scene;
    match value as usize {
        0 => scene.lamps = vec![dice.lamp(0.0, 8.0, side_rad)],
        // As they were drawn.
        1 => {}
        2 => scene.lamps = vec![dice.lamp(60.0, 85.0, side_rad)],
        // Down is z: from 70° above the view, to either side.
        3 => scene.lamps = vec![dice.lamp(65.0, 75.0, -0.5 * core::f64::consts::PI)],
        _ => {
            scene.lamps.clear();
            scene.ambient = 0.4;
        }
    }
}

pub(crate) fn colour(trial: &mut Trial, value: f64) {
    let scene = &mut trial.scene;
    scene.rod_colour = match value as usize {
        0 => [0.8; 3],
        1 => [0.3; 3],
        2 => [0.03; 3],
        3 => scene.background.map(|v| 3.0 * v),
        _ => [0.6, 0.3, 0.06],
    };
}

pub(crate) fn bands(trial: &mut Trial, value: f64) {
    let period_m = own_dice(&trial.scene).log_within(0.02, 0.3);
    let scene = &mut trial.scene;
    scene.texture = Texture::Bands {
        period_m,
        colour: scene.rod_colour.map(|v| v * (1.0 - 0.01 * value)),
    };
}

pub(crate) fn patches(trial: &mut Trial, value: f64) {
    let size_m = own_dice(&trial.scene).log_within(0.01, 0.1);
    trial.scene.texture = Texture::Patches {
        size_m,
        share: 0.01 * value,
    };
}

/// Balls before the rod, one by one, until so much of its limbs is hidden: what hides less hides it at all values.
pub(crate) fn occlusion(trial: &mut Trial, value: f64) {
    const WINDOW_M: f64 = 0.9;
    let Some(target) = trial.target else { return };
    let scene = &mut trial.scene;
    let mut dice = own_dice(scene);
    let across = target.axis.direction.cross(&Vec3::x()).normalize();
    let left = (1.0 - 0.01 * value) * Limbs::of(scene).pieces() as f64;
    for _ in 0..400 {
        if Limbs::of(scene).pieces() as f64 <= left {
            return;
        }
        let radius_m = dice.within(0.5, 1.5) * target.radius_m;
        let along_m = dice.within(-0.5, 0.5) * WINDOW_M;
        let off_m = dice.within(-1.2, 1.2) * target.radius_m;
        scene.balls.push(Ball {
            centre_m: target.axis.point_m + target.axis.direction * along_m + across * off_m
                - Vec3::x() * (target.radius_m + radius_m),
            radius_m,
            colour: dice.colour().map(|v| 0.5 * v),
        });
    }
}

/// An upright rod, and of the left region so much that a part of the rod's width is in it. The pick is in the right eye.
pub(crate) fn cut_width(draft: &mut Draft, value: f64) {
    let roll_rad = radians(own_dice(&draft.scene).within(-1.0, 1.0));
    turn_to(
        draft,
        Vec3::new(0.0, libm::sin(roll_rad), libm::cos(roll_rad)),
    );
    draft.pick = Some(Eye::Right);
    let rod: Cylinder = draft.scene.rods[0];
    let mounted = draft.scene.rig.left;
    let limb = |side| mounted.project(&mounted.limb_point_m(&rod, side)?);
    let axis = mounted.project(&rod.axis.point_m);
    let (Some(a), Some(b), Some(axis), Some([width_px, _])) =
        (limb(Side::Plus), limb(Side::Minus), axis, draft.region_px)
    else {
        return;
    };
    // The rod is in the right half of the left image: the region lies to its left.
    let border_px = a.x.min(b.x) + 0.01 * value * (a.x - b.x).abs();
    draft.region_off_px[0] = Some(Pixel::new(
        border_px - 0.5 * f64::from(width_px) - axis.x,
        0.0,
    ));
}

pub(crate) fn cut_length(draft: &mut Draft, value: f64) {
    draft.region_px = Some([640, value as u32]);
    draft.region_off_px = [Some(Pixel::zeros()); 2];
}

pub(crate) fn bend(trial: &mut Trial, value: f64) {
    let Some(target) = trial.target else { return };
    let mut dice = own_dice(&trial.scene);
    let aside = Vec3::new(dice.within(-1.0, 1.0), dice.within(-1.0, 1.0), 0.4);
    let towards = target.axis.direction.cross(&aside).normalize();
    // The sagitta of an arc of length L is L²/8 of its curvature.
    trial.scene.curvature_per_m = towards * (8.0 * 0.01 * value);
}

pub(crate) fn snow(trial: &mut Trial, value: f64) {
    let mut dice = own_dice(&trial.scene);
    kinds::snow(&mut trial.scene, &mut dice, value as usize);
}

/// Rods of the same colour beside it in the image and to 0.8 m behind it, 0.1 to 0.5 m from surface to surface.
pub(crate) fn distractors(trial: &mut Trial, value: f64) {
    let Some(target) = trial.target else { return };
    let mut dice = own_dice(&trial.scene);
    let across = target.axis.direction.cross(&Vec3::x()).normalize();
    for _ in 0..value as usize {
        let radius_m = dice.log_within(0.02, 0.08);
        let gap_m = dice.within(0.1, 0.5) + target.radius_m + radius_m;
        let aside =
            across * (dice.one_of(&[-1.0, 1.0]) * gap_m) + Vec3::x() * dice.within(0.0, 0.8);
        trial.scene.rods.push(Cylinder {
            axis: Line3 {
                point_m: target.axis.point_m + aside,
                ..target.axis
            },
            radius_m,
        });
    }
}

/// The right eye's pose is off, by an error between the eyes that is as if each were off by so many pixels; a turn about the view is
/// as large.
pub(crate) fn calibration(draft: &mut Draft, value: f64, is_declared: bool) {
    let mut dice = own_dice(&draft.scene);
    let focal_px = draft.scene.rig.right.camera.intrinsics().fx_px;
    let sigma_rad = value * core::f64::consts::SQRT_2 / focal_px;
    let mut turn = || sigma_rad * dice.0.normal();
    let off = rotation_from_rpy(turn(), turn(), turn());
    let pose = &draft.scene.rig.right.rig_from_camera;
    draft.believed.right.rig_from_camera = Pose::new(off * pose.rotation(), pose.origin_m());
    draft.calibration = is_declared.then_some(CalibrationSigma {
        pixel_px: value,
        roll_rad: sigma_rad / core::f64::consts::SQRT_2,
    });
}
