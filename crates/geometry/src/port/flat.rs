//! A plane plate of glass between the lens and the water.

use super::snell::refract;
use super::{Indices, WaterRay};
use crate::Vec3;

/// A flat port: a plate with parallel faces. The camera behind it has no single centre: in the water its rays meet on the normal
/// through the entrance pupil, each at another place (Agrawal et al. 2012, "axial camera").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatPort {
    /// Unit normal in the camera's frame, towards the water.
    pub normal: Vec3,
    /// From the camera's centre (the entrance pupil) to the inner face, along the normal, m.
    pub distance_m: f64,
    /// Thickness of the glass, m.
    pub thickness_m: f64,
}

impl FlatPort {
    pub(super) fn water_ray(&self, air: &Vec3, n: &Indices) -> Option<WaterRay> {
        let glass = refract(air, &self.normal, 1.0, n.glass)?;
        let water = refract(&glass.direction, &self.normal, n.glass, n.water)?;
        Some(WaterRay {
            origin_m: air * (self.distance_m / air.dot(&self.normal))
                + glass.direction * (self.thickness_m / glass.direction.dot(&self.normal)),
            direction: water.direction,
            gain: n.gain([glass.transmittance, water.transmittance]),
        })
    }

    /// The unit direction in air in which a point in the water is seen. In the plane through normal and point, with the tangent w
    /// of the angle in air as unknown,
    ///
    ///   r = Σ hᵢ w / √(nᵢ² + (nᵢ² − 1) w²)
    ///
    /// over air (n = 1), glass and water. The right side grows and is concave, so Newton's method from w = 0 climbs to the root
    /// without ever passing it.
    pub(super) fn air_direction(&self, point_m: &Vec3, n: &Indices) -> Option<Vec3> {
        let depth_m = point_m.dot(&self.normal) - self.distance_m - self.thickness_m;
        // `!(…)` refuses NaN too.
        if !(depth_m > 0.0) {
            return None;
        }
        let across = point_m - self.normal * point_m.dot(&self.normal);
        let wanted_m = across.norm();
        if wanted_m == 0.0 {
            return Some(self.normal);
        }
        let layers = [
            (self.distance_m, 1.0),
            (self.thickness_m, n.glass),
            (depth_m, n.water),
        ];
        let mut w = 0.0;
        for _ in 0..MAX_STEPS {
            let (mut reached_m, mut slope_m) = (0.0, 0.0);
            for (height_m, index) in layers {
                let root2 = index * index + (index * index - 1.0) * w * w;
                let root = root2.sqrt();
                reached_m += height_m * w / root;
                slope_m += height_m * index * index / (root2 * root);
            }
            let next = w + (wanted_m - reached_m) / slope_m;
            // With the pupil on the glass, what lies beyond the critical angle is seen nowhere: w runs away.
            if !next.is_finite() {
                return None;
            }
            // From below until rounding turns it back.
            if next <= w {
                return Some((self.normal + across * (w / wanted_m)).normalize());
            }
            w = next;
        }
        None
    }
}

/// Newton takes less than ten steps on any point a camera may see; each step beyond the critical angle doubles w.
const MAX_STEPS: u32 = 100;
