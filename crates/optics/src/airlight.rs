//! The light of a lamp that the water scatters into a camera ray before it reaches anything.
//!
//!   L(v) = ∫₀^D b p(μ) I(w)/r² e^(−K(r+t)) dt,  w from the lamp to the point at t, cos μ = −w·v
//!
//! Light that travels along w and is scattered into the camera travels along −v: light from a lamp beside the camera comes
//! back, cos μ → −1; light from a lamp behind the subject goes on, cos μ → +1.

use rodsight_geometry::Vec3;

use crate::{Bands, Medium, exponential, transmittance};

/// The lamp's distance from the ray is never taken smaller, m: a ray through the lamp itself has no finite answer.
const NEAREST_M: f64 = 1e-3;

/// The equi-angular midpoint nodes of one camera ray and one lamp (Kulla and Fajardo 2012).
///
/// With h the distance of the lamp from the ray and t₀ the ray's point nearest to it, t = t₀ + h tan θ and
/// dt/r² = dθ/h: the 1/r² of the lamp cancels exactly, and equal steps in θ are what is left to sum. In θ everything else
/// is simple too: r = h/cos θ, cos μ = −sin θ. The sine and cosine go from node to node by addition of angles.
#[derive(Clone, Debug)]
pub struct EquiAngular {
    nearest_t_m: f64,
    distance_to_ray_m: f64,
    /// Unit, from the lamp to the ray's nearest point.
    across: Vec3,
    along: Vec3,
    sin: f64,
    cos: f64,
    step_sin: f64,
    step_cos: f64,
    weight_per_m: f64,
    left: u32,
}

/// One node of the quadrature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Distance from the ray's origin, m.
    pub t_m: f64,
    /// Distance from the lamp, m.
    pub r_m: f64,
    /// Unit vector from the lamp to the node.
    pub from_lamp: Vec3,
    /// Cosine of the scattering angle, forward = +1.
    pub cos_scatter: f64,
    /// dθ/h, the same for all nodes of a ray: it stands for dt/r², m⁻¹.
    pub weight_per_m: f64,
}

impl EquiAngular {
    /// Nodes between the ray's origin and `distance_m` along it (which may be infinite).
    ///
    /// * `lamp_from_origin`: lamp − ray origin, m; * `direction`: unit.
    pub fn new(lamp_from_origin: &Vec3, direction: &Vec3, distance_m: f64, points: u32) -> Self {
        let t0 = lamp_from_origin.dot(direction);
        let foot = direction * t0 - lamp_from_origin;
        let true_h = foot.norm();
        let across = if true_h > 1e-9 {
            foot / true_h
        } else {
            any_perpendicular(direction)
        };
        let h = true_h.max(NEAREST_M);
        // tan θ runs from −t₀/h to (D − t₀)/h; their difference by one arctangent, good for D = ∞.
        let span = if distance_m.is_infinite() {
            libm::atan2(h, -t0)
        } else {
            libm::atan2(h * distance_m, h * h - t0 * (distance_m - t0))
        };
        let empty = points == 0 || !(distance_m > 0.0);
        let step = if empty { 0.0 } else { span / f64::from(points) };
        let (half_sin, half_cos) = libm::sincos(0.5 * step);
        let (sin_0, cos_0) = {
            let hypotenuse = (t0 * t0 + h * h).sqrt();
            (-t0 / hypotenuse, h / hypotenuse)
        };
        Self {
            nearest_t_m: t0,
            distance_to_ray_m: h,
            across,
            along: *direction,
            sin: sin_0 * half_cos + cos_0 * half_sin,
            cos: cos_0 * half_cos - sin_0 * half_sin,
            step_sin: 2.0 * half_sin * half_cos,
            step_cos: 1.0 - 2.0 * half_sin * half_sin,
            weight_per_m: step / h,
            left: if empty { 0 } else { points },
        }
    }

    /// dθ/h of every node, m⁻¹.
    pub fn weight_per_m(&self) -> f64 {
        self.weight_per_m
    }
}

impl Iterator for EquiAngular {
    type Item = Node;

    #[inline]
    fn next(&mut self) -> Option<Node> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        let (sin, cos) = (self.sin, self.cos);
        self.sin = sin * self.step_cos + cos * self.step_sin;
        self.cos = cos * self.step_cos - sin * self.step_sin;
        let r_m = self.distance_to_ray_m / cos;
        Some(Node {
            t_m: self.nearest_t_m + r_m * sin,
            r_m,
            from_lamp: self.across * cos + self.along * sin,
            cos_scatter: -sin,
            weight_per_m: self.weight_per_m,
        })
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for EquiAngular {}

fn any_perpendicular(direction: &Vec3) -> Vec3 {
    let axis = if direction.x.abs() < 0.5 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    direction.cross(&axis).normalize()
}

/// Nodes that are worked out together. They are a ray's lit nodes in order, four by four, so that a sum does not depend on
/// what else is rendered.
const LANES: usize = 4;

/// Lit nodes that wait for company; the lanes beyond `filled` carry no light.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    filled: usize,
    light: [f64; LANES],
    cos_scatter: [f64; LANES],
    path_m: [f64; LANES],
}

/// The airlight of lamps in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Airlight<'a> {
    /// The water.
    pub medium: &'a Medium,
    /// Attenuation of both legs: c for classic single scattering, K = a + b(1 − ⟨cos θ⟩) for the full model.
    pub attenuation_per_m: Bands,
    /// Midpoints per ray and lamp: 16 are good for 1 %, 32 for 0.3 %.
    pub points: u32,
}

impl Airlight<'_> {
    /// Radiance, per unit radiant intensity, that one lamp's light adds to a ray of length `distance_m`: sr⁻¹ m⁻², to be
    /// multiplied by the lamp's W/sr.
    ///
    ///   (b/h) Σ p(μ) emitted e^(−K(r+t)) dθ
    ///
    /// * `lamp_from_origin`: lamp − ray origin, m; * `direction`: unit;
    /// * `emitted(w, t)`: what the lamp sends along the unit vector w to the node at t, relative to its axis: the cone's
    ///   profile times the visibility. Where it is 0 nothing more is computed.
    #[inline]
    pub fn lamp(
        &self,
        lamp_from_origin: &Vec3,
        direction: &Vec3,
        distance_m: f64,
        emitted: impl Fn(&Vec3, f64) -> f64,
    ) -> Bands {
        let scattering = self.medium.scattering_per_m();
        if scattering == [0.0; 3] {
            return [0.0; 3];
        }
        let nodes = EquiAngular::new(lamp_from_origin, direction, distance_m, self.points);
        let weight = nodes.weight_per_m();
        let mut block = Block::default();
        let mut sum = [[0.0; LANES]; 3];
        for node in nodes {
            let light = emitted(&node.from_lamp, node.t_m);
            if light == 0.0 {
                continue;
            }
            block.light[block.filled] = light;
            block.cos_scatter[block.filled] = node.cos_scatter;
            block.path_m[block.filled] = node.r_m + node.t_m;
            block.filled += 1;
            if block.filled == LANES {
                self.add(&block, &mut sum);
                block = Block::default();
            }
        }
        if block.filled > 0 {
            self.add(&block, &mut sum);
        }
        let sum = sum.map(|[a, b, c, d]| (a + b) + (c + d));
        core::array::from_fn(|k| scattering[k] * weight * sum[k])
    }

    /// The integrand: radiance per unit radiant intensity and metre that the ray gains at `distance_m`, sr⁻¹ m⁻³.
    ///
    /// Arguments as of [`lamp`](Self::lamp).
    pub fn lamp_per_m(
        &self,
        lamp_from_origin: &Vec3,
        direction: &Vec3,
        distance_m: f64,
        emitted: impl Fn(&Vec3, f64) -> f64,
    ) -> Bands {
        let from_lamp = direction * distance_m - lamp_from_origin;
        let r_m = from_lamp.norm().max(NEAREST_M);
        let from_lamp = from_lamp / r_m;
        let light = emitted(&from_lamp, distance_m) / (r_m * r_m);
        if light == 0.0 {
            return [0.0; 3];
        }
        let source = light * self.medium.phase_per_sr(-from_lamp.dot(direction));
        let left = transmittance(&self.attenuation_per_m, r_m + distance_m);
        let scattering = self.medium.scattering_per_m();
        core::array::from_fn(|k| scattering[k] * source * left[k])
    }

    #[inline]
    fn add(&self, block: &Block, sum: &mut [[f64; LANES]; 3]) {
        let phase = self.medium.phases_per_sr(&block.cos_scatter);
        let source: [f64; LANES] = core::array::from_fn(|j| block.light[j] * phase[j]);
        for (sum, attenuation) in sum.iter_mut().zip(self.attenuation_per_m) {
            let left = exponential::exp(&block.path_m.map(|path| -attenuation * path));
            *sum = core::array::from_fn(|j| sum[j] + source[j] * left[j]);
        }
    }
}
