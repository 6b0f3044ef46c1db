//! What only the whole scene can tell: rods behind the cameras, cameras and lamps where they cannot be.

use rodsight_geometry::{Eye, Pixel, Vec3};

use crate::error::Complaints;
use crate::{Lamp, Scene, SceneError};

/// The first thing that is where it cannot be.
pub(crate) fn check_placement(scene: &Scene, no: &Complaints<'_>) -> Result<(), SceneError> {
    for (k, rod) in scene.rods.iter().enumerate() {
        for eye in Eye::BOTH {
            if rod.contains(&scene.rig.eye(eye).rig_from_camera.origin_m()) {
                return Err(no.value(
                    format!("rod[{k}]"),
                    "no camera inside a rod",
                    format!("the {} camera inside \"{}\"", eye.name(), rod.id),
                ));
            }
        }
        if let Some(lamp) = scene.lamps.iter().position(|l| rod.contains(&l.position_m)) {
            return Err(no.value(
                format!("lamp[{lamp}].position_m"),
                "no lamp inside a rod",
                format!("it inside rod[{k}] (\"{}\")", rod.id),
            ));
        }
        // How far the rod reaches in front of a camera; 64 points and the radius bound a bent one closely enough.
        let reach_m = Eye::BOTH.map(|eye| {
            let camera_from_rig = scene.rig.eye(eye).rig_from_camera.inverse();
            (0..=64)
                .map(|j| {
                    let along_m = rod.length_m * (f64::from(j) / 64.0 - 0.5);
                    camera_from_rig.point(&rod.axis_at(along_m).0).z + rod.radius_m
                })
                .fold(f64::NEG_INFINITY, f64::max)
        });
        if reach_m.iter().all(|&z| z <= 0.0) {
            return Err(no.value(
                format!("rod[{k}]"),
                "a rod in front of at least one camera",
                format!(
                    "\"{}\" wholly behind both: its foremost point at z = {:.3} m of the left camera, {:.3} m of the right",
                    rod.id, reach_m[0], reach_m[1]
                ),
            ));
        }
    }
    if let Some(seabed) = &scene.seabed {
        let buried = |lamp: &&Lamp| lamp.position_m.z >= seabed.z_m;
        if let Some((k, lamp)) = scene.lamps.iter().enumerate().find(|(_, l)| buried(l)) {
            return Err(no.value(
                format!("lamp[{k}].position_m"),
                format!("z above the seabed, less than {}", seabed.z_m),
                lamp.position_m.z,
            ));
        }
    }
    if let Some(aperture) = scene.lens.aperture {
        let rim_m = 0.5 * aperture.diameter_m();
        let rim_m = [[rim_m, 0.0], [-rim_m, 0.0], [0.0, rim_m], [0.0, -rim_m]].map(Pixel::from);
        for (eye, point_m) in Eye::BOTH.iter().flat_map(|eye| rim_m.map(|at| (eye, at))) {
            if let Err(error) = scene.rig.eye(*eye).through(&point_m, aperture.focus_m) {
                return Err(no.value(
                    "lens.aperture",
                    "a lens that sees ahead, and only water, from the rim of its aperture too",
                    format!("the {} camera: {error}", eye.name()),
                ));
            }
        }
    }
    for (k, occluder) in scene.occluders.iter().enumerate() {
        let inside = |point_m: &Vec3| occluder.shape.contains(point_m);
        let within = |what: String| {
            let found = format!("{what} inside \"{}\"", occluder.id);
            no.value(
                format!("occluder[{k}]"),
                "no camera and no lamp inside it",
                found,
            )
        };
        for eye in Eye::BOTH {
            if inside(&scene.rig.eye(eye).rig_from_camera.origin_m()) {
                return Err(within(format!("the {} camera", eye.name())));
            }
        }
        if let Some(lamp) = scene.lamps.iter().position(|l| inside(&l.position_m)) {
            return Err(within(format!("lamp[{lamp}]")));
        }
    }
    let target = scene.target;
    let grasp_m = scene.rods[target.rod].axis_at(target.along_m).0;
    let camera = scene.rig.eye(target.pick_eye);
    let pick = camera.project(&grasp_m);
    if !pick.is_some_and(|pick| camera.camera.contains(&pick)) {
        let found = pick.map_or("it behind that camera".to_owned(), |pick| {
            format!("it at ({:.1}, {:.1}) px", pick.x, pick.y)
        });
        let eye = target.pick_eye.name();
        return Err(no.value(
            "target",
            format!("a grasp that the {eye} image shows"),
            found,
        ));
    }
    if let Some(seabed) = scene.seabed {
        for eye in Eye::BOTH {
            let z_m = scene.rig.eye(eye).rig_from_camera.origin_m().z;
            if z_m >= seabed.z_m {
                return Err(no.value(
                    "seabed.z_m",
                    format!("below the {} camera, > {z_m}", eye.name()),
                    seabed.z_m,
                ));
            }
        }
        let z_m = grasp_m.z;
        if z_m >= seabed.z_m {
            return Err(no.value(
                "target",
                format!("a grasp above the seabed, z < {}", seabed.z_m),
                format!("z = {z_m}"),
            ));
        }
    }
    Ok(())
}
