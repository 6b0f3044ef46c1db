//! Rods as things a ray can hit: a capped cylinder, or a chain of them along an arc.

use rodsight_geometry::Vec3;
use rodsight_scene::Rod;

use super::arc::Arc;
use super::solid::{Capped, Face, Ray, SolidHit};

/// A rod ready to be hit.
#[derive(Clone, Debug)]
pub(crate) struct RodSolid {
    pub(crate) arc: Arc,
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
            segments,
            bounds,
            silhouette,
        }
    }

    /// Visits every segment whose bounding sphere, grown by `margin` times its distance, the ray meets.
    fn visit(&self, ray: &Ray, margin_rad: f64, mut segment: impl FnMut(usize, &Capped)) {
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
                let index = node + 1 - leaves;
                segment(index, &self.segments[index]);
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
        let mut first: Option<(usize, SolidHit)> = None;
        self.visit(ray, 0.0, |index, segment| {
            if let Some(hit) = segment.hit(ray)
                && first.is_none_or(|(_, f)| hit.t_m < f.t_m)
            {
                first = Some((index, hit));
            }
        });
        first.map(|(index, hit)| {
            if hit.face == Face::Cap && self.is_end(index, &hit.normal) {
                return hit;
            }
            // Seams between segments must not show: the normal is that of the arc.
            let point = ray.at(hit.t_m);
            let axis = self.arc.at(self.arc.parameter_of(&point));
            SolidHit {
                normal: (point - axis.point_m).normalize(),
                face: Face::Side,
                ..hit
            }
        })
    }

    /// Whether the cap of a segment with this normal is an end of the rod, not a seam.
    fn is_end(&self, index: usize, normal: &Vec3) -> bool {
        let outwards = self.segments[index].cylinder.axis.direction.dot(normal);
        (index == 0 && outwards < 0.0) || (index + 1 == self.segments.len() && outwards > 0.0)
    }

    /// Whether a limb of the rod passes within `footprint_rad` of the ray.
    pub(crate) fn grazes(&self, ray: &Ray, footprint_rad: f64) -> bool {
        if let [only] = self.segments.as_slice() {
            return only.grazes(ray, footprint_rad);
        }
        let mut grazes = false;
        self.visit(ray, footprint_rad, |_, segment| {
            grazes = grazes || segment.grazes(ray, footprint_rad);
        });
        grazes
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
    use rodsight_scene::{Bend, Material};

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

    /// The cap of a bent rod is as flat as that of a straight one: on all of it the normal is the end's tangent.
    #[test]
    fn end_of_a_chain_is_a_flat_cap() {
        let bent = rod(Some(Bend {
            sagitta_m: 0.06,
            towards: Vec3::y(),
        }));
        let solid = RodSolid::new(&bent);
        let end = solid.arc.at(1.0);
        let across = Vec3::x().cross(&end.direction);
        for turn in 0..12 {
            let (sin, cos) = libm::sincos(f64::from(turn) * 0.523);
            let origin_m = end.point_m + (Vec3::x() * cos + across * sin) * 0.04 + end.direction;
            let hit = solid
                .hit(&Ray {
                    origin_m,
                    direction: -end.direction,
                })
                .unwrap();
            assert_eq!(hit.face, Face::Cap, "turn {turn}");
            assert!(
                hit.normal.dot(&end.direction) > 0.999_99,
                "turn {turn}: {:?}",
                hit.normal
            );
        }
    }

    /// From inside, from behind, and along the surface a ray meets nothing or what it should.
    #[test]
    fn rays_along_the_rod_meet_its_cap_or_nothing() {
        let solid = RodSolid::new(&rod(None));
        let along = |x_m: f64, z_m: f64| {
            solid.hit(&Ray {
                origin_m: Vec3::new(x_m, 0.0, z_m),
                direction: Vec3::z(),
            })
        };
        for off_m in [0.0, 0.02, 0.049_999] {
            let hit = along(2.0 + off_m, -3.0).unwrap();
            assert!(
                (hit.t_m - 2.0).abs() < 1e-12 && hit.face == Face::Cap,
                "{off_m}"
            );
        }
        assert!(along(2.050_001, -3.0).is_none(), "beside it");
        assert!(along(2.0, 0.0).is_none(), "from inside");
        assert!(along(2.0, 1.5).is_none(), "behind the origin");
        // Between the planes of the ends, and tilted by a hair: still the near side.
        let tilted = solid
            .hit(&Ray {
                origin_m: Vec3::new(1.9, 0.0, -0.9),
                direction: Vec3::new(0.05, 0.0, 1.0).normalize(),
            })
            .unwrap();
        assert_eq!(tilted.face, Face::Side);
        assert!((tilted.normal + Vec3::x()).norm() < 1e-12);
    }
}
