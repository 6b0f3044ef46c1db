//! From the four limbs to the rod in space, eqs (10)–(31), in closed form.

use rodsight_geometry::{
    Camera, Cylinder, Eye, GraspError, ImageLine, Line3, PaperGrasp, Pixel, Plane, Rig, Side,
    TangentPair, TangentPlane, Vec3, surface_foot,
};

use super::Centre;

/// What stays fixed while the limbs vary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting<'a> {
    pub rig: &'a Rig,
    pub centre: Centre,
    /// Ray of the pick: origin (m) and unit direction in the rig frame.
    pub pick: Option<(Vec3, Vec3)>,
    /// Ray through the middle of the rod as the left eye sees it.
    pub middle: (Vec3, Vec3),
    /// Radius given beforehand and its weight against the limbs', in [0, 1].
    pub radius: Option<(f64, f64)>,
    /// Radius and its standard deviation, m, by which the axis is placed where the planes alone do not.
    pub by_radius: Option<(f64, f64)>,
}

/// The rod by the limbs alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Location {
    /// `point_m` is the foot of the perpendicular from the midpoint of the camera centres.
    pub axis: Line3,
    pub plane_angle_rad: f64,
    /// Angle between the baseline and the axis planes: near 0 the rod lies in one plane with the baseline, and the two eyes see
    /// nothing of its depth. Unlike the angle of the planes it does not scale with baseline over range.
    pub off_baseline_rad: f64,
    /// Radius by each eye, m.
    pub radii_m: [f64; 2],
    /// Their mean, or what the radius given beforehand makes of it, m.
    pub radius_m: f64,
    /// Where the ray of [`Setting::middle`] passes the axis, m.
    pub seen_m: Vec3,
    /// Distance along that ray, m; negative: behind the camera.
    pub seen_along_m: f64,
    /// Surface-foot point, or the paper's where the ray misses the rod.
    pub grasp_m: Option<Vec3>,
}

/// The centre line of two limbs by the paper: the mean of (ρ, θ), after turning the normals alike (the mean across the wrap of
/// θ, or of a ρ of either sign, would be another line altogether).
pub fn average(limbs: &[ImageLine; 2]) -> ImageLine {
    use core::f64::consts::PI;
    let [a, b] = limbs;
    let (mut rho, mut theta) = (b.rho_px, b.theta_rad);
    if a.normal().dot(&b.normal()) < 0.0 {
        rho = -rho;
        theta += if theta < a.theta_rad { PI } else { -PI };
    }
    ImageLine::new(0.5 * (a.rho_px + rho), 0.5 * (a.theta_rad + theta))
}

/// Normals of the tangent planes of two limbs in the camera frame, turned alike.
pub(crate) fn tangent_normals(camera: &Camera, limbs: &[ImageLine; 2]) -> [Vec3; 2] {
    let [a, b] = limbs.map(|line| camera.plane_normal(&line));
    [a, if a.dot(&b) < 0.0 { -b } else { b }]
}

/// The centre line of two limbs as a method sees it.
pub(crate) fn centerline(
    camera: &Camera,
    limbs: &[ImageLine; 2],
    centre: Centre,
) -> Option<ImageLine> {
    match centre {
        Centre::Average => Some(average(limbs)),
        Centre::Bisector => {
            let [a, b] = tangent_normals(camera, limbs);
            camera.image_line(&(a + b))
        }
    }
}

/// The axis direction by the convergence of the limbs in each eye, averaged: weak, but there even for a rod parallel to the
/// baseline. Rig frame, unit.
pub(crate) fn taper_direction(rig: &Rig, limbs: &[[ImageLine; 2]; 2]) -> Option<Vec3> {
    let [left, right] = [(Eye::Left, &limbs[0]), (Eye::Right, &limbs[1])].map(|(eye, lines)| {
        let mounted = rig.eye(eye);
        let [a, b] = tangent_normals(&mounted.camera, lines);
        // Not normalised: the length is sin 2α, so that the eye that sees the rod wider counts more.
        mounted.rig_from_camera.direction(&a.cross(&b))
    });
    let sum = if left.dot(&right) < 0.0 {
        left - right
    } else {
        left + right
    };
    (sum.norm() > 1e-12).then(|| sum.normalize())
}

/// Where the limbs say the rod is; `None` when the two axis planes are parallel to rounding.
pub(crate) fn locate(setting: &Setting<'_>, limbs: &[[ImageLine; 2]; 2]) -> Option<Location> {
    let Setting { rig, centre, .. } = setting;
    let mut planes = Vec::with_capacity(2);
    let mut half_sines = [0.0; 2];
    for (k, eye) in Eye::BOTH.into_iter().enumerate() {
        let mounted = rig.eye(eye);
        let line = centerline(&mounted.camera, &limbs[k], *centre)?;
        let normal = mounted.camera.plane_normal(&line);
        planes.push(Plane::through_camera(&mounted.rig_from_camera, &normal));
        let [a, b] = tangent_normals(&mounted.camera, &limbs[k]);
        half_sines[k] = 0.5 * (a - b).norm();
    }
    let centres = Eye::BOTH.map(|eye| rig.eye(eye).rig_from_camera.origin_m());
    let between = 0.5 * (centres[0] + centres[1]);
    let axis = match setting.by_radius {
        None => Line3::from_planes(&planes[0], &planes[1], &centres[0]).ok()?,
        Some((radius_m, _)) => axis_by_radius(setting, limbs, radius_m)?,
    };
    let axis = Line3 {
        point_m: axis.foot(&between),
        ..axis
    }
    .with_canonical_sign();
    let radii_m = [0, 1].map(|k| axis.distance_m(&centres[k]) * half_sines[k]);
    let measured_m = 0.5 * (radii_m[0] + radii_m[1]);
    let radius_m = setting.radius.map_or(measured_m, |(prior, weight)| {
        weight * prior + (1.0 - weight) * measured_m
    });
    let (seen_m, seen_along_m) = nearest(&axis, &setting.middle)?;
    let sin = planes[0].normal.cross(&planes[1].normal).norm();
    Some(Location {
        axis,
        plane_angle_rad: libm::asin(sin.min(1.0)),
        off_baseline_rad: off_baseline(&planes, &(centres[1] - centres[0])),
        radii_m,
        radius_m,
        seen_m,
        seen_along_m,
        grasp_m: setting
            .pick
            .and_then(|pick| grasp(&axis, radius_m, &pick).ok())
            .map(|(grasp_m, _)| grasp_m),
    })
}

/// The axis of the cylinder of known radius that touches all four tangent planes best.
fn axis_by_radius(
    setting: &Setting<'_>,
    limbs: &[[ImageLine; 2]; 2],
    radius_m: f64,
) -> Option<Line3> {
    let mut planes = Vec::with_capacity(4);
    for (eye, pair) in Eye::BOTH.into_iter().zip(limbs) {
        let mounted = setting.rig.eye(eye);
        let camera = mounted.camera.without_distortion();
        let [a, b] = tangent_normals(&camera, pair);
        // Any point of the centre line shows on which side the rod is.
        let line = camera.image_line(&(a + b))?;
        let i = camera.intrinsics();
        let centre = Pixel::new(i.cx_px, i.cy_px);
        let seen = camera.ray(&(centre - line.normal() * line.distance_px(&centre)))?;
        let view = TangentPair::one_view(&a, &b, &seen)?;
        let sides = match view.first_side {
            Side::Plus => [Side::Plus, Side::Minus],
            Side::Minus => [Side::Minus, Side::Plus],
        };
        for (normal, side) in view.normals.iter().zip(sides) {
            planes.push(TangentPlane {
                normal: mounted.rig_from_camera.direction(normal),
                centre_m: mounted.rig_from_camera.origin_m(),
                side,
            });
        }
    }
    let fit = Cylinder::from_tangent_planes(&planes, Some(radius_m)).ok()?;
    Some(fit.cylinder.axis)
}

fn off_baseline(planes: &[Plane], baseline: &Vec3) -> f64 {
    let sine = |plane: &Plane| plane.normal.dot(baseline).abs() / baseline.norm();
    let most = planes.iter().map(sine).fold(0.0, f64::max);
    libm::asin(most.min(1.0))
}

/// The surface-foot point and the paper's. A ray that misses the surface a little gets the paper's for both: the former tends
/// to the latter where the ray touches.
pub(crate) fn grasp(
    axis: &Line3,
    radius_m: f64,
    (origin_m, direction): &(Vec3, Vec3),
) -> Result<(Vec3, PaperGrasp), GraspError> {
    let paper = PaperGrasp::new(axis, origin_m, direction)?;
    let cylinder = Cylinder {
        axis: *axis,
        radius_m,
    };
    let foot = surface_foot(&cylinder, origin_m, direction).unwrap_or(paper.point_m);
    Ok((foot, paper))
}

/// The point of the axis nearest to a ray, and the distance along the ray, m, of either sign.
fn nearest(axis: &Line3, (origin_m, direction): &(Vec3, Vec3)) -> Option<(Vec3, f64)> {
    let (d, w) = (axis.direction, axis.point_m - origin_m);
    let sin2 = d.cross(direction).norm_squared();
    if sin2 < 1e-18 {
        return None;
    }
    let cos = d.dot(direction);
    let mu = (cos * w.dot(direction) - w.dot(&d)) / sin2;
    let point = axis.point_m + d * mu;
    Some((point, (point - origin_m).dot(direction)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rodsight_geometry::radians;

    /// The paper's Tables 2 and 3 to its Table 4.
    #[test]
    fn average_gives_table_4() {
        let line = |rho, theta_deg| ImageLine::new(rho, radians(theta_deg));
        let left = average(&[line(643.9993, -12.227), line(570.1830, -13.531)]);
        assert!((left.rho_px - 607.0912).abs() < 1e-4, "{left:?}");
        assert!((left.theta_rad - radians(-12.879)).abs() < 1e-8);
        let right = average(&[line(411.8512, -11.924), line(476.4217, -11.198)]);
        assert!((right.rho_px - 444.13645).abs() < 1e-6, "{right:?}");
        assert!((right.theta_rad - radians(-11.561)).abs() < 1e-8);
    }

    #[test]
    fn average_across_the_wrap_and_of_either_sign_of_rho() {
        let a = ImageLine::new(200.0, radians(89.0));
        let b = ImageLine::new(220.0, radians(91.0));
        assert!(b.rho_px < 0.0, "stored with the other normal");
        for pair in [[a, b], [b, a]] {
            let mean = average(&pair);
            assert!((mean.theta_rad - radians(90.0)).abs() < 1e-12, "{mean:?}");
            assert!((mean.rho_px - 210.0).abs() < 1e-12, "{mean:?}");
        }
        let near_zero = average(&[ImageLine::new(-3.0, 0.1), ImageLine::new(5.0, 0.1)]);
        assert!((near_zero.rho_px - 1.0).abs() < 1e-12);
    }
}
