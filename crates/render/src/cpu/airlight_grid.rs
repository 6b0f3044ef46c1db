//! The light that the water scatters into the rays of one eye, tabulated.
//!
//! Without the rods' shadows it is smooth over the image and along the rays: a table at a corner every so many pixels and at a few
//! distances tells it everywhere. Shadows are taken off where they are. A sum over each ray took half the time of an image.
//!
//! Along a ray of length t the table has even steps of s = t/(t + h), h the distance of the lamps: fine where light is gained, and
//! s = 1 is infinity. Between knots L(s) is the cubic with the knots' values and slopes, between corners it is bilinear.

use rayon::prelude::*;
use rodsight_geometry::{MountedCamera, Pixel};
use rodsight_optics::Bands;

use super::solid::Ray;
use super::world::World;
use crate::noise::Philox;

/// Corner spacings that are tried, px.
const SPACINGS_PX: [u32; 3] = [32, 16, 8];
/// Steps of s from the camera to infinity.
pub(crate) const STEPS: usize = 32;
/// Midpoints of a step: 128 on the whole ray.
const STEP_POINTS: u32 = 4;
/// Random places where the table is held against the integral itself.
const PROBES: u32 = 256;
const PROBE_POINTS: u32 = 256;
/// Largest error of the table, relative to the airlight there and, where there is hardly any, to a twentieth of the whole ray's.
const TOLERANCE: f64 = 2e-3;
const FLOOR: f64 = 0.05;

/// Airlight and its slope dL/ds at a knot.
type Knot = [Bands; 2];

/// The unshadowed airlight of all lamps, W m⁻² sr⁻¹.
#[derive(Debug)]
pub(crate) struct AirlightGrid {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Corners per pixel.
    pub(crate) scale: [f64; 2],
    pub(crate) half_way_m: f64,
    /// Shape `[rows, columns, STEPS + 1]`; empty where no table is good enough, and each ray is summed.
    pub(crate) knots: Vec<Knot>,
}

impl AirlightGrid {
    pub(crate) fn new(world: &World<'_>, mounted: &MountedCamera) -> Self {
        let camera_m = mounted.rig_from_camera.origin_m();
        let distances = world
            .lamps
            .iter()
            .map(|l| (l.lamp.position_m - camera_m).norm());
        let half_way_m = distances.sum::<f64>() / world.lamps.len().max(1) as f64;
        let intrinsics = mounted.camera.intrinsics();
        let mut grid = Self {
            columns: 0,
            rows: 0,
            scale: [0.0; 2],
            half_way_m: half_way_m.clamp(0.05, 50.0),
            knots: Vec::new(),
        };
        if !world.has_airlight() {
            return grid;
        }
        for spacing_px in SPACINGS_PX {
            let cells = |size_px: u32| size_px.div_ceil(spacing_px);
            let (across, down) = (cells(intrinsics.width_px), cells(intrinsics.height_px));
            grid.columns = across as usize + 1;
            grid.rows = down as usize + 1;
            grid.scale = [
                f64::from(across) / f64::from(intrinsics.width_px),
                f64::from(down) / f64::from(intrinsics.height_px),
            ];
            grid.knots = grid.tabulate(world, mounted);
            if grid.is_good(world, mounted) {
                return grid;
            }
        }
        grid.knots = Vec::new();
        grid
    }

    /// The airlight of a ray without shadows, of length `distance_m` (which may be infinite).
    pub(super) fn at(&self, world: &World<'_>, ray: &Ray, pixel: &Pixel, distance_m: f64) -> Bands {
        if !world.has_airlight() {
            return [0.0; 3];
        }
        if self.knots.is_empty() {
            let points = world.scene.sampling.airlight_points;
            return world.unshadowed(ray, 0.0, distance_m, points);
        }
        let cell = |at_px: f64, scale: f64, corners: usize| {
            let x = (at_px * scale).max(0.0);
            let index = (x as usize).min(corners - 2);
            (index, x - index as f64)
        };
        let (column, right) = cell(pixel.x, self.scale[0], self.columns);
        let (row, down) = cell(pixel.y, self.scale[1], self.rows);
        let s = if distance_m.is_finite() {
            distance_m / (distance_m + self.half_way_m)
        } else {
            1.0
        } * STEPS as f64;
        let step = (s as usize).min(STEPS - 1);
        let hermite = Hermite::new(s - step as f64);
        let corner = |column: usize, row: usize| {
            let first = (row * self.columns + column) * (STEPS + 1) + step;
            hermite.between(&self.knots[first], &self.knots[first + 1])
        };
        let [a, b] = [corner(column, row), corner(column + 1, row)];
        let [c, d] = [corner(column, row + 1), corner(column + 1, row + 1)];
        core::array::from_fn(|k| {
            let above = a[k] + right * (b[k] - a[k]);
            let below = c[k] + right * (d[k] - c[k]);
            above + down * (below - above)
        })
    }

    fn tabulate(&self, world: &World<'_>, mounted: &MountedCamera) -> Vec<Knot> {
        let corners = (0..self.rows * self.columns).into_par_iter();
        corners
            .flat_map_iter(|corner| {
                let (row, column) = (corner / self.columns, corner % self.columns);
                let pixel = Pixel::new(column as f64 / self.scale[0], row as f64 / self.scale[1]);
                ray_at(mounted, &pixel)
                    .map_or([[[0.0; 3]; 2]; STEPS + 1], |ray| self.along(world, &ray))
            })
            .collect()
    }

    fn along(&self, world: &World<'_>, ray: &Ray) -> [Knot; STEPS + 1] {
        let mut sum = [0.0; 3];
        core::array::from_fn(|knot| {
            let [before_m, here_m] = [knot.max(1) - 1, knot].map(|knot| self.distance_m(knot));
            if knot > 0 {
                let gained = world.unshadowed(ray, before_m, here_m, STEP_POINTS);
                sum = core::array::from_fn(|k| sum[k] + gained[k]);
            }
            // dt/ds = (t + h)²/h; at infinity nothing is gained any more.
            let stretch = (here_m + self.half_way_m) * (here_m + self.half_way_m) / self.half_way_m;
            let slope = if knot == STEPS {
                [0.0; 3]
            } else {
                world
                    .unshadowed_per_m(ray, here_m)
                    .map(|v| v * stretch / STEPS as f64)
            };
            [sum, slope]
        })
    }

    fn distance_m(&self, knot: usize) -> f64 {
        self.half_way_m * knot as f64 / (STEPS - knot) as f64
    }

    /// Whether the table agrees with the integral wherever it is asked.
    fn is_good(&self, world: &World<'_>, mounted: &MountedCamera) -> bool {
        let intrinsics = mounted.camera.intrinsics();
        (0..PROBES).into_par_iter().all(|probe| {
            let [u, v, s, _] = Philox::new(0).uniforms([probe, 0, 0, 0]);
            let pixel = Pixel::new(
                u * f64::from(intrinsics.width_px),
                v * f64::from(intrinsics.height_px),
            );
            let Some(ray) = ray_at(mounted, &pixel) else {
                return true;
            };
            let distance_m = self.half_way_m * s / (1.0 - s);
            let table = self.at(world, &ray, &pixel, distance_m);
            let whole = self.at(world, &ray, &pixel, f64::INFINITY);
            let exact = world.unshadowed(&ray, 0.0, distance_m, PROBE_POINTS);
            (0..3)
                .all(|k| (table[k] - exact[k]).abs() <= TOLERANCE * exact[k].max(FLOOR * whole[k]))
        })
    }
}

fn ray_at(mounted: &MountedCamera, pixel: &Pixel) -> Option<Ray> {
    let (origin_m, direction) = mounted.ray(pixel)?;
    Some(Ray {
        origin_m,
        direction,
    })
}

/// Weights of the cubic through two values and their slopes, x in [0, 1].
pub(crate) struct Hermite(pub(crate) [f64; 4]);

impl Hermite {
    pub(crate) fn new(x: f64) -> Self {
        let rest = 1.0 - x;
        Self([
            (1.0 + 2.0 * x) * rest * rest,
            x * rest * rest,
            x * x * (3.0 - 2.0 * x),
            -x * x * rest,
        ])
    }

    #[inline]
    fn between(&self, from: &Knot, to: &Knot) -> Bands {
        let [value, slope, value_to, slope_to] = self.0;
        core::array::from_fn(|k| {
            value * from[0][k] + slope * from[1][k] + value_to * to[0][k] + slope_to * to[1][k]
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rodsight_geometry::Eye;
    use rodsight_scene::Scene;

    use super::*;

    fn scene(name: &str) -> Scene {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        Scene::load(&folder.join(name)).unwrap()
    }

    /// The coarsest table does for scenes as they are shipped, at places that it was not held against when it was made.
    #[test]
    fn table_agrees_with_the_integral() {
        for name in ["paper.toml", "harbour.toml", "pipe_over_sand.toml"] {
            let scene = scene(name);
            let world = World::new(&scene);
            for eye in Eye::BOTH {
                let mounted = scene.rig.eye(eye);
                let grid = AirlightGrid::new(&world, mounted);
                assert_eq!(grid.columns, 61, "{name}: 1920 px in steps of 32");
                for i in 0..2000 {
                    let [u, v, s, _] = Philox::new(77).uniforms([i, 0, 0, 0]);
                    let pixel = Pixel::new(u * 1920.0, v * 1080.0);
                    let ray = ray_at(mounted, &pixel).unwrap();
                    let distance_m = if i % 10 == 0 { f64::INFINITY } else { 8.0 * s };
                    let table = grid.at(&world, &ray, &pixel, distance_m);
                    let exact = world.unshadowed(&ray, 0.0, distance_m, 512);
                    let whole = world.unshadowed(&ray, 0.0, f64::INFINITY, 512);
                    for k in 0..3 {
                        let off = (table[k] - exact[k]).abs() / exact[k].max(FLOOR * whole[k]);
                        assert!(
                            off < 1.5 * TOLERANCE,
                            "{name} {eye:?} {i} band {k}: {off:e}"
                        );
                    }
                }
            }
        }
    }

    /// A hard-edged beam across the image is no business of a table.
    #[test]
    fn a_table_that_is_wrong_is_not_used() {
        let mut scene = scene("harbour.toml");
        for lamp in &mut scene.lamps {
            lamp.inner_half_angle_rad = 0.02;
            lamp.outer_half_angle_rad = 0.02;
        }
        let world = World::new(&scene);
        let grid = AirlightGrid::new(&world, scene.rig.eye(Eye::Left));
        assert!(grid.knots.is_empty());
    }
}
