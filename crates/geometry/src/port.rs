//! Ports: the glass between a camera in its housing and the water.
//!
//! Rays are bent by Snell's law at both faces of the glass (air → glass → water). Indices are against air. The glass is taken to
//! have one index for all bands: faces that are parallel only displace rays, so that the dispersion of 10 mm of acrylic parts red and blue
//! by hundredths of a pixel where that of the water parts them by several. Light reflected to and fro inside the glass (10⁻⁴ of it) is left out.

mod dome;
mod flat;
mod snell;
mod water_index;

pub use dome::DomePort;
pub use flat::FlatPort;
pub use water_index::{SALINITY_PSU, TEMPERATURE_C, sea_water_index};

use crate::{Camera, CameraError, Pixel, Vec3};

/// A band of light, by the wavelength that stands for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Band {
    /// 600 nm.
    Red,
    /// 525 nm: the band that geometry without a band means.
    Green,
    /// 475 nm.
    Blue,
}

impl Band {
    /// All, in the order of every array of bands.
    pub const ALL: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// Its place in an array of bands.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The wavelength that stands for it, nm.
    pub fn wavelength_nm(self) -> f64 {
        [600.0, 525.0, 475.0][self.index()]
    }
}

/// What the glass is shaped like, in the camera's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PortShape {
    /// A plate.
    Flat(FlatPort),
    /// A spherical shell.
    Dome(DomePort),
}

/// The glass before a camera, and the water before the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    shape: PortShape,
    glass_index: f64,
    water_index: [f64; 3],
}

/// A camera's ray where it enters the water, in the camera's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaterRay {
    /// On the outer face, m.
    pub origin_m: Vec3,
    /// Unit direction in the water.
    pub direction: Vec3,
    /// Radiance at the lens over radiance in the water: what passes both faces (Fresnel, unpolarised) over n², since a pencil of
    /// light that leaves the water widens (L/n² stays the same). 1 without a port.
    pub gain: f64,
}

/// The media of one band; air is 1.
struct Indices {
    glass: f64,
    water: f64,
}

impl Indices {
    fn gain(&self, transmittances: [f64; 2]) -> f64 {
        transmittances[0] * transmittances[1] / (self.water * self.water)
    }
}

/// Larger ports than this are a mistake of units, m.
const LARGEST_M: f64 = 2.0;

impl Port {
    /// Index of acrylic (PMMA) in the visible.
    pub const ACRYLIC: f64 = 1.49;

    /// A port, or why it cannot be one.
    ///
    /// # Errors
    /// Lengths that are none, a normal that does not point away from the camera, a pupil outside the dome, indices below that of
    /// air.
    pub fn new(
        shape: PortShape,
        glass_index: f64,
        water_index: [f64; 3],
    ) -> Result<Self, CameraError> {
        let within = |key, found: f64, expected, low: f64, high: f64| {
            if (low..=high).contains(&found) {
                Ok(())
            } else {
                Err(CameraError::Value {
                    key,
                    expected,
                    found,
                })
            }
        };
        let length = |key, found| within(key, found, "0 to 2 m", 0.0, LARGEST_M);
        match &shape {
            PortShape::Flat(flat) => {
                length("port.distance_m", flat.distance_m)?;
                length("port.thickness_m", flat.thickness_m)?;
                let norm = flat.normal.norm();
                within("port.normal", norm, "a unit vector", 1.0 - 1e-9, 1.0 + 1e-9)?;
                let ahead = "a direction ahead of the camera, z > 0";
                within(
                    "port.normal[2]",
                    flat.normal.z,
                    ahead,
                    f64::MIN_POSITIVE,
                    2.0,
                )?;
            }
            PortShape::Dome(dome) => {
                let radius = "more than 0 and at most 2 m";
                within(
                    "port.inner_radius_m",
                    dome.inner_radius_m,
                    radius,
                    f64::MIN_POSITIVE,
                    LARGEST_M,
                )?;
                length("port.thickness_m", dome.thickness_m)?;
                let inside = "a vector shorter than 0.95 inner radii: the camera's centre lies inside the dome";
                let limit_m = 0.95 * dome.inner_radius_m;
                within(
                    "port.centre_offset_m",
                    dome.centre_m.norm(),
                    inside,
                    0.0,
                    limit_m,
                )?;
            }
        }
        within("port.glass_index", glass_index, "1 to 3", 1.0, 3.0)?;
        for index in water_index {
            within("port.water_index", index, "1 to 2", 1.0, 2.0)?;
        }
        Ok(Self {
            shape,
            glass_index,
            water_index,
        })
    }

    /// Its shape.
    pub fn shape(&self) -> &PortShape {
        &self.shape
    }

    /// Index of the glass against air, the same for all bands.
    pub fn glass_index(&self) -> f64 {
        self.glass_index
    }

    /// Index of the water against air per band.
    pub fn water_index(&self) -> [f64; 3] {
        self.water_index
    }

    /// The same port, in the frame of a camera that is elsewhere by so much.
    pub(crate) fn seen_from(&self, aside_m: &Vec3) -> Self {
        let mut port = *self;
        match &mut port.shape {
            PortShape::Flat(flat) => flat.distance_m -= flat.normal.dot(aside_m),
            PortShape::Dome(dome) => dome.centre_m -= aside_m,
        }
        port
    }

    fn indices(&self) -> Indices {
        Indices {
            glass: self.glass_index,
            water: self.water_index[Band::Green.index()],
        }
    }

    /// Whether the bands take different ways.
    pub fn disperses(&self) -> bool {
        let [red, green, blue] = self.water_index;
        red != green || green != blue
    }

    /// The port as another band meets it: its index stands for all.
    #[must_use]
    pub fn in_band(self, band: Band) -> Self {
        Self {
            water_index: [self.water_index[band.index()]; 3],
            ..self
        }
    }

    /// The ray in the water, in green, of a unit direction in air; `None` where the camera does not look at the port.
    pub fn water_ray(&self, air_direction: &Vec3) -> Option<WaterRay> {
        match &self.shape {
            PortShape::Flat(flat) => flat.water_ray(air_direction, &self.indices()),
            PortShape::Dome(dome) => dome.water_ray(air_direction, &self.indices()),
        }
    }

    /// The unit direction in air in which a point in the water, in the camera's frame, is seen; `None` where it is not in the water
    /// or is seen nowhere.
    pub fn air_direction(&self, point_m: &Vec3) -> Option<Vec3> {
        match &self.shape {
            PortShape::Flat(flat) => flat.air_direction(point_m, &self.indices()),
            PortShape::Dome(dome) => dome.air_direction(point_m, &self.indices()),
        }
    }

    /// Refuses a camera that would see past the port. The border of the image is where it shows first.
    pub(crate) fn refuse_blind(&self, camera: &Camera) -> Result<(), CameraError> {
        let i = camera.intrinsics();
        let (width, height) = (f64::from(i.width_px), f64::from(i.height_px));
        for k in 0..=32 {
            let s = f64::from(k) / 32.0;
            for (u_px, v_px) in [
                (s * width, 0.0),
                (s * width, height),
                (0.0, s * height),
                (width, s * height),
            ] {
                let air = camera.ray(&Pixel::new(u_px, v_px));
                if air.is_none_or(|air| self.water_ray(&air).is_none()) {
                    return Err(CameraError::PastPort { u_px, v_px });
                }
            }
        }
        Ok(())
    }
}
