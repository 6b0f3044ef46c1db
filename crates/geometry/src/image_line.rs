//! Straight lines in the image, and their total-least-squares fit.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::Pixel;

/// `u cos θ + v sin θ = ρ` (1): θ in (−π/2, π/2], ρ signed, px from the top-left corner.
#[derive(
    Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct ImageLine {
    /// Signed distance of the top-left corner's origin to the line along the normal, px.
    pub rho_px: f64,
    /// Angle of the line's normal to the u axis, rad, in (−π/2, π/2].
    pub theta_rad: f64,
}

impl ImageLine {
    /// A line with its angle brought into (−π/2, π/2]; turning the normal round changes the sign of ρ.
    pub fn new(rho_px: f64, theta_rad: f64) -> Self {
        let mut turns = libm::ceil((theta_rad - FRAC_PI_2) / PI);
        let mut theta = theta_rad - turns * PI;
        // Rounding may have left it just outside.
        if theta > FRAC_PI_2 {
            (theta, turns) = (theta - PI, turns + 1.0);
        } else if theta <= -FRAC_PI_2 {
            (theta, turns) = (theta + PI, turns - 1.0);
        }
        Self {
            rho_px: if libm::fmod(turns, 2.0) == 0.0 {
                rho_px
            } else {
                -rho_px
            },
            theta_rad: theta,
        }
    }

    /// A line from a unit normal and the distance along it.
    pub fn from_normal(normal: &Pixel, rho_px: f64) -> Self {
        Self::new(rho_px, libm::atan2(normal.y, normal.x))
    }

    /// The line through two different points.
    pub fn through(a: &Pixel, b: &Pixel) -> Self {
        let along = (b - a).normalize();
        let normal = Pixel::new(-along.y, along.x);
        Self::from_normal(&normal, normal.dot(a))
    }

    /// Unit normal (cos θ, sin θ).
    pub fn normal(&self) -> Pixel {
        let (sin, cos) = libm::sincos(self.theta_rad);
        Pixel::new(cos, sin)
    }

    /// Unit direction along the line (−sin θ, cos θ): eq (10) with the sign of (17).
    pub fn direction(&self) -> Pixel {
        let (sin, cos) = libm::sincos(self.theta_rad);
        Pixel::new(-sin, cos)
    }

    /// Signed distance of a point, px: eq (4) without the modulus.
    pub fn distance_px(&self, pixel: &Pixel) -> f64 {
        self.normal().dot(pixel) - self.rho_px
    }

    /// The angle between two lines, rad, in [0, π/2].
    pub fn angle_to(&self, other: &Self) -> f64 {
        let difference = libm::fmod(self.theta_rad - other.theta_rad, PI).abs();
        difference.min(PI - difference)
    }
}

/// A total-least-squares line with what its points say of its quality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFit {
    /// The line.
    pub line: ImageLine,
    /// Mean of the points, px.
    pub centroid_px: Pixel,
    /// How many points.
    pub count: usize,
    /// Sum of squared distances to the line, px²: the smaller eigenvalue of the scatter matrix.
    pub scatter_across_px2: f64,
    /// The larger eigenvalue, px²: how far the points reach along the line.
    pub scatter_along_px2: f64,
}

impl LineFit {
    /// Fits the points: minimises (5) by
    ///
    ///   θ = ½ atan2(−2 `S_uv`, `S_vv` − `S_uu`),  ρ = ū cos θ + v̄ sin θ,
    ///
    /// with sums centred on the mean. This is eqs (8) and (9); (9) is printed with the wrong sign and without the rule
    /// that tells the minimum from the maximum. `None` for fewer than two points or points without a direction.
    pub fn of(points: &[Pixel]) -> Option<Self> {
        let count = points.len();
        if count < 2 {
            return None;
        }
        let centroid = points.iter().sum::<Pixel>() / count as f64;
        let (mut s_uu, mut s_vv, mut s_uv) = (0.0, 0.0, 0.0);
        for point in points {
            let d = point - centroid;
            s_uu += d.x * d.x;
            s_vv += d.y * d.y;
            s_uv += d.x * d.y;
        }
        let spread = libm::hypot(s_uu - s_vv, 2.0 * s_uv);
        let along = 0.5 * (s_uu + s_vv + spread);
        if spread <= 1e-9 * along || !spread.is_finite() {
            return None;
        }
        let line = ImageLine::new(0.0, 0.5 * libm::atan2(-2.0 * s_uv, s_vv - s_uu));
        Some(Self {
            line: ImageLine {
                rho_px: line.normal().dot(&centroid),
                ..line
            },
            centroid_px: centroid,
            count,
            scatter_across_px2: (0.5 * (s_uu + s_vv - spread)).max(0.0),
            scatter_along_px2: along,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_line_is_canonical_and_keeps_its_points() {
        for turn in -5..=5 {
            let theta = 0.3 + f64::from(turn) * PI;
            let line = ImageLine::new(if turn % 2 == 0 { 7.0 } else { -7.0 }, theta);
            assert!((line.theta_rad - 0.3).abs() < 1e-14, "{line:?}");
            assert!((line.rho_px - 7.0).abs() < 1e-14, "{line:?}");
        }
        assert_eq!(
            ImageLine::new(3.0, -FRAC_PI_2),
            ImageLine {
                rho_px: -3.0,
                theta_rad: FRAC_PI_2
            }
        );
        assert_eq!(
            ImageLine::new(3.0, FRAC_PI_2),
            ImageLine {
                rho_px: 3.0,
                theta_rad: FRAC_PI_2
            }
        );
    }

    #[test]
    fn line_fit_refuses_a_blob_and_a_point() {
        let corner = |x, y| Pixel::new(x, y);
        assert_eq!(LineFit::of(&[corner(1.0, 1.0)]), None);
        assert_eq!(LineFit::of(&[corner(1.0, 1.0), corner(1.0, 1.0)]), None);
        assert_eq!(
            LineFit::of(&[
                corner(0.0, 0.0),
                corner(0.0, 1.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0)
            ]),
            None
        );
    }
}
