//! Central cameras, in air or ideal ones in water: pixel ↔ ray, with the lens distortions that calibration tools write.

mod brown_conrady;
mod kannala_brandt;

use brown_conrady::BrownConrady;
use kannala_brandt::KannalaBrandt;

use crate::{ImageLine, Pixel, Vec3};

/// Sensor size, focal lengths and principal point, px from the top-left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Intrinsics {
    pub width_px: u32,
    pub height_px: u32,
    pub fx_px: f64,
    pub fy_px: f64,
    pub cx_px: f64,
    pub cy_px: f64,
}

/// Lens distortion by its published name; coefficients are dimensionless and in the order `OpenCV` writes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Distortion {
    /// An ideal pinhole.
    #[default]
    None,
    /// Brown 1966, Conrady 1919, as in `OpenCV`: `[k1, k2, p1, p2, k3]`.
    BrownConrady([f64; 5]),
    /// Kannala & Brandt 2006, as in `OpenCV`'s `fisheye`: `[k1, k2, k3, k4]`.
    KannalaBrandt([f64; 4]),
}

/// Why a camera cannot exist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum CameraError {
    #[error("{key}: expected {expected}, found {found}")]
    Value {
        key: &'static str,
        expected: &'static str,
        found: f64,
    },
    #[error(
        "distortion: the pixel ({u_px}, {v_px}) of the image has no ray: the coefficients fold the image over itself"
    )]
    Folds { u_px: f64, v_px: f64 },
    #[error(
        "the pixel ({u_px}, {v_px}) of the image: expected a ray that goes ahead, found one that goes sideways or backwards: no plane is in \
         focus there"
    )]
    Sideways { u_px: f64, v_px: f64 },
    #[error(
        "port: the pixel ({u_px}, {v_px}) of the image looks past the glass: its normal is turned too far from that corner's rays"
    )]
    PastPort { u_px: f64, v_px: f64 },
}

/// A central camera. [`ray`](Self::ray) and [`project`](Self::project) are inverse to each other on the whole image:
/// the constructor refuses a distortion for which they are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    intrinsics: Intrinsics,
    distortion: Distortion,
    model: Model,
    /// How much less the tangents of rays, x/z and y/z, are than those of the lens's centre.
    shift: Pixel,
}

/// The distortion prepared for use: plane z = 1 ↔ distorted plane.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Model {
    Pinhole,
    BrownConrady(BrownConrady),
    KannalaBrandt(KannalaBrandt),
}

/// Where `slope`, positive at 0, first becomes zero; `limit` if it does not before.
fn first_fold(limit: f64, slope: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 4096;
    let at = |i: u32| limit * f64::from(i) / f64::from(STEPS);
    let Some(beyond) = (1..=STEPS).find(|&i| !(slope(at(i)) > 0.0)) else {
        return limit;
    };
    let (mut low, mut high) = (at(beyond - 1), at(beyond));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

impl Camera {
    /// A camera, or why it cannot be one.
    ///
    /// # Errors
    /// Not finite or not positive focal lengths, an empty image, or a distortion that is not invertible on the image.
    pub fn new(intrinsics: Intrinsics, distortion: Distortion) -> Result<Self, CameraError> {
        let positive = |key, found: f64| {
            if found.is_finite() && found > 0.0 {
                Ok(())
            } else {
                Err(CameraError::Value {
                    key,
                    expected: "a positive number",
                    found,
                })
            }
        };
        let finite = |key, found: f64| {
            if found.is_finite() {
                Ok(())
            } else {
                Err(CameraError::Value {
                    key,
                    expected: "a finite number",
                    found,
                })
            }
        };
        positive("width_px", f64::from(intrinsics.width_px))?;
        positive("height_px", f64::from(intrinsics.height_px))?;
        positive("fx_px", intrinsics.fx_px)?;
        positive("fy_px", intrinsics.fy_px)?;
        finite("cx_px", intrinsics.cx_px)?;
        finite("cy_px", intrinsics.cy_px)?;
        let model = match distortion {
            Distortion::None => Model::Pinhole,
            Distortion::BrownConrady(k) => {
                for value in k {
                    finite("distortion", value)?;
                }
                Model::BrownConrady(BrownConrady::new(k))
            }
            Distortion::KannalaBrandt(k) => {
                for value in k {
                    finite("distortion", value)?;
                }
                Model::KannalaBrandt(KannalaBrandt::new(k))
            }
        };
        let camera = Self {
            intrinsics,
            distortion,
            model,
            shift: Pixel::zeros(),
        };
        if let Some((u_px, v_px)) = camera.blind_at() {
            return Err(CameraError::Folds { u_px, v_px });
        }
        Ok(camera)
    }

    /// A place of the image without a ray. The border is where a fold shows first.
    fn blind_at(&self) -> Option<(f64, f64)> {
        let (width, height) = (
            f64::from(self.intrinsics.width_px),
            f64::from(self.intrinsics.height_px),
        );
        for i in 0..=32 {
            let s = f64::from(i) / 32.0;
            for (u_px, v_px) in [
                (s * width, 0.0),
                (s * width, height),
                (0.0, s * height),
                (width, s * height),
            ] {
                if self.ray(&Pixel::new(u_px, v_px)).is_none() {
                    return Some((u_px, v_px));
                }
            }
        }
        None
    }

    /// Size, focal lengths, principal point.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// The distortion it was made from.
    pub fn distortion(&self) -> &Distortion {
        &self.distortion
    }

    /// The same lens through another point than its centre: the tangents of its rays, x/z and y/z, are less by a shift. Without a
    /// distortion that is a principal point elsewhere.
    ///
    /// # Errors
    /// A lens that sees sideways or backwards, where rays have no tangents.
    pub fn with_rays_shifted(&self, shift: &Pixel) -> Result<Self, CameraError> {
        let mut camera = *self;
        if self.is_pinhole() {
            camera.intrinsics.cx_px += self.intrinsics.fx_px * shift.x;
            camera.intrinsics.cy_px += self.intrinsics.fy_px * shift.y;
        } else {
            camera.shift += shift;
            if let Some((u_px, v_px)) = camera.blind_at() {
                return Err(CameraError::Sideways { u_px, v_px });
            }
        }
        Ok(camera)
    }

    /// How much less the tangents of rays are than those of the lens's centre; zero without a distortion.
    pub fn shift(&self) -> &Pixel {
        &self.shift
    }

    /// Whether straight rods are straight lines in the image.
    pub fn is_pinhole(&self) -> bool {
        self.model == Model::Pinhole
    }

    /// Where the distortion folds the image over itself, beyond which nothing is seen: r² on the plane z = 1 for
    /// [`Distortion::BrownConrady`], the angle to the axis in rad for [`Distortion::KannalaBrandt`].
    pub fn fold(&self) -> f64 {
        match &self.model {
            Model::Pinhole => f64::INFINITY,
            Model::BrownConrady(model) => model.fold_r2,
            Model::KannalaBrandt(model) => model.fold_rad,
        }
    }

    /// The same camera without its distortion: the image that "undistorted" pixels live in.
    #[must_use]
    pub fn without_distortion(&self) -> Self {
        let mut intrinsics = self.intrinsics;
        intrinsics.cx_px += intrinsics.fx_px * self.shift.x;
        intrinsics.cy_px += intrinsics.fy_px * self.shift.y;
        Self {
            intrinsics,
            distortion: Distortion::None,
            model: Model::Pinhole,
            shift: Pixel::zeros(),
        }
    }

    /// A unit ray of the lens's centre as it is with its tangents shifted.
    fn shifted(&self, ray: Vec3) -> Option<Vec3> {
        if self.shift == Pixel::zeros() {
            return Some(ray);
        }
        let tangents = ray.xy() / ray.z - self.shift;
        (ray.z > 0.0).then(|| Vec3::new(tangents.x, tangents.y, 1.0).normalize())
    }

    /// The inverse: a direction, of any length, as the lens's centre has it.
    fn unshifted(&self, direction: &Vec3) -> Option<Vec3> {
        if self.shift == Pixel::zeros() {
            return Some(*direction);
        }
        let tangents = direction.xy() / direction.z + self.shift;
        (direction.z > 0.0).then(|| Vec3::new(tangents.x, tangents.y, 1.0))
    }

    /// The unit direction, in the camera frame, that is seen at `pixel`; `None` where the lens sees nothing.
    pub fn ray(&self, pixel: &Pixel) -> Option<Vec3> {
        let i = &self.intrinsics;
        let (xd, yd) = ((pixel.x - i.cx_px) / i.fx_px, (pixel.y - i.cy_px) / i.fy_px);
        let ray = match &self.model {
            Model::Pinhole => Some(Vec3::new(xd, yd, 1.0).normalize()),
            Model::BrownConrady(model) => model
                .undistort(xd, yd)
                .map(|(x, y)| Vec3::new(x, y, 1.0).normalize()),
            Model::KannalaBrandt(model) => model.ray(xd, yd),
        };
        self.shifted(ray?)
    }

    /// The pixel at which a point of the camera frame is seen (possibly outside the image); `None` behind the camera or
    /// beyond the angle at which the distortion folds.
    pub fn project(&self, point_m: &Vec3) -> Option<Pixel> {
        let point_m = self.unshifted(point_m)?;
        let (xd, yd) = match &self.model {
            Model::KannalaBrandt(model) => model.project(&point_m)?,
            // `!(…)` refuses NaN too.
            Model::Pinhole | Model::BrownConrady(_) if !(point_m.z > 0.0) => return None,
            Model::Pinhole => (point_m.x / point_m.z, point_m.y / point_m.z),
            Model::BrownConrady(model) => {
                model.distort(point_m.x / point_m.z, point_m.y / point_m.z)?
            }
        };
        let i = &self.intrinsics;
        Some(Pixel::new(i.fx_px * xd + i.cx_px, i.fy_px * yd + i.cy_px))
    }

    /// Where the pixel would be had the lens no distortion (same focal lengths and principal point).
    pub fn undistort(&self, pixel: &Pixel) -> Option<Pixel> {
        match self.model {
            Model::Pinhole => Some(*pixel),
            Model::BrownConrady(_) | Model::KannalaBrandt(_) => {
                self.without_distortion().project(&self.ray(pixel)?)
            }
        }
    }

    /// Whether a pixel lies in the image.
    pub fn contains(&self, pixel: &Pixel) -> bool {
        (0.0..=f64::from(self.intrinsics.width_px)).contains(&pixel.x)
            && (0.0..=f64::from(self.intrinsics.height_px)).contains(&pixel.y)
    }

    /// Unit normal, in the camera frame, of the plane through the camera centre and a line of the *undistorted* image:
    /// eqs (15) and (17) with `n = Kᵀ ℓ`, so that `fx ≠ fy` is right too. For `fx = fy = k` it is (`n_u`, `n_v`, −ρ̄) normalised.
    pub fn plane_normal(&self, line: &ImageLine) -> Vec3 {
        let i = self.without_distortion().intrinsics;
        let n = line.normal();
        Vec3::new(
            i.fx_px * n.x,
            i.fy_px * n.y,
            i.cx_px * n.x + i.cy_px * n.y - line.rho_px,
        )
        .normalize()
    }

    /// The line of the undistorted image in which a plane through the camera centre is seen; `None` for the plane
    /// parallel to the image. Inverse of [`plane_normal`](Self::plane_normal) up to the sign of the normal.
    pub fn image_line(&self, plane_normal: &Vec3) -> Option<ImageLine> {
        let i = self.without_distortion().intrinsics;
        let (a, b) = (plane_normal.x / i.fx_px, plane_normal.y / i.fy_px);
        let norm = libm::hypot(a, b);
        let rho = i.cx_px * a + i.cy_px * b - plane_normal.z;
        (norm > 0.0 && (rho / norm).is_finite())
            .then(|| ImageLine::from_normal(&Pixel::new(a / norm, b / norm), rho / norm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn intrinsics() -> Intrinsics {
        Intrinsics {
            width_px: 640,
            height_px: 480,
            fx_px: 500.0,
            fy_px: 510.0,
            cx_px: 322.0,
            cy_px: 236.5,
        }
    }

    #[test]
    fn folding_distortion_is_refused() {
        let folded = Camera::new(
            intrinsics(),
            Distortion::BrownConrady([-2.0, 0.0, 0.0, 0.0, 0.0]),
        );
        assert!(
            matches!(folded, Err(CameraError::Folds { .. })),
            "{folded:?}"
        );
    }

    #[test]
    fn projection_beyond_the_fold_is_none_not_a_ghost() {
        let camera = Camera::new(
            intrinsics(),
            Distortion::BrownConrady([-0.2, 0.0, 0.0, 0.0, 0.0]),
        )
        .unwrap();
        // r = 5: 5(1 − 0.2·25) folds back through the centre of the image.
        assert_eq!(camera.project(&Vec3::new(5.0, 0.0, 1.0)), None);
    }

    #[test]
    fn behind_the_camera_is_none() {
        let camera = Camera::new(intrinsics(), Distortion::None).unwrap();
        assert_eq!(camera.project(&Vec3::new(0.0, 0.0, -1.0)), None);
    }

    #[test]
    fn points_without_a_direction_are_seen_nowhere() {
        for distortion in [
            Distortion::None,
            Distortion::BrownConrady([-0.1, 0.0, 0.0, 0.0, 0.0]),
            Distortion::KannalaBrandt([0.01, 0.0, 0.0, 0.0]),
        ] {
            let camera = Camera::new(intrinsics(), distortion).unwrap();
            assert_eq!(camera.project(&Vec3::zeros()), None, "{distortion:?}");
            assert_eq!(camera.project(&Vec3::new(0.0, 0.0, f64::NAN)), None);
        }
    }

    /// Full Newton steps from the distorted point leave this lens' fold-free disc, though it has an inverse everywhere.
    #[test]
    fn strong_pincushion_that_turns_back_is_inverted() {
        let wide = Intrinsics {
            width_px: 1280,
            height_px: 720,
            fx_px: 704.0,
            fy_px: 704.0,
            cx_px: 640.0,
            cy_px: 360.0,
        };
        let lens = Distortion::BrownConrady([0.5977, -0.19, 0.0025, 0.0, -0.214]);
        let camera = Camera::new(wide, lens).unwrap();
        for pixel in [Pixel::new(0.0, 0.0), Pixel::new(1280.0, 700.0)] {
            let back = camera.project(&camera.ray(&pixel).unwrap()).unwrap();
            assert!((back - pixel).norm() < 1e-9, "{back:?}");
        }
    }
}
