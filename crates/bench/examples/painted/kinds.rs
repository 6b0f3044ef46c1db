//! Scenes of every kind, drawn by seed.

use rodsight_geometry::{Cylinder, Pose, Vec3, radians, rotation_from_rpy};
use rodsight_solver::{CalibrationSigma, RadiusPrior};

use super::draft::{Draft, Trial};
use super::painter::{Ball, Scene, Texture, rig, rod};
use crate::asked::dice::{Dice, Random};

/// Every kind of scene.
pub(crate) const KINDS: [&str; 30] = [
    "flat",
    "clean",
    "headlight",
    "one_lamp",
    "side_lamp",
    "ambient",
    "noisy",
    "faint",
    "thick",
    "thin",
    "oblique",
    "grey",
    "own_hue",
    "blurred",
    "short",
    "bands",
    "patches",
    "hidden",
    "snow",
    "bent",
    "two_rods",
    "crossing",
    "along",
    "known",
    "misknown",
    "decalibrated",
    "pick_only",
    "nothing",
    "no_rod",
    "everything",
];

/// A scene of a kind; `None` where the rod is not in both images.
pub(crate) fn draw(kind: &str, seed: u64) -> Option<Trial> {
    draft(kind, seed).finish()
}

/// A scene of a kind, to be changed.
pub(crate) fn draft(kind: &str, seed: u64) -> Draft {
    if kind == "everything" {
        let mut dice = Dice(Random::new(seed.wrapping_mul(0xA24B_AED4)));
        let kind = dice.one_of(&KINDS[..KINDS.len() - 1]);
        return draft(kind, seed.wrapping_add(1 << 32));
    }
    let mut dice = Dice(Random::new(seed.wrapping_mul(0x9FB2_1C65) ^ 0x1234_5678));
    let rig = rig();
    let distance_m = dice.within(1.5, 3.5);
    let at = [distance_m, dice.within(-0.2, 0.2), dice.within(-0.2, 0.2)];
    let radius_m = match kind {
        "thick" => dice.within(0.1, 0.3),
        "thin" => dice.within(0.004, 0.015),
        _ => dice.log_within(0.02, 0.08),
    };
    // Degrees from across the baseline, in the image and along the view.
    let (least, most) = match kind {
        "oblique" => (35.0, 65.0),
        _ => (-35.0, 35.0),
    };
    let (roll, tilt) = if kind == "along" {
        (
            radians(90.0 + dice.within(-6.0, 6.0)),
            radians(dice.within(-6.0, 6.0)),
        )
    } else {
        let side = dice.one_of(&[-1.0, 1.0]);
        (
            radians(dice.within(-60.0, 60.0)),
            radians(side * dice.within(least, most)),
        )
    };
    let direction = if kind == "along" {
        // Near the baseline, which is y.
        [libm::sin(tilt), 1.0, libm::cos(roll)]
    } else {
        [
            libm::sin(tilt),
            libm::cos(tilt) * libm::sin(roll),
            libm::cos(tilt) * libm::cos(roll),
        ]
    };
    let target = rod(at, direction, radius_m);
    let mut scene = Scene::new(&rig, vec![target]);
    scene.seed = seed.wrapping_mul(0x51ED_270B);
    scene.samples = 12;
    scene.rod_colour = dice.colour();
    scene.background = dice.one_of(&[
        [0.02, 0.05, 0.08],
        [0.002, 0.01, 0.02],
        [0.01, 0.12, 0.1],
        [0.05, 0.08, 0.05],
    ]);
    scene.background_slope = [dice.within(-0.6, 0.6), dice.within(-0.6, 0.6)];
    scene.ambient = dice.within(0.02, 0.2);
    scene.haze_per_m = dice.within(0.05, 0.3);
    scene.blur_px = dice.within(0.3, 0.8);
    scene.noise_sigma = dice.log_within(0.003, 0.015);
    let side = dice.within(0.0, core::f64::consts::TAU);
    let outboard = [
        dice.lamp(35.0, 60.0, 0.0),
        dice.lamp(35.0, 60.0, core::f64::consts::PI),
    ];
    scene.lamps = outboard.to_vec();
    let mut draft = Draft::new(scene, dice);
    let Draft {
        ref mut scene,
        ref mut dice,
        ..
    } = draft;
    match kind {
        "flat" => {
            scene.lamps = Vec::new();
            scene.ambient = 0.8;
        }
        "headlight" => scene.lamps = vec![dice.lamp(0.0, 8.0, side)],
        "one_lamp" => scene.lamps = vec![dice.lamp(10.0, 40.0, side)],
        "side_lamp" => scene.lamps = vec![dice.lamp(40.0, 85.0, side)],
        "ambient" => {
            scene.lamps = vec![Vec3::new(-0.1, 0.0, -0.6)];
            scene.ambient = 0.3;
        }
        "noisy" => scene.noise_sigma = dice.log_within(0.02, 0.08),
        "faint" => {
            scene.haze_per_m = dice.within(0.7, 1.5);
            scene.noise_sigma = dice.log_within(0.005, 0.02);
        }
        "grey" => scene.channels = 1,
        "own_hue" => {
            scene.rod_colour = scene.background.map(|v| 3.0 * v);
            scene.haze_per_m = dice.within(0.1, 0.4);
        }
        "blurred" => scene.blur_px = dice.within(1.0, 3.0),
        "short" => scene.half_length_m = dice.within(1.5, 5.0) * radius_m,
        "bands" => {
            scene.texture = Texture::Bands {
                period_m: dice.log_within(0.02, 0.3),
                colour: dice.colour(),
            };
        }
        "patches" => {
            scene.texture = Texture::Patches {
                size_m: dice.log_within(0.01, 0.1),
                share: dice.within(0.3, 0.95),
            };
        }
        "hidden" => hide(scene, dice, &target),
        "snow" => {
            let flakes = dice.log_within(30.0, 2000.0) as usize;
            snow(scene, dice, flakes);
        }
        "bent" => {
            let sagitta = dice.within(0.0, 0.03);
            let [a, b] = [dice.within(-1.0, 1.0), dice.within(-1.0, 1.0)];
            let towards = target
                .axis
                .direction
                .cross(&Vec3::new(a, b, 0.4))
                .normalize();
            // Of a metre of rod.
            scene.curvature_per_m = towards * (8.0 * sagitta);
        }
        "two_rods" | "crossing" => {
            let aside = if kind == "crossing" {
                [dice.within(0.1, 0.5), 0.0, 0.0]
            } else {
                [
                    dice.within(0.0, 0.8),
                    dice.one_of(&[-1.0, 1.0]) * dice.within(0.15, 0.4),
                    0.0,
                ]
            };
            let turn = if kind == "crossing" {
                [
                    dice.within(-1.0, 1.0),
                    dice.within(-1.0, 1.0),
                    dice.within(-1.0, 1.0),
                ]
            } else {
                direction
            };
            let place = [at[0] + aside[0], at[1] + aside[1], at[2] + aside[2]];
            scene
                .rods
                .push(rod(place, turn, dice.log_within(0.02, 0.08)));
        }
        "known" | "misknown" => {
            let wrong = if kind == "known" {
                0.0
            } else {
                dice.one_of(&[-1.0, 1.0]) * dice.within(0.02, 0.2)
            };
            draft.radius = Some(RadiusPrior {
                radius_m: radius_m * (1.0 + wrong),
                sigma_m: dice.one_of(&[None, Some(0.001 * radius_m)]),
            });
        }
        "decalibrated" => {
            // 0.02° of the pose of the right eye, and it is known that this may be.
            let sigma_rad = radians(0.02);
            let mut turn = || sigma_rad * dice.0.normal();
            let off = rotation_from_rpy(turn(), turn(), turn());
            let pose = &rig.right.rig_from_camera;
            draft.believed.right.rig_from_camera =
                Pose::new(off * pose.rotation(), pose.origin_m());
            draft.calibration = Some(CalibrationSigma {
                pixel_px: 1566.6 * sigma_rad / core::f64::consts::SQRT_2,
                roll_rad: sigma_rad / core::f64::consts::SQRT_2,
            });
        }
        "pick_only" => draft.region_px = None,
        "nothing" => {
            draft.region_px = None;
            draft.pick = None;
        }
        "no_rod" => draft.is_there = false,
        _ => {}
    }
    draft
}

/// Flakes between the cameras and 3 m ahead of them.
pub(crate) fn snow(scene: &mut Scene, dice: &mut Dice, flakes: usize) {
    for _ in 0..flakes {
        let forward_m = dice.within(0.3, 3.0);
        let span = 0.7 * forward_m;
        scene.balls.push(Ball {
            centre_m: Vec3::new(
                forward_m,
                dice.within(-span - 0.5, span + 0.5),
                dice.within(-span, span) - 1.0,
            ),
            radius_m: dice.log_within(0.0003, 0.003),
            colour: [0.3, 0.35, 0.35],
        });
    }
}

/// Balls before up to three fifths of the rod.
fn hide(scene: &mut Scene, dice: &mut Dice, target: &Cylinder) {
    let share = dice.within(0.05, 0.6);
    let window_m = 0.9;
    let mut hidden_m = 0.0;
    while hidden_m < share * window_m {
        let radius_m = dice.within(0.5, 1.5) * target.radius_m;
        let along_m = dice.within(-0.5, 0.5) * window_m;
        let off_m = dice.within(-1.2, 1.2) * target.radius_m;
        let across = target.axis.direction.cross(&Vec3::x()).normalize();
        scene.balls.push(Ball {
            centre_m: target.axis.point_m + target.axis.direction * along_m + across * off_m
                - Vec3::x() * (target.radius_m + radius_m),
            radius_m,
            colour: dice.colour().map(|v| 0.5 * v),
        });
        hidden_m += radius_m;
    }
}
