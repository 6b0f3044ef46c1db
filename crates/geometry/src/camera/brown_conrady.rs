//! Brown–Conrady ("radtan", "plumb bob"), as in `OpenCV`'s `calib3d`:
//! x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2x²), y' likewise with p1 and p2 exchanged.

use super::first_fold;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BrownConrady {
    k: [f64; 3],
    p: [f64; 2],
    /// r² of the first fold of the radial polynomial; beyond it the formula draws ghosts.
    pub(super) fold_r2: f64,
}

/// r up to which a fold is looked for: 84° off axis, beyond which this model is not used.
const MAX_R: f64 = 10.0;

impl BrownConrady {
    pub(super) fn new([k1, k2, p1, p2, k3]: [f64; 5]) -> Self {
        let slope = |r: f64| {
            let s = r * r;
            1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3))
        };
        let fold_r = first_fold(MAX_R, slope);
        Self {
            k: [k1, k2, k3],
            p: [p1, p2],
            fold_r2: fold_r * fold_r,
        }
    }

    pub(super) fn distort(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        (x * x + y * y < self.fold_r2).then(|| self.distort_unchecked(x, y))
    }

    fn distort_unchecked(&self, x: f64, y: f64) -> (f64, f64) {
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// Newton's method from the distorted point, to the last bits in a handful of steps. A step that leaves the
    /// fold-free disc or does not come nearer is halved: lenses whose k1 and k2 differ in sign make full steps overshoot.
    pub(super) fn undistort(&self, xd: f64, yd: f64) -> Option<(f64, f64)> {
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let error = |x: f64, y: f64| {
            let (fx, fy) = self.distort_unchecked(x, y);
            (fx - xd, fy - yd)
        };
        // A pincushion's distorted point may lie outside the disc: start inside it.
        let outside = (xd * xd + yd * yd) / self.fold_r2;
        let start = if outside < 1.0 {
            1.0
        } else {
            0.9 / outside.sqrt()
        };
        let (mut x, mut y) = (xd * start, yd * start);
        let (mut ex, mut ey) = error(x, y);
        'newton: for _ in 0..50 {
            let r2 = x * x + y * y;
            let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
            let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
            let jxx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
            let jyy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
            let jxy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
            let det = jxx * jyy - jxy * jxy;
            if !(det > 0.0) {
                return None;
            }
            let (mut dx, mut dy) = ((jyy * ex - jxy * ey) / det, (jxx * ey - jxy * ex) / det);
            for _ in 0..12 {
                let (tx, ty) = (x - dx, y - dy);
                let (fx, fy) = error(tx, ty);
                if tx * tx + ty * ty < self.fold_r2 && fx * fx + fy * fy < ex * ex + ey * ey {
                    (x, y, ex, ey) = (tx, ty, fx, fy);
                    continue 'newton;
                }
                if ex * ex + ey * ey < 1e-26 {
                    break 'newton;
                }
                (dx, dy) = (0.5 * dx, 0.5 * dy);
            }
            break;
        }
        // Also refuses NaN.
        (x * x + y * y < self.fold_r2 && ex.abs() < 1e-12 && ey.abs() < 1e-12).then_some((x, y))
    }
}
