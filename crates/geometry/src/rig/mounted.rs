//! A camera where it sits on the rig, behind its port if it has one.

use crate::port::{Band, Port, WaterRay};
use crate::{Camera, CameraFrame, Cylinder, Pixel, Pose, RigFrame, Side, Vec3};

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
