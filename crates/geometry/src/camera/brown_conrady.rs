//! Brown–Conrady ("radtan", "plumb bob"), as in `OpenCV`'s `calib3d`:
//! x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2x²), y' likewise with p1 and p2 exchanged.

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BrownConrady {
    k: [f64; 3],
    p: [f64; 2],
    /// r² of the first fold of the radial polynomial; beyond it the formula draws ghosts.
    fold_r2: f64,
}

/// r² up to which a fold is looked for: 84° off axis, beyond which this model is not used.
const MAX_R2: f64 = 100.0;

impl BrownConrady {
    pub(super) fn new([k1, k2, p1, p2, k3]: [f64; 5]) -> Self {
        let slope = |s: f64| 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3));
        // Finer steps near the axis, where lenses live: s = MAX (i/n)².
        let fold_r2 = (1..=4096)
            .map(|i| MAX_R2 * (f64::from(i) / 4096.0) * (f64::from(i) / 4096.0))
            .find(|&s| slope(s) <= 0.0);
        Self {
            k: [k1, k2, k3],
            p: [p1, p2],
            fold_r2: fold_r2.unwrap_or(MAX_R2),
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

    /// Newton's method from the distorted point: quadratic, to the last bits in a handful of steps.
    pub(super) fn undistort(&self, xd: f64, yd: f64) -> Option<(f64, f64)> {
        let ([k1, k2, k3], [p1, p2]) = (self.k, self.p);
        let (mut x, mut y) = (xd, yd);
        for _ in 0..40 {
            let (fx, fy) = self.distort_unchecked(x, y);
            let (ex, ey) = (fx - xd, fy - yd);
            if ex * ex + ey * ey < 1e-30 {
                break;
            }
            let r2 = x * x + y * y;
            let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
            let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
            let jxx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
            let jyy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
            let jxy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
            let det = jxx * jyy - jxy * jxy;
            if det <= 0.0 {
                return None;
            }
            x -= (jyy * ex - jxy * ey) / det;
            y -= (jxx * ey - jxy * ex) / det;
        }
        let (fx, fy) = self.distort(x, y)?;
        ((fx - xd).abs() < 1e-12 && (fy - yd).abs() < 1e-12).then_some((x, y))
    }
}
