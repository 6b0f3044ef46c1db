//! Cameras behind flat ports, and what a solver may be told of them.

use nalgebra::{Matrix4, Vector4};
use rodsight_geometry::port::{Band, Port};
use rodsight_geometry::{Camera, Distortion, MountedCamera, Pixel, Rig, RigFile, Vec3};

use super::draft::{Draft, parse_rig};

/// What the solver takes the ports for. Without ports the cameras are those of the last: in water, with the focal length that those
/// behind ports have near their axes.
pub(crate) const PORTS: &[&str] = &["no port", "ports", "distortion", "focal length"];

const PORT_RIG: &str = include_str!("../../../../../scenes/rigs/flat_port.toml");
/// Where the target of a calibration under water stands, m ahead.
const CALIBRATED_AT_M: f64 = 2.5;

pub(crate) fn port(draft: &mut Draft, name: &str) {
    let behind = parse_rig(PORT_RIG, "rigs/flat_port.toml");
    let rig = behind
        .to_rig("rigs/flat_port.toml".as_ref())
        .expect("a rig");
    let pinholes = believed(&rig, pinhole);
    draft.file.rig = Some(match name {
        "no port" => RigFile::from_rig(&pinholes),
        _ => behind,
    });
    draft.believed = match name {
        "distortion" => Some(believed(&rig, fitted)),
        "focal length" => Some(pinholes),
        _ => None,
    };
}

fn believed(rig: &Rig, camera: fn(&Camera, &Port) -> Camera) -> Rig {
    let without = |mounted: &MountedCamera| {
        let port = mounted.port.expect("a camera behind a port");
        MountedCamera::new(camera(&mounted.camera, &port), mounted.rig_from_camera)
    };
    Rig {
        left: without(&rig.left),
        right: without(&rig.right),
    }
}

/// One whose focal length is as many times longer as the water's index says: right near the axis.
fn pinhole(in_air: &Camera, port: &Port) -> Camera {
    let water_index = port.water_index()[Band::Green.index()];
    with(in_air, water_index, Distortion::None)
}

/// Focal length and radial distortion as a calibration under water finds them, by least squares over the image of a plane:
/// tangents in air = tangents in water · (f + f k₁ r² + f k₂ r⁴ + f k₃ r⁶).
fn fitted(in_air: &Camera, port: &Port) -> Camera {
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    let i = in_air.intrinsics();
    for (x, y) in (0..32).flat_map(|x| (0..18).map(move |y| (f64::from(x), f64::from(y)))) {
        let at = Pixel::new(
            (x + 0.5) / 32.0 * f64::from(i.width_px),
            (y + 0.5) / 18.0 * f64::from(i.height_px),
        );
        let air = in_air.ray(&at).expect("within the image");
        let ray = port.water_ray(&air).expect("through the port");
        let ahead = (CALIBRATED_AT_M - ray.origin_m.z) / ray.direction.z;
        let point_m: Vec3 = ray.origin_m + ray.direction * ahead;
        let (water, air) = (point_m.xy() / point_m.z, air.xy() / air.z);
        let r2 = water.norm_squared();
        let powers = Vector4::new(1.0, r2, r2 * r2, r2 * r2 * r2);
        normal += powers * powers.transpose() * r2;
        right += powers * water.dot(&air);
    }
    let fit = normal
        .lu()
        .solve(&right)
        .expect("points all over the image");
    let [k1, k2, k3] = [1, 2, 3].map(|k| fit[k] / fit[0]);
    with(
        in_air,
        fit[0],
        Distortion::BrownConrady([k1, k2, 0.0, 0.0, k3]),
    )
}

fn with(in_air: &Camera, times_longer: f64, distortion: Distortion) -> Camera {
    let mut i = *in_air.intrinsics();
    i.fx_px *= times_longer;
    i.fy_px *= times_longer;
    Camera::new(i, distortion).expect("a camera")
}
