//! Where the particles are.

use rayon::prelude::*;
use rodsight_geometry::{Eye, MountedCamera, Pixel, Vec3};
use rodsight_scene::{Scene, Snow};

use crate::noise::Philox;

/// Particles in a cell, on average.
const PER_CELL: f64 = 8.0;
/// Keeps the words of the snow apart from those of noise and texture.
const KEY: u64 = 0x736e_6f77_0000_0000;
/// Counters of particles; those below count them.
const PARTICLES: u32 = 1 << 31;

/// A sphere in the rig's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Particle {
    pub(super) centre_m: Vec3,
    pub(super) radius_m: f64,
}

/// A cube of space.
type Cell = [i32; 3];

/// Cells from and to, both included.
type Block = [Cell; 2];

/// What an image may show: a cone.
struct View {
    apex_m: Vec3,
    axis: Vec3,
    sin: f64,
    cos: f64,
}

impl View {
    fn new(mounted: &MountedCamera) -> Self {
        const STEPS: u32 = 16;
        let axis = mounted.rig_from_camera.direction(&Vec3::z());
        let i = mounted.camera.intrinsics();
        let place = |step: u32, size: u32| f64::from(step) / f64::from(STEPS) * f64::from(size);
        let border = (0..=STEPS).flat_map(|step| {
            let (u, v) = (place(step, i.width_px), place(step, i.height_px));
            let (right, bottom) = (f64::from(i.width_px), f64::from(i.height_px));
            [[u, 0.0], [u, bottom], [0.0, v], [right, v]]
        });
        let cos = border
            .filter_map(|at| Some(mounted.ray(&Pixel::from(at))?.1.dot(&axis)))
            .fold(1.0, f64::min);
        Self {
            apex_m: mounted.rig_from_camera.origin_m(),
            axis,
            sin: (1.0 - cos * cos).max(0.0).sqrt(),
            cos,
        }
    }

    /// Whether a sphere may reach into it.
    fn may_see(&self, centre_m: &Vec3, radius_m: f64) -> bool {
        let to_centre = centre_m - self.apex_m;
        let along = to_centre.dot(&self.axis);
        let across = (to_centre - self.axis * along).norm();
        // A view of more than half of all directions is not narrowed down.
        self.cos <= 0.0 || across * self.cos - along * self.sin <= radius_m
    }
}

/// What `see` makes of every particle that may be in view, in the order of their cells.
pub(super) fn in_view<T: Send>(
    snow: &Snow,
    scene: &Scene,
    mounted: &MountedCamera,
    see: impl Fn(Particle) -> Option<T> + Sync,
) -> Vec<T> {
    let strewn = Strewn::new(snow, scene);
    let view = View::new(mounted);
    // A particle may lie beside the view and reach into it, by its radius, its blur and a port's size.
    let blur_m = scene.lens.aperture.map_or(0.0, |aperture| {
        aperture.diameter_m() * (1.0 + snow.range_m[1] / aperture.focus_m)
    });
    let port_m = if mounted.port.is_some() { 0.3 } else { 0.0 };
    let margin_m = 0.5 * 3.0_f64.sqrt() * strewn.side_m + snow.diameter_m[1] + blur_m + port_m;
    let [left, right] = strewn.eyes_m.map(|eye_m| strewn.block(&eye_m));
    let cells = columns(left).chain(columns(right)).collect::<Vec<_>>();
    let from_left = columns(left).count();
    cells
        .into_par_iter()
        .enumerate()
        .flat_map_iter(|(index, (column, steps))| {
            let (strewn, view, see) = (&strewn, &view, &see);
            let already = move |cell: &Cell| index >= from_left && contains(&left, cell);
            let cells = steps.map(move |z| [column[0], column[1], z]);
            cells
                .filter(move |cell| !already(cell))
                .filter(move |cell| view.may_see(&strewn.middle_m(cell), margin_m))
                .flat_map(move |cell| strewn.particles(cell))
                .filter_map(see)
        })
        .collect()
}

fn contains([from, to]: &Block, cell: &Cell) -> bool {
    (0..3).all(|axis| (from[axis]..=to[axis]).contains(&cell[axis]))
}

/// Columns of cells: x and y of each, and the range of z.
fn columns([from, to]: Block) -> impl Iterator<Item = ([i32; 2], core::ops::RangeInclusive<i32>)> {
    (from[0]..=to[0]).flat_map(move |x| (from[1]..=to[1]).map(move |y| ([x, y], from[2]..=to[2])))
}

/// The snow of a scene.
struct Strewn<'a> {
    snow: &'a Snow,
    eyes_m: [Vec3; 2],
    random: Philox,
    side_m: f64,
}

impl<'a> Strewn<'a> {
    fn new(snow: &'a Snow, scene: &Scene) -> Self {
        Self {
            snow,
            eyes_m: Eye::BOTH.map(|eye| scene.rig.eye(eye).rig_from_camera.origin_m()),
            random: Philox::new(snow.seed.unwrap_or(scene.seed) ^ KEY),
            side_m: libm::cbrt(PER_CELL / snow.number_per_m3),
        }
    }

    /// The cells around an eye that hold what it sees.
    fn block(&self, eye_m: &Vec3) -> Block {
        [-1.0, 1.0].map(|side| {
            let corner_m = eye_m.add_scalar(side * self.snow.range_m[1]);
            corner_m
                .map(|at| libm::floor(at / self.side_m) as i32)
                .into()
        })
    }

    fn middle_m(&self, cell: &Cell) -> Vec3 {
        Vec3::from(cell.map(|at| (f64::from(at) + 0.5) * self.side_m))
    }

    fn particles(&self, cell: Cell) -> impl Iterator<Item = Particle> {
        let [x, y, z] = cell.map(i32::cast_unsigned);
        let count = self.random.poisson(PER_CELL, 0.0, [x, y, z, 0]) as u32;
        (0..count).filter_map(move |index| {
            let [u, v, w, size] = self.random.uniforms([x, y, z, PARTICLES + index]);
            let [x_m, y_m, z_m] = [(cell[0], u), (cell[1], v), (cell[2], w)]
                .map(|(at, share)| (f64::from(at) + share) * self.side_m);
            let centre_m = Vec3::new(x_m, y_m, z_m);
            let nearest_m = self
                .eyes_m
                .map(|eye_m| (centre_m - eye_m).norm())
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            let [near_m, far_m] = self.snow.range_m;
            (near_m..=far_m).contains(&nearest_m).then(|| Particle {
                centre_m,
                radius_m: 0.5 * self.snow.diameter_quantile_m(size),
            })
        })
    }
}
