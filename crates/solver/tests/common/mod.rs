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

use core::ops::Range;

use rodsight_solver::{Estimate, Method, PaperParams, Request, Roi, Status, solve};

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

/// What rods are painted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    Plain,
    /// Bands of another colour around the rod, half and half.
    Bands {
        period_m: f64,
        colour: [f64; 3],
    },
    /// Patches darker by up to this share.
    Patches {
        size_m: f64,
        share: f64,
    },
}

/// A ball of one colour: snow, weed, a fish.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub centre_m: Vec3,
    pub radius_m: f64,
    pub colour: [f64; 3],
}

/// A ball as an eye sees it.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub centre_px: Pixel,
    pub radius_px: f64,
    pub range_m: f64,
    pub colour: [f64; 3],
}

/// What to paint.
#[derive(Clone, Debug)]
pub struct Scene {
    pub rig: Rig,
    pub rods: Vec<Cylinder>,
    /// Half of the length that is painted, m; measured from the axis' reference point.
    pub half_length_m: f64,
    /// How the first rod bends, 1/m, towards where the vector points.
    pub curvature_per_m: Vec3,
    pub rod_colour: [f64; 3],
    pub texture: Texture,
    pub background: [f64; 3],
    /// By how much the background brightens across and down the image, as a share.
    pub background_slope: [f64; 2],
    pub balls: Vec<Ball>,
    pub noise_sigma: f64,
    pub seed: u64,
    pub channels: u8,
    pub bits: u8,
    /// Towards far lamps, as long as they are bright: matt rods in linear light, stored as sRGB. None: rods of one flat colour.
    pub lamps: Vec<Vec3>,
    /// Light from everywhere, beside lamps.
    pub ambient: f64,
    /// Light is lost on its way to the camera, and the background takes its place, 1/m.
    pub haze_per_m: f64,
    /// Of the lens, px.
    pub blur_px: f64,
    /// Samples per pixel and axis on the silhouettes.
    pub samples: u32,
    /// What is painted of the left and the right image; the rest is background.
    pub only: [Option<Roi>; 2],
}

/// Where a ray meets a rod.
struct Hit {
    rod: usize,
    range_m: f64,
    colour: [f64; 3],
}

impl Scene {
    pub fn new(rig: &Rig, rods: Vec<Cylinder>) -> Self {
        Self {
            rig: *rig,
            rods,
            half_length_m: 50.0,
            curvature_per_m: Vec3::zeros(),
            rod_colour: ORANGE,
            texture: Texture::Plain,
            background: WATER,
            background_slope: [0.0; 2],
            balls: Vec::new(),
            noise_sigma: 0.0,
            seed: 1,
            channels: 3,
            bits: 8,
            lamps: Vec::new(),
            ambient: 0.0,
            haze_per_m: 0.0,
            blur_px: 0.0,
            samples: 8,
            only: [None; 2],
        }
    }

    pub fn pair(&self) -> StereoPair {
        StereoPair::new(self.rig, self.image(Eye::Left), self.image(Eye::Right))
            .expect("images of the rig's size")
    }

    /// The same as the rig sees it that went there; lamps go with it.
    pub fn moved(&self, rig_from_moved: &Pose<RigFrame, RigFrame>) -> Self {
        let moved_from_rig = rig_from_moved.inverse();
        let rod = |rod: &Cylinder| Cylinder {
            axis: Line3 {
                point_m: moved_from_rig.point(&rod.axis.point_m),
                direction: moved_from_rig.direction(&rod.axis.direction),
            },
            ..*rod
        };
        let ball = |ball: &Ball| Ball {
            centre_m: moved_from_rig.point(&ball.centre_m),
            ..*ball
        };
        Self {
            rods: self.rods.iter().map(rod).collect(),
            balls: self.balls.iter().map(ball).collect(),
            curvature_per_m: moved_from_rig.direction(&self.curvature_per_m),
            ..self.clone()
        }
    }

    /// What a ray of an eye meets first; `None` where it meets no rod within its length.
    fn hit(&self, eye: Eye, u: f64, v: f64) -> Option<Hit> {
        let mounted = self.rig.eye(eye);
        let (origin, direction) = mounted.ray(&Pixel::new(u, v))?;
        let met = self.rods.iter().enumerate().filter_map(|(k, rod)| {
            let (local, near, along_m) = self.met(k == 0, rod, &origin, &direction)?;
            let from_axis = origin + direction * near - local.axis.point_m;
            let along = from_axis.dot(&local.axis.direction);
            let normal = (from_axis - local.axis.direction * along) / local.radius_m;
            (near > 0.0 && along_m.abs() <= self.half_length_m)
                .then_some((near, k, normal, along_m))
        });
        let (range_m, rod, normal, along_m) = met.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let of = |lamp: &Vec3| normal.dot(lamp).max(0.0);
        let light = if self.is_lit() {
            self.ambient + self.lamps.iter().map(of).sum::<f64>()
        } else {
            1.0
        };
        let paint = self.paint(along_m, &normal);
        let left = libm::exp(-self.haze_per_m * range_m);
        let hazed = |k: usize| light * paint[k] * left + (1.0 - left) * self.background[k];
        let colour = [hazed(0), hazed(1), hazed(2)];
        Some(Hit {
            rod,
            range_m,
            colour,
        })
    }

    fn is_lit(&self) -> bool {
        self.ambient > 0.0 || !self.lamps.is_empty()
    }

    /// Light that comes down a ray of an eye, before balls, lens and noise, and from how far, m; `None` outside what is painted.
    pub fn light(&self, eye: Eye, u: f64, v: f64) -> Option<([f64; 3], f64)> {
        let i = *self.rig.eye(eye).camera.intrinsics();
        let painted = self.only[eye as usize].unwrap_or(Roi {
            x_px: 0,
            y_px: 0,
            width_px: i.width_px,
            height_px: i.height_px,
        });
        let within = |at: f64, from: u32, length: u32| {
            at >= f64::from(from) && at < f64::from(from) + f64::from(length)
        };
        if !(within(u, painted.x_px, painted.width_px)
            && within(v, painted.y_px, painted.height_px))
        {
            return None;
        }
        if let Some(hit) = self.hit(eye, u, v) {
            return Some((hit.colour, hit.range_m));
        }
        let x = (u - 0.5) / f64::from(i.width_px) - 0.5;
        let y = (v - 0.5) / f64::from(i.height_px) - 0.5;
        let [a, b] = self.background_slope;
        let slope = (1.0 + a * x + b * y).max(0.0);
        Some((self.background.map(|v| v * slope), f64::INFINITY))
    }

    /// The balls as an eye sees them.
    pub fn discs(&self, eye: Eye) -> Vec<Disc> {
        let mounted = self.rig.eye(eye);
        let to_camera = mounted.rig_from_camera.inverse();
        self.balls
            .iter()
            .filter_map(|ball| {
                let seen = to_camera.point(&ball.centre_m);
                let centre_px = mounted.project(&ball.centre_m).filter(|_| seen.z > 0.05)?;
                Some(Disc {
                    centre_px,
                    radius_px: mounted.camera.intrinsics().fx_px * ball.radius_m / seen.z,
                    range_m: seen.norm(),
                    colour: ball.colour,
                })
            })
            .collect()
    }

    /// What is stored of light before noise and rounding, 0…1; the first `channels` of them.
    pub fn stored(&self, light: [f64; 3]) -> [f64; 3] {
        let colour = if self.is_lit() {
            light.map(encode)
        } else {
            light
        };
        if self.channels == 3 {
            colour
        } else {
            [0.25 * (colour[0] + 2.0 * colour[1] + colour[2]); 3]
        }
    }

    /// Standard deviation of what noise and rounding add to a stored value.
    pub fn stored_sigma(&self) -> f64 {
        let step = if self.bits == 8 {
            1.0 / 255.0
        } else {
            1.0 / 65535.0
        };
        libm::sqrt(self.noise_sigma * self.noise_sigma + step * step / 12.0)
    }

    /// The straight rod that a rod is where a ray meets it, the distance to it, and how far along the rod that is.
    fn met(
        &self,
        bends: bool,
        rod: &Cylinder,
        origin: &Vec3,
        direction: &Vec3,
    ) -> Option<(Cylinder, f64, f64)> {
        let (p, d) = (rod.axis.point_m, rod.axis.direction);
        let along = |near: f64| (origin + direction * near - p).dot(&d);
        let curvature = self.curvature_per_m - d * d.dot(&self.curvature_per_m);
        if !bends || curvature.norm() == 0.0 {
            let (near, _) = rod.intersect(origin, direction)?;
            return Some((*rod, near, along(near)));
        }
        // The tangent where the ray passes nearest, again and again; the arc's parabola.
        let mut s_m = {
            let w = p - origin;
            let cos = d.dot(direction);
            (w.dot(direction) * cos - w.dot(&d)) / (1.0 - cos * cos).max(1e-9)
        };
        let mut found = None;
        for _ in 0..6 {
            let tangent = d + curvature * s_m;
            let local = Cylinder {
                axis: Line3::new(p + d * s_m + curvature * (0.5 * s_m * s_m), &tangent),
                radius_m: rod.radius_m,
            };
            let Some((near, _)) = local.intersect(origin, direction) else {
                // Beside it: nearest to the ray.
                let w = local.axis.point_m - origin;
                let cos = local.axis.direction.dot(direction);
                let more = (w.dot(direction) * cos - w.dot(&local.axis.direction))
                    / (1.0 - cos * cos).max(1e-9);
                s_m += more;
                found = None;
                continue;
            };
            let at = origin + direction * near - local.axis.point_m;
            s_m += at.dot(&local.axis.direction);
            found = Some((local, near, s_m));
        }
        found
    }

    fn paint(&self, along_m: f64, normal: &Vec3) -> [f64; 3] {
        match self.texture {
            Texture::Plain => self.rod_colour,
            Texture::Bands { period_m, colour } => {
                let place = along_m / period_m;
                if place - place.floor() < 0.5 {
                    colour
                } else {
                    self.rod_colour
                }
            }
            Texture::Patches { size_m, share } => {
                // Values on a grid along the rod and around it, smoothly between them.
                let radius_m = self.rods[0].radius_m;
                let d = self.rods[0].axis.direction;
                let e1 = d.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize();
                let angle = libm::atan2(normal.dot(&d.cross(&e1)), normal.dot(&e1));
                let (x, y) = (along_m / size_m, angle * radius_m / size_m);
                let (i, j) = (x.floor(), y.floor());
                let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
                let (a, b) = (smooth(x - i), smooth(y - j));
                let value = |di: f64, dj: f64| {
                    let key = ((i + di) as i64 as u64).wrapping_mul(0x9E37_79B9)
                        ^ ((j + dj) as i64 as u64).wrapping_mul(0x85EB_CA6B);
                    Random::new(self.seed ^ key.wrapping_mul(0xC2B2_AE35)).uniform()
                };
                let low = (1.0 - a) * value(0.0, 0.0) + a * value(1.0, 0.0);
                let high = (1.0 - a) * value(0.0, 1.0) + a * value(1.0, 1.0);
                let left = 1.0 - share * ((1.0 - b) * low + b * high);
                self.rod_colour.map(|v| v * left)
            }
        }
    }

    pub fn image(&self, eye: Eye) -> Image {
        let i = *self.rig.eye(eye).camera.intrinsics();
        let (width, height) = (i.width_px as usize, i.height_px as usize);
        let [columns, rows] = match self.only[eye as usize] {
            None => [0..width, 0..height],
            Some(roi) => [
                roi.x_px as usize..(roi.x_px + roi.width_px) as usize,
                roi.y_px as usize..(roi.y_px + roi.height_px) as usize,
            ],
        };
        let mut light = vec![self.background; width * height];
        if self.background_slope != [0.0; 2] {
            for (at, colour) in light.iter_mut().enumerate() {
                let x = (at % width) as f64 / width as f64 - 0.5;
                let y = (at / width) as f64 / height as f64 - 0.5;
                let [a, b] = self.background_slope;
                *colour = colour.map(|v| v * (1.0 + a * x + b * y).max(0.0));
            }
        }
        // The corners of all pixels first; only pixels whose corners differ are supersampled.
        let across = columns.len() + 1;
        let corners: Vec<Option<usize>> = (rows.start..=rows.end)
            .flat_map(|y| (columns.start..=columns.end).map(move |x| (x, y)))
            .map(|(x, y)| self.hit(eye, x as f64, y as f64).map(|hit| hit.rod))
            .collect();
        let mut range_m = vec![f64::INFINITY; width * height];
        for y in rows.clone() {
            for x in columns.clone() {
                let at = |dx: usize, dy: usize| {
                    corners[(y + dy - rows.start) * across + x + dx - columns.start]
                };
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                let place = y * width + x;
                let behind = light[place];
                let is_whole = four.iter().all(|c| *c == four[0]);
                // Bands end within a pixel.
                let is_plain = !matches!(self.texture, Texture::Bands { .. });
                if is_whole && (is_plain || four[0].is_none()) {
                    if let Some(hit) =
                        four[0].and_then(|_| self.hit(eye, x as f64 + 0.5, y as f64 + 0.5))
                    {
                        light[place] = hit.colour;
                        range_m[place] = hit.range_m;
                    }
                    continue;
                }
                let n = if is_whole { 3 } else { self.samples };
                let step = 1.0 / f64::from(n);
                let mut sum = [0.0; 3];
                for k in 0..n * n {
                    let (a, b) = (f64::from(k % n), f64::from(k / n));
                    let (u, v) = (x as f64 + (a + 0.5) * step, y as f64 + (b + 0.5) * step);
                    let colour = match self.hit(eye, u, v) {
                        Some(hit) => {
                            range_m[place] = range_m[place].min(hit.range_m);
                            hit.colour
                        }
                        None => behind,
                    };
                    for (sum, value) in sum.iter_mut().zip(colour) {
                        *sum += value * step * step;
                    }
                }
                light[place] = sum;
            }
        }
        self.add_balls(eye, &mut light, &range_m, width);
        if self.blur_px > 0.0 {
            blur(&mut light, width, [&columns, &rows], self.blur_px);
        }
        let mut random = Random::new(self.seed ^ if eye == Eye::Left { 0 } else { 0x5555_1234 });
        let most = if self.bits == 8 { 255.0 } else { 65535.0 };
        let mut values: Vec<u16> = Vec::with_capacity(light.len() * self.channels as usize);
        for (at, light) in light.into_iter().enumerate() {
            if !(columns.contains(&(at % width)) && rows.contains(&(at / width))) {
                values.extend(core::iter::repeat_n(0, self.channels.into()));
                continue;
            }
            for value in &self.stored(light)[..self.channels as usize] {
                let noise = if self.noise_sigma > 0.0 {
                    self.noise_sigma * random.normal()
                } else {
                    0.0
                };
                values.push(((value + noise).clamp(0.0, 1.0) * most + 0.5) as u16);
            }
        }
        let samples = if self.bits == 8 {
            Samples::U8(values.iter().map(|v| *v as u8).collect())
        } else {
            Samples::U16(values)
        };
        Image::new(i.width_px, i.height_px, self.channels, samples)
            .expect("as many samples as pixels")
    }

    /// Balls before what is farther, their borders a pixel wide.
    fn add_balls(&self, eye: Eye, light: &mut [[f64; 3]], range_m: &[f64], width: usize) {
        let height = light.len() / width;
        for disc in self.discs(eye) {
            let at = disc.centre_px;
            let reach = disc.radius_px + 1.0;
            let clip = |v: f64, most: usize| v.clamp(0.0, most as f64) as usize;
            for y in clip((at.y - reach).floor(), height)..clip((at.y + reach).ceil(), height) {
                for x in clip((at.x - reach).floor(), width)..clip((at.x + reach).ceil(), width) {
                    let off = libm::hypot(x as f64 + 0.5 - at.x, y as f64 + 0.5 - at.y);
                    let share = (disc.radius_px - off + 0.5).clamp(0.0, 1.0);
                    let place = y * width + x;
                    if share > 0.0 && range_m[place] > disc.range_m {
                        for (value, ball) in light[place].iter_mut().zip(disc.colour) {
                            *value += share * (ball - *value);
                        }
                    }
                }
            }
        }
    }
}

/// Blurs the pixels of some columns and rows by a Gaussian; what is beyond the image is as at its border.
fn blur(light: &mut [[f64; 3]], width: usize, only: [&Range<usize>; 2], sigma_px: f64) {
    let half = (4.0 * sigma_px).ceil() as usize;
    let mut kernel: Vec<f64> = (0..=2 * half)
        .map(|k| {
            let x = (k as f64 - half as f64) / sigma_px;
            libm::exp(-0.5 * x * x)
        })
        .collect();
    let sum: f64 = kernel.iter().sum();
    for weight in &mut kernel {
        *weight /= sum;
    }
    let height = light.len() / width;
    let [columns, rows] = only;
    // Across first, of all rows that blurring down will ask for.
    let reach = rows.start.saturating_sub(half)..(rows.end + half).min(height);
    let mut across = Vec::with_capacity(reach.len() * columns.len());
    for y in reach.clone() {
        let row = &light[y * width..(y + 1) * width];
        across.extend(
            columns
                .clone()
                .map(|x| weighed(&kernel, x, width, |x| row[x])),
        );
    }
    for y in rows.clone() {
        for (column, x) in columns.clone().enumerate() {
            light[y * width + x] = weighed(&kernel, y, height, |y| {
                across[(y - reach.start) * columns.len() + column]
            });
        }
    }
}

/// The mean of the values around a place, by the weights of a kernel.
fn weighed(
    kernel: &[f64],
    place: usize,
    along: usize,
    value: impl Fn(usize) -> [f64; 3],
) -> [f64; 3] {
    let half = kernel.len() / 2;
    let mut sum = [0.0; 3];
    for (k, weight) in kernel.iter().enumerate() {
        let there = (place + k).saturating_sub(half).min(along - 1);
        for (sum, value) in sum.iter_mut().zip(value(there)) {
            *sum += weight * value;
        }
    }
    sum
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
