//! A camera where it sits on the rig, behind its port if it has one.

use crate::port::{Band, Port, WaterRay};
use crate::{Camera, CameraError, CameraFrame, Cylinder, Mat3, Pixel, Pose, RigFrame, Side, Vec3};

/// A camera and where it sits on the rig. Without a port it is an ideal camera in the water: its rays are those of the water. With
/// one, `camera` is the camera in air, and there is no single centre of projection in the water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountedCamera {
    /// The camera.
    pub camera: Camera,
    /// Its pose: `x_rig = R x_camera + t`.
    pub rig_from_camera: Pose<RigFrame, CameraFrame>,
    /// The glass before it.
    pub port: Option<Port>,
}

/// How a point in the water is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where in the image (possibly outside it).
    pub pixel: Pixel,
    /// Where the straight line of sight to the point begins, in the rig frame, m: the camera's centre, or the port's outer face.
    pub from_m: Vec3,
}

impl MountedCamera {
    /// A camera without a port.
    pub fn new(camera: Camera, rig_from_camera: Pose<RigFrame, CameraFrame>) -> Self {
        Self {
            camera,
            rig_from_camera,
            port: None,
        }
    }

    /// Whether straight rods are straight lines in the image.
    pub fn is_pinhole(&self) -> bool {
        self.port.is_none() && self.camera.is_pinhole()
    }

    /// Whether the bands take different ways to a pixel.
    pub fn disperses(&self) -> bool {
        self.port.is_some_and(|port| port.disperses())
    }

    /// The camera as another band of light sees through its port; without a port, the same. All else here is of the green band.
    #[must_use]
    pub fn in_band(self, band: Band) -> Self {
        Self {
            port: self.port.map(|port| port.in_band(band)),
            ..self
        }
    }

    /// How far off in air a point on the optical axis, at a depth in the water, seems to be: where its pencil of light would come
    /// from, m. Of the two directions across the axis, which a tilted port focuses apart, the mean of 1/m. Without a port the depth
    /// itself; `None` for one that is not in the water.
    pub fn apparent_depth_m(&self, depth_m: f64) -> Option<f64> {
        /// As small as pencils are, and large enough for its square to keep half the digits.
        const ASIDE_M: f64 = 1e-4;
        let Some(port) = &self.port else {
            return (depth_m > 0.0).then_some(depth_m);
        };
        let axis = port.water_ray(&Vec3::z())?;
        let along_m = (depth_m - axis.origin_m.z) / axis.direction.z;
        let point_m = axis.origin_m + axis.direction * along_m;
        let per_m = [Vec3::x(), Vec3::y()].map(|across| {
            let tangent = |aside_m: Vec3| {
                let air = port
                    .seen_from(&aside_m)
                    .air_direction(&(point_m - aside_m))?;
                Some(air.dot(&across) / air.z)
            };
            Some((tangent(-across * ASIDE_M)? - tangent(across * ASIDE_M)?) / (2.0 * ASIDE_M))
        });
        let nearness_per_m = 0.5 * (per_m[0]? + per_m[1]?);
        (along_m > 0.0 && nearness_per_m > 0.0).then(|| 1.0 / nearness_per_m)
    }

    /// The camera as a point of its aperture sees, aside of its centre: what is in focus, at a depth on the optical axis, it sees where
    /// the centre does. The port stays where it is on the rig.
    ///
    /// # Errors
    /// A plane in focus that is not in the water, a lens that sees sideways, a point that sees past the port.
    pub fn through(&self, aside_m: &Pixel, focus_m: f64) -> Result<Self, CameraError> {
        let in_air_m = self.apparent_depth_m(focus_m).ok_or(CameraError::Value {
            key: "focus_m",
            expected: "a depth in the water before the port",
            found: focus_m,
        })?;
        let aside = Pose::<CameraFrame, CameraFrame>::new(Mat3::identity(), aside_m.push(0.0));
        let mounted = Self {
            camera: self.camera.with_rays_shifted(&(aside_m / in_air_m))?,
            rig_from_camera: self.rig_from_camera * aside,
            port: self.port.map(|port| port.seen_from(&aside.origin_m())),
        };
        if let Some(port) = &mounted.port {
            port.refuse_blind(&mounted.camera)?;
        }
        Ok(mounted)
    }

    /// The ray in the water, in the rig frame, that is seen at a pixel.
    pub fn water_ray(&self, pixel: &Pixel) -> Option<WaterRay> {
        let in_air = self.camera.ray(pixel)?;
        let in_camera = match &self.port {
            None => {
                return Some(WaterRay {
                    origin_m: self.rig_from_camera.origin_m(),
                    direction: self.rig_from_camera.direction(&in_air),
                    gain: 1.0,
                });
            }
            Some(port) => port.water_ray(&in_air)?,
        };
        Some(WaterRay {
            origin_m: self.rig_from_camera.point(&in_camera.origin_m),
            direction: self.rig_from_camera.direction(&in_camera.direction),
            gain: in_camera.gain,
        })
    }

    /// Origin (m) and unit direction, in the rig frame, of the ray in the water that is seen at a pixel.
    pub fn ray(&self, pixel: &Pixel) -> Option<(Vec3, Vec3)> {
        let ray = self.water_ray(pixel)?;
        Some((ray.origin_m, ray.direction))
    }

    /// The direction in the camera's frame, of any length, in which the lens sees a point of the rig frame.
    fn towards(&self, point_in_rig_m: &Vec3) -> Option<Vec3> {
        let in_camera_m = self.rig_from_camera.inverse().point(point_in_rig_m);
        match &self.port {
            None => Some(in_camera_m),
            Some(port) => port.air_direction(&in_camera_m),
        }
    }

    /// The pixel at which a point of the rig frame is seen.
    pub fn project(&self, point_in_rig_m: &Vec3) -> Option<Pixel> {
        self.camera.project(&self.towards(point_in_rig_m)?)
    }

    /// The pixel at which a point of the rig frame is seen, and where the straight line of sight to it begins.
    pub fn sight(&self, point_in_rig_m: &Vec3) -> Option<Sight> {
        let in_air = self.towards(point_in_rig_m)?;
        let from_m = match &self.port {
            None => self.rig_from_camera.origin_m(),
            Some(port) => self
                .rig_from_camera
                .point(&port.water_ray(&in_air)?.origin_m),
        };
        Some(Sight {
            pixel: self.camera.project(&in_air)?,
            from_m,
        })
    }

    /// The point of a cylinder's limb in its cross-section through `axis.point_m`, in the rig frame, m: where the ray that is seen
    /// touches the surface, `g = (p − o)·m̂ − s r = 0`. Behind a port the ray's origin o depends on the point: the tangent plane is
    /// taken from it and again from the next, each time nearer by the port's size over the distance. `None` from inside the
    /// cylinder and where it is not seen.
    pub fn limb_point_m(&self, cylinder: &Cylinder, side: Side) -> Option<Vec3> {
        let touched_from = |from_m: &Vec3| {
            let planes = cylinder.tangent_planes(from_m)?;
            let normal = match side {
                Side::Plus => planes.plus,
                Side::Minus => planes.minus,
            };
            Some(cylinder.axis.point_m - normal * (side.sign() * cylinder.radius_m))
        };
        let mut limb_m = touched_from(&self.rig_from_camera.origin_m())?;
        if self.port.is_none() {
            return Some(limb_m);
        }
        for _ in 0..64 {
            let next_m = touched_from(&self.sight(&limb_m)?.from_m)?;
            let moved_m = (next_m - limb_m).norm();
            limb_m = next_m;
            if moved_m <= 1e-13 * (1.0 + limb_m.norm()) {
                return Some(limb_m);
            }
        }
        None
    }
}
