//! Kannala–Brandt ("equidistant", `OpenCV`'s `fisheye`): θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), θ the angle to the axis.

use core::f64::consts::PI;

use super::first_fold;
use crate::Vec3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KannalaBrandt {
    k: [f64; 4],
    /// θ of the first fold, or π.
    pub(super) fold_rad: f64,
}

impl KannalaBrandt {
    pub(super) fn new(k: [f64; 4]) -> Self {
        let mut model = Self { k, fold_rad: PI };
        model.fold_rad = first_fold(PI, |theta| model.slope(theta));
        model
    }

    fn distorted(&self, theta: f64) -> f64 {
        let ([k1, k2, k3, k4], t) = (self.k, theta * theta);
        theta * (1.0 + t * (k1 + t * (k2 + t * (k3 + t * k4))))
    }

    fn slope(&self, theta: f64) -> f64 {
        let ([k1, k2, k3, k4], t) = (self.k, theta * theta);
        1.0 + t * (3.0 * k1 + t * (5.0 * k2 + t * (7.0 * k3 + t * 9.0 * k4)))
    }

    pub(super) fn project(&self, point_m: &Vec3) -> Option<(f64, f64)> {
        let r = libm::hypot(point_m.x, point_m.y);
        let theta = libm::atan2(r, point_m.z);
        // The camera's own centre has no direction; `!(…)` refuses NaN too.
        if !(theta < self.fold_rad) || (r == 0.0 && point_m.z <= 0.0) {
            return None;
        }
        // On the axis x is zero, and so is its image.
        let scale = if r > 0.0 {
            self.distorted(theta) / r
        } else {
            0.0
        };
        Some((point_m.x * scale, point_m.y * scale))
    }

    /// Unit ray; θ by Newton's method kept inside a bracket, since the polynomial is monotone up to the fold.
    pub(super) fn ray(&self, xd: f64, yd: f64) -> Option<Vec3> {
        let wanted = libm::hypot(xd, yd);
        if wanted == 0.0 {
            return Some(Vec3::z());
        }
        let (mut low, mut high) = (0.0, self.fold_rad);
        if !(wanted <= self.distorted(high)) {
            return None;
        }
        let mut theta = wanted.min(0.5 * high);
        for _ in 0..100 {
            let error = self.distorted(theta) - wanted;
            if error > 0.0 {
                high = theta;
            } else {
                low = theta;
            }
            let step = error / self.slope(theta);
            // Before the bracket: at the root a step too small to move θ must not be taken for one that leaves it.
            if step.abs() <= 2e-16 * theta {
                break;
            }
            let newton = theta - step;
            theta = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        let (sin, cos) = libm::sincos(theta);
        Some(Vec3::new(xd / wanted * sin, yd / wanted * sin, cos))
    }
}
