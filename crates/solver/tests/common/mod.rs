//! A renderer of its own, so that the solver is not tested against the code it will be used with: the projection of a long
//! cylinder is the wedge between its two tangent planes, painted by supersampling.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each test file uses a part"
)]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the files`"
)]

use rodsight_solver::{Estimate, Method, PaperParams, Request, Status, solve};

use rodsight_geometry::{
    Camera, CameraFrame, Cylinder, Distortion, Eye, Image, Intrinsics, Line3, Mat3, MountedCamera,
    Pixel, Pose, Rig, RigFrame, Samples, StereoPair, Vec3,
};

/// Colours in 0…1.
pub const ORANGE: [f64; 3] = [0.85, 0.42, 0.08];
pub const WATER: [f64; 3] = [0.10, 0.32, 0.45];

/// The paper's rig: 1920×1080, 63° across, 1 m baseline, parallel axes.
pub fn rig() -> Rig {
    rig_of(1920, 1080, 1566.5776, Distortion::None)
}

/// The same field of view with fewer pixels.
pub fn small_rig() -> Rig {
    rig_of(640, 360, 1566.5776 / 3.0, Distortion::None)
}

pub fn rig_of(width_px: u32, height_px: u32, focal_px: f64, distortion: Distortion) -> Rig {
    let intrinsics = Intrinsics {
        width_px,
        height_px,
        fx_px: focal_px,
        fy_px: focal_px,
        cx_px: 0.5 * f64::from(width_px),
        cy_px: 0.5 * f64::from(height_px),
    };
    let camera = Camera::new(intrinsics, distortion).expect("a camera");
    let mounted = |y_m: f64| {
        let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let pose = Pose::<RigFrame, CameraFrame>::new(axes, Vec3::new(0.0, y_m, -1.0));
        MountedCamera::new(camera, pose)
    };
    Rig {
        left: mounted(-0.5),
        right: mounted(0.5),
    }
}

/// A rod through a point of the rig frame, given relative to the midpoint of the cameras (forward, starboard, down).
pub fn rod(at: [f64; 3], direction: [f64; 3], radius_m: f64) -> Cylinder {
    Cylinder {
        axis: Line3::new(
            Vec3::from(at) + Vec3::new(0.0, 0.0, -1.0),
            &Vec3::from(direction),
        ),
        radius_m,
    }
}

/// What to paint.
#[derive(Clone, Debug)]
pub struct Scene {
    pub rig: Rig,
    pub rods: Vec<Cylinder>,
    /// Half of the length that is painted, m; measured from the axis' reference point.
    pub half_length_m: f64,
    pub rod_colour: [f64; 3],
    pub background: [f64; 3],
    pub noise_sigma: f64,
    pub seed: u64,
    pub channels: u8,
    pub bits: u8,
    /// Unit vector towards a far lamp: matt rods in linear light, stored as sRGB. Absent: rods of one flat colour.
    pub lamp: Option<Vec3>,
    /// Another, as bright.
    pub second_lamp: Option<Vec3>,
    /// Samples per pixel and axis on the silhouettes.
    pub samples: u32,
}

impl Scene {
    pub fn new(rig: &Rig, rods: Vec<Cylinder>) -> Self {
        Self {
            rig: *rig,
            rods,
            half_length_m: 50.0,
            rod_colour: ORANGE,
            background: WATER,
            noise_sigma: 0.0,
            seed: 1,
            channels: 3,
            bits: 8,
            lamp: None,
            second_lamp: None,
            samples: 8,
        }
    }

    pub fn pair(&self) -> StereoPair {
        StereoPair::new(self.rig, self.image(Eye::Left), self.image(Eye::Right))
            .expect("images of the rig's size")
    }

    /// How bright the rod is that a ray of an eye meets first, in [0, 1]; `None` where it meets none within its length.
    fn hit(&self, eye: Eye, u: f64, v: f64) -> Option<f64> {
        let mounted = self.rig.eye(eye);
        let (origin, direction) = mounted.ray(&Pixel::new(u, v))?;
        let met = self.rods.iter().filter_map(|rod| {
            let (near, _) = rod.intersect(&origin, &direction)?;
            let from_axis = origin + direction * near - rod.axis.point_m;
            let along = from_axis.dot(&rod.axis.direction);
            let normal = (from_axis - rod.axis.direction * along) / rod.radius_m;
            let of = |lamp: &Vec3| normal.dot(lamp).max(0.0);
            let both = self.lamp.iter().chain(&self.second_lamp).map(of);
            let light = self.lamp.map_or(1.0, |_| both.sum());
            (near > 0.0 && along.abs() <= self.half_length_m).then_some((near, light))
        });
        met.min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, light)| light)
    }

    pub fn image(&self, eye: Eye) -> Image {
        let i = *self.rig.eye(eye).camera.intrinsics();
        let (width, height) = (i.width_px as usize, i.height_px as usize);
        // The corners of all pixels first; only pixels whose corners differ are supersampled.
        let corners: Vec<bool> = (0..=height)
            .flat_map(|y| (0..=width).map(move |x| (x, y)))
            .map(|(x, y)| self.hit(eye, x as f64, y as f64).is_some())
            .collect();
        // Share of a pixel that is rod, and the light of that share.
        let mut coverage = vec![(0.0, 0.0); width * height];
        for y in 0..height {
            for x in 0..width {
                let at = |dx: usize, dy: usize| corners[(y + dy) * (width + 1) + x + dx];
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                coverage[y * width + x] = if four.iter().all(|c| *c == four[0]) {
                    match self.hit(eye, x as f64 + 0.5, y as f64 + 0.5) {
                        Some(light) if four[0] => (1.0, light),
                        _ => (f64::from(u8::from(four[0])), 0.0),
                    }
                } else {
                    let n = self.samples;
                    let step = 1.0 / f64::from(n);
                    let met = (0..n * n).filter_map(|k| {
                        let (a, b) = (f64::from(k % n), f64::from(k / n));
                        let (u, v) = (x as f64 + (a + 0.5) * step, y as f64 + (b + 0.5) * step);
                        self.hit(eye, u, v)
                    });
                    let (count, light) = met.fold((0.0, 0.0), |(n, sum), l| (n + 1.0, sum + l));
                    let all = f64::from(n * n);
                    (count / all, light / all)
                };
            }
        }
        let mut random = Random::new(self.seed ^ if eye == Eye::Left { 0 } else { 0x5555_1234 });
        let mut values = Vec::with_capacity(coverage.len() * self.channels as usize);
        for (c, light) in coverage {
            let colour: [f64; 3] = core::array::from_fn(|k| {
                let value = light * self.rod_colour[k] + (1.0 - c) * self.background[k];
                self.lamp.map_or(value, |_| encode(value))
            });
            let grey = 0.25 * (colour[0] + 2.0 * colour[1] + colour[2]);
            let painted: &[f64] = if self.channels == 3 { &colour } else { &[grey] };
            for value in painted {
                let noise = if self.noise_sigma > 0.0 {
                    self.noise_sigma * random.normal()
                } else {
                    0.0
                };
                values.push((value + noise).clamp(0.0, 1.0));
            }
        }
        let samples = if self.bits == 8 {
            Samples::U8(values.iter().map(|v| (v * 255.0 + 0.5) as u8).collect())
        } else {
            Samples::U16(values.iter().map(|v| (v * 65535.0 + 0.5) as u16).collect())
        };
        Image::new(i.width_px, i.height_px, self.channels, samples)
            .expect("as many samples as pixels")
    }
}

/// Linear light to sRGB (IEC 61966-2-1).
fn encode(light: f64) -> f64 {
    if light <= 0.0031308 {
        12.92 * light
    } else {
        1.055 * libm::pow(light, 1.0 / 2.4) - 0.055
    }
}

/// `SplitMix64` and a sum of twelve uniforms.
#[derive(Debug)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 9007199254740992.0
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A pick at the image of a point on the axis.
pub fn pick_at(rig: &Rig, eye: Eye, point_m: &Vec3) -> rodsight_solver::Pick {
    rodsight_solver::Pick {
        pixel: rig
            .eye(eye)
            .project(point_m)
            .expect("in front of the camera"),
        eye,
    }
}

/// The rod of the small scene.
pub fn truth() -> Cylinder {
    rod([1.5, 0.05, 0.0], [0.3, 0.3, 1.0], 0.05)
}

/// One rod before the small rig.
pub fn scene() -> Scene {
    Scene::new(&small_rig(), vec![truth()])
}

pub fn bisector(request: &Request<'_>) -> Estimate {
    solve(request, Method::PaperBisector, &PaperParams::default()).unwrap()
}

/// Distance of the estimated axis to the true reference point, m.
pub fn offset_m(estimate: &Estimate, truth: &Cylinder) -> f64 {
    let axis = estimate.axis.unwrap();
    Line3::new(
        axis.point_m.unwrap().into(),
        &axis.direction.unwrap().into(),
    )
    .distance_m(&truth.axis.point_m)
}

pub fn refused(estimate: &Estimate, code: &str) {
    assert_eq!(estimate.status, Status::Refused, "{estimate:?}");
    assert_eq!(
        estimate.observability.refusal.as_deref(),
        Some(code),
        "{:?}",
        estimate.reason
    );
    assert!(estimate.axis.is_none_or(|a| a.point_m.is_none()) || code == "pick_off_rod");
    assert!(estimate.grasp.is_none());
}
