//! Rods as things a ray can hit: analytic capped cylinders, and arcs as chains of them.

use core::f64::consts::FRAC_PI_2;

use rodsight_geometry::{Cylinder, Line3, Vec3};
use rodsight_scene::{Bend, Rod};

/// A ray with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin_m: Vec3,
    pub(crate) direction: Vec3,
}

impl Ray {
    pub(crate) fn at(&self, t_m: f64) -> Vec3 {
        self.origin_m + self.direction * t_m
    }
}

/// Which part of a rod was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Face {
    Side,
    Cap,
}

/// Where a ray meets a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidHit {
    pub(crate) t_m: f64,
    pub(crate) normal: Vec3,
    pub(crate) face: Face,
}

/// A finite capped cylinder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capped {
    pub(crate) cylinder: Cylinder,
    half_length_m: f64,
}

impl Capped {
    fn new(centre_m: Vec3, direction: Vec3, half_length_m: f64, radius_m: f64) -> Self {
        Self {
            cylinder: Cylinder {
                axis: Line3 {
                    point_m: centre_m,
                    direction,
                },
                radius_m,
            },
            half_length_m,
        }
    }

    fn hit(&self, ray: &Ray) -> Option<SolidHit> {
        let axis = &self.cylinder.axis;
        let d = axis.direction;
        let start = d.dot(&(ray.origin_m - axis.point_m));
        let rate = d.dot(&ray.direction);
        // Part of the ray between the two end planes.
        let (mut enter, mut leave, mut face) = (f64::NEG_INFINITY, f64::INFINITY, Face::Cap);
        if rate.abs() > 1e-15 {
            let (a, b) = (
                (-self.half_length_m - start) / rate,
                (self.half_length_m - start) / rate,
            );
            (enter, leave) = (a.min(b), a.max(b));
        } else if start.abs() > self.half_length_m {
            return None;
        }
        match self.cylinder.intersect(&ray.origin_m, &ray.direction) {
            Some((near, far)) => {
                if near > enter {
                    (enter, face) = (near, Face::Side);
                }
                leave = leave.min(far);
            }
            // A miss, or a ray along the axis: inside the infinite cylinder or not.
            None if axis.distance_m(&ray.origin_m) > self.cylinder.radius_m || rate.abs() < 0.5 => {
                return None;
            }
            None => {}
        }
        if enter >= leave || enter <= 0.0 {
            return None;
        }
        let normal = match face {
            Face::Side => {
                let point = ray.at(enter);
                (point - axis.foot(&point)) / self.cylinder.radius_m
            }
            Face::Cap => d * -rate.signum(),
        };
        Some(SolidHit {
            t_m: enter,
            normal,
            face,
        })
    }

    /// Whether the ray passes the cylinder's limb closer than `footprint` (rad) allows one sample to tell.
    fn grazes(&self, ray: &Ray, footprint_rad: f64) -> bool {
        let axis = &self.cylinder.axis;
        let cross = ray.direction.cross(&axis.direction);
        let sin2 = cross.norm_squared();
        let w = axis.point_m - ray.origin_m;
        if sin2 < 1e-12 {
            return true;
        }
        let cos = ray.direction.dot(&axis.direction);
        let t = (w.dot(&ray.direction) - cos * w.dot(&axis.direction)) / sin2;
        let s = (cos * w.dot(&ray.direction) - w.dot(&axis.direction)) / sin2;
        let margin = t * footprint_rad;
        t > 0.0
            && s.abs() <= self.half_length_m + (margin + self.cylinder.radius_m) / libm::sqrt(sin2)
            && (cross.dot(&w).abs() / libm::sqrt(sin2) - self.cylinder.radius_m).abs() < margin
    }
}

/// A circular arc as a curve: the axis of a bent rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    centre_m: Vec3,
    direction: Vec3,
    towards: Vec3,
    /// 1/R; zero for a straight rod.
    curvature_per_m: f64,
}

impl Arc {
    pub(crate) fn of(rod: &Rod) -> Self {
        let (towards, curvature_per_m) = match rod.bend {
            None => (Vec3::zeros(), 0.0),
            Some(Bend { sagitta_m, towards }) => {
                (towards, curvature_of_sagitta(sagitta_m, rod.length_m))
            }
        };
        Self {
            centre_m: rod.centre_m,
            direction: rod.direction,
            towards,
            curvature_per_m,
        }
    }

    /// Point and unit tangent at arc length `s_m` from the middle.
    pub(crate) fn at(&self, s_m: f64) -> Line3 {
        if self.curvature_per_m == 0.0 {
            return Line3 {
                point_m: self.centre_m + self.direction * s_m,
                direction: self.direction,
            };
        }
        let (sin, cos) = libm::sincos(self.curvature_per_m * s_m);
        Line3 {
            point_m: self.centre_m
                + (self.direction * sin + self.towards * (1.0 - cos)) / self.curvature_per_m,
            direction: self.direction * cos + self.towards * sin,
        }
    }

    /// Arc length of the point of the curve nearest to `point_m`.
    pub(crate) fn parameter_of(&self, point_m: &Vec3) -> f64 {
        let w = point_m - self.centre_m;
        let along = w.dot(&self.direction);
        if self.curvature_per_m == 0.0 {
            return along;
        }
        libm::atan2(along, 1.0 / self.curvature_per_m - w.dot(&self.towards)) / self.curvature_per_m
    }
}

/// 1/R of an arc of length L whose ends lie h from the tangent at its middle: h = R (1 − cos(L/2R)), solved by bisection since
/// it grows with φ = L/2R up to a half circle.
fn curvature_of_sagitta(sagitta_m: f64, length_m: f64) -> f64 {
    let height = |phi: f64| length_m / (2.0 * phi) * (1.0 - libm::cos(phi));
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if height(middle) < sagitta_m {
            low = middle
        } else {
            high = middle
        }
    }
    2.0 * high / length_m
}

/// A rod ready to be hit.
#[derive(Clone, Debug)]
pub(crate) struct RodSolid {
    pub(crate) arc: Arc,
    pub(crate) half_length_m: f64,
    segments: Vec<Capped>,
    /// Bounding spheres of the implicit binary tree over `segments`: node i covers what its children 2i+1 and 2i+2 cover.
    bounds: Vec<(Vec3, f64)>,
    /// A few straight pieces that stand for the rod where only its shadow in the water is asked for.
    pub(crate) silhouette: Vec<Capped>,
}

/// Greatest distance of the chain from the arc, m: 0.002 px at 1 m from a 1080p camera.
const CHAIN_ERROR_M: f64 = 2e-6;

impl RodSolid {
    pub(crate) fn new(rod: &Rod) -> Self {
        let arc = Arc::of(rod);
        let count = if arc.curvature_per_m == 0.0 {
            1
        } else {
            // A chord of length l is κ l²/8 off its arc; half of that on either side when it is shifted outwards.
            let chord_m = libm::sqrt(16.0 * CHAIN_ERROR_M / arc.curvature_per_m);
            libm::ceil(rod.length_m / chord_m).max(1.0) as usize
        };
        let segments = chain(&arc, rod, count);
        let silhouette = chain(&arc, rod, count.min(12));
        let leaves = segments.len().next_power_of_two();
        let mut bounds = vec![(Vec3::zeros(), -1.0); 2 * leaves - 1];
        for (i, segment) in segments.iter().enumerate() {
            let radius = libm::hypot(segment.half_length_m, segment.cylinder.radius_m);
            bounds[leaves - 1 + i] = (segment.cylinder.axis.point_m, radius);
        }
        for node in (0..leaves - 1).rev() {
            let ((a, ra), (b, rb)) = (bounds[2 * node + 1], bounds[2 * node + 2]);
            let centre = if rb < 0.0 { a } else { (a + b) / 2.0 };
            let radius = if rb < 0.0 {
                ra
            } else {
                ((a - centre).norm() + ra).max((b - centre).norm() + rb)
            };
            bounds[node] = (centre, radius);
        }
        Self {
            arc,
            half_length_m: rod.length_m / 2.0,
            segments,
            bounds,
            silhouette,
        }
    }

    /// Visits every segment whose bounding sphere, grown by `margin` times its distance, the ray meets.
    fn visit(&self, ray: &Ray, margin_rad: f64, mut segment: impl FnMut(&Capped)) {
        let leaves = self.bounds.len().div_ceil(2);
        let mut stack = [0_usize; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = stack[depth];
            let (centre, radius) = self.bounds[node];
            let w = centre - ray.origin_m;
            let along = w.dot(&ray.direction);
            let reach = radius + margin_rad * along.max(0.0);
            if radius < 0.0 || along < -reach || w.norm_squared() - along * along > reach * reach {
                continue;
            }
            if node + 1 >= leaves {
                segment(&self.segments[node + 1 - leaves]);
            } else {
                stack[depth] = 2 * node + 2;
                stack[depth + 1] = 2 * node + 1;
                depth += 2;
            }
        }
    }

    /// The first point of the rod on the ray.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<SolidHit> {
        if let [only] = self.segments.as_slice() {
            return only.hit(ray);
        }
        let mut first: Option<SolidHit> = None;
        self.visit(ray, 0.0, |segment| {
            if let Some(hit) = segment.hit(ray)
                && first.is_none_or(|f| hit.t_m < f.t_m)
            {
                first = Some(hit);
            }
        });
        // Seams between segments must not show: the normal is that of the arc.
        first.map(|hit| {
            let point = ray.at(hit.t_m);
            let s_m = self.arc.parameter_of(&point);
            if hit.face == Face::Cap && s_m.abs() > self.half_length_m * (1.0 - 1e-9) {
                return hit;
            }
            SolidHit {
                normal: (point - self.arc.at(s_m).point_m).normalize(),
                face: Face::Side,
                ..hit
            }
        })
    }

    /// Whether a limb of the rod passes within `footprint_rad` of the ray.
    pub(crate) fn grazes(&self, ray: &Ray, footprint_rad: f64) -> bool {
        if let [only] = self.segments.as_slice() {
            return only.grazes(ray, footprint_rad);
        }
        let mut grazes = false;
        self.visit(ray, footprint_rad, |segment| {
            grazes = grazes || segment.grazes(ray, footprint_rad)
        });
        grazes
    }
}

impl Capped {
    /// Whether the segment from `from_m` of the given length along `direction` meets the cylinder.
    pub(crate) fn blocks(&self, ray: &Ray, length_m: f64) -> bool {
        self.hit(ray).is_some_and(|hit| hit.t_m < length_m)
    }
}

fn chain(arc: &Arc, rod: &Rod, count: usize) -> Vec<Capped> {
    let step = rod.length_m / count as f64;
    (0..count)
        .map(|i| {
            let start = step * i as f64 - rod.length_m / 2.0;
            let (a, b) = (arc.at(start).point_m, arc.at(start + step).point_m);
            let tangent = arc.at(start + step / 2.0);
            // Half of the sagitta inwards of the arc's middle, half outwards of its ends.
            let centre = ((a + b) / 2.0 + tangent.point_m) / 2.0;
            // Neighbours overlap so that no wedge opens on the outer side of the bend.
            let overlap = if count > 1 {
                rod.radius_m * libm::tan(arc.curvature_per_m * step / 2.0)
            } else {
                0.0
            };
            let (low, high) = (
                if i == 0 { 0.0 } else { overlap },
                if i + 1 == count { 0.0 } else { overlap },
            );
            let half = ((b - a).norm() + low + high) / 2.0;
            Capped::new(
                centre + tangent.direction * ((high - low) / 2.0),
                tangent.direction,
                half,
                rod.radius_m,
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rodsight_scene::Material;

    use super::*;

    fn rod(bend: Option<Bend>) -> Rod {
        Rod {
            id: "r".to_owned(),
            centre_m: Vec3::new(2.0, 0.0, 0.0),
            direction: Vec3::z(),
            length_m: 2.0,
            radius_m: 0.05,
            bend,
            material: Material::Flat([1.0; 3]),
        }
    }

    #[test]
    fn capped_cylinder_is_hit_on_its_side_its_cap_and_along_its_axis() {
        let solid = RodSolid::new(&rod(None));
        let side = solid
            .hit(&Ray {
                origin_m: Vec3::zeros(),
                direction: Vec3::x(),
            })
            .unwrap();
        assert!(
            (side.t_m - 1.95).abs() < 1e-12
                && side.face == Face::Side
                && (side.normal + Vec3::x()).norm() < 1e-12
        );
        let above = Ray {
            origin_m: Vec3::new(2.01, 0.0, -3.0),
            direction: Vec3::z(),
        };
        let cap = solid.hit(&above).unwrap();
        assert!(
            (cap.t_m - 2.0).abs() < 1e-12
                && cap.face == Face::Cap
                && (cap.normal + Vec3::z()).norm() < 1e-12
        );
        assert!(
            solid
                .hit(&Ray {
                    origin_m: Vec3::new(2.06, 0.0, -3.0),
                    direction: Vec3::z()
                })
                .is_none()
        );
        assert!(
            solid
                .hit(&Ray {
                    origin_m: Vec3::new(0.0, 0.0, 1.01),
                    direction: Vec3::x()
                })
                .is_none()
        );
        assert!(
            solid
                .hit(&Ray {
                    origin_m: Vec3::new(3.0, 0.0, 0.0),
                    direction: Vec3::x()
                })
                .is_none()
        );
    }

    #[test]
    fn chain_stays_on_its_arc_and_has_the_sagitta_asked_for() {
        let bent = rod(Some(Bend {
            sagitta_m: 0.06,
            towards: Vec3::y(),
        }));
        let solid = RodSolid::new(&bent);
        assert!((solid.arc.at(1.0).point_m.y - 0.06).abs() < 1e-12);
        assert!((solid.arc.at(-1.0).point_m.y - 0.06).abs() < 1e-12);
        for i in -99..=99 {
            let s = f64::from(i) / 100.0;
            let at = solid.arc.at(s);
            assert!((solid.arc.parameter_of(&at.point_m) - s).abs() < 1e-12);
            // From outside, along the inward normal of the bend's outer side.
            let inwards = (Vec3::y() - at.direction * at.direction.y).normalize();
            let hit = solid
                .hit(&Ray {
                    origin_m: at.point_m - inwards,
                    direction: inwards,
                })
                .unwrap();
            assert!(
                (hit.t_m - 0.95).abs() < 1.1 * CHAIN_ERROR_M,
                "s {s}: {}",
                hit.t_m
            );
        }
    }

    #[test]
    fn limb_of_a_chain_has_no_notches() {
        let bent = rod(Some(Bend {
            sagitta_m: 0.06,
            towards: Vec3::y(),
        }));
        let solid = RodSolid::new(&bent);
        for i in 0..4000 {
            let s = f64::from(i) / 2000.0 - 0.9997;
            let at = solid.arc.at(s);
            let outwards = (at.direction * at.direction.y - Vec3::y()).normalize();
            for (depth, expected) in [(0.0499, true), (0.0501, false)] {
                let origin_m = at.point_m + outwards * depth - Vec3::x();
                assert_eq!(
                    solid
                        .hit(&Ray {
                            origin_m,
                            direction: Vec3::x()
                        })
                        .is_some(),
                    expected,
                    "s {s} depth {depth}"
                );
            }
        }
    }
}
