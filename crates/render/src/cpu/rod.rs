//! Rods as things a ray can hit: capped cylinders, or chains of them along arcs.

use rodsight_geometry::Vec3;
use rodsight_scene::Rod;

use super::arc::Arc;
use super::solid::{Capped, Face, Ray, SolidHit};
use crate::bvh::{Bounds, Bvh};

/// A rod as straight pieces.
#[derive(Clone, Debug)]
pub(crate) struct RodSolid {
    pub(crate) arc: Arc,
    /// One piece, or a chain along the arc.
    pub(crate) segments: Vec<Capped>,
    /// A few pieces that stand for the rod where only its shadow in the water is asked for.
    pub(crate) silhouette: Vec<Capped>,
}

/// Greatest distance of the chain from the arc, m: 0.002 px at 1 m from a 1080p camera.
const CHAIN_ERROR_M: f64 = 2e-6;

impl RodSolid {
    fn new(rod: &Rod) -> Self {
        let arc = Arc::of(rod);
        let count = if arc.curvature_per_m == 0.0 {
            1
        } else {
            // A chord of length l is κ l²/8 off its arc; half of that on either side when it is shifted outwards.
            let chord_m = libm::sqrt(16.0 * CHAIN_ERROR_M / arc.curvature_per_m);
            libm::ceil(rod.length_m / chord_m).max(1.0) as usize
        };
        Self {
            arc,
            segments: chain(&arc, rod, count),
            silhouette: chain(&arc, rod, count.min(12)),
        }
    }

    /// Whether the cap of a segment with this normal is an end of the rod, not a seam.
    fn is_end(&self, index: usize, normal: &Vec3) -> bool {
        let outwards = self.segments[index].cylinder.axis.direction.dot(normal);
        (index == 0 && outwards < 0.0) || (index + 1 == self.segments.len() && outwards > 0.0)
    }

    /// The hit on a segment as one on the rod: seams must not show, so the normal is that of the arc.
    fn seamless(&self, index: usize, hit: SolidHit, ray: &Ray) -> SolidHit {
        if self.segments.len() == 1 || (hit.face == Face::Cap && self.is_end(index, &hit.normal)) {
            return hit;
        }
        let point = ray.at(hit.t_m);
        let axis = self.arc.at(self.arc.parameter_of(&point));
        SolidHit {
            normal: (point - axis.point_m).normalize(),
            face: Face::Side,
            ..hit
        }
    }
}

/// All rods of a scene, ready to be hit.
#[derive(Clone, Debug)]
pub(crate) struct Rods {
    pub(crate) solids: Vec<RodSolid>,
    /// Every segment of every rod, as (rod, segment).
    pub(crate) pieces: Vec<(usize, usize)>,
    pub(crate) tree: Bvh,
}

impl Rods {
    pub(crate) fn new(rods: &[Rod]) -> Self {
        let solids: Vec<RodSolid> = rods.iter().map(RodSolid::new).collect();
        let pieces: Vec<(usize, usize)> = solids
            .iter()
            .enumerate()
            .flat_map(|(rod, solid)| (0..solid.segments.len()).map(move |segment| (rod, segment)))
            .collect();
        let boxes: Vec<Bounds> = pieces
            .iter()
            .map(|&(rod, segment)| solids[rod].segments[segment].bounds())
            .collect();
        Self {
            solids,
            pieces,
            tree: Bvh::new(&boxes),
        }
    }

    /// The first point of any rod on the ray, and which.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<(usize, SolidHit)> {
        let mut first: Option<(usize, SolidHit)> = None;
        self.tree.visit(ray, 0.0, f64::INFINITY, |piece| {
            let (rod, segment) = self.pieces[piece];
            if let Some(hit) = self.solids[rod].segments[segment].hit(ray)
                && first.is_none_or(|(there, f)| {
                    // Two rods at the very same distance: the one that the scene names first, whatever the tree.
                    hit.t_m < f.t_m || (hit.t_m == f.t_m && piece < there)
                })
            {
                first = Some((piece, hit));
            }
            first.map_or(f64::INFINITY, |(_, f)| f.t_m)
        });
        first.map(|(piece, hit)| {
            let (rod, segment) = self.pieces[piece];
            (rod, self.solids[rod].seamless(segment, hit, ray))
        })
    }

    /// Whether the first `length_m` of the ray meet a rod.
    pub(crate) fn block(&self, ray: &Ray, length_m: f64) -> bool {
        let mut blocked = false;
        self.tree.visit(ray, 0.0, length_m, |piece| {
            let (rod, segment) = self.pieces[piece];
            blocked = blocked || self.solids[rod].segments[segment].blocks(ray, length_m);
            if blocked { f64::NEG_INFINITY } else { length_m }
        });
        blocked
    }

    /// Whether a limb of a rod passes within `footprint_rad` of the ray.
    pub(crate) fn graze(&self, ray: &Ray, footprint_rad: f64) -> bool {
        let mut grazes = false;
        self.tree.visit(ray, footprint_rad, f64::INFINITY, |piece| {
            let (rod, segment) = self.pieces[piece];
            grazes = grazes || self.solids[rod].segments[segment].grazes(ray, footprint_rad);
            if grazes {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            }
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
            finish: rodsight_scene::Finish::default(),
            fouling: None,
        }
    }

    #[test]
    fn capped_cylinder_is_hit_on_its_side_its_cap_and_along_its_axis() {
        let solid = Rods::new(&[rod(None)]);
        let side = solid
            .hit(&Ray {
                origin_m: Vec3::zeros(),
                direction: Vec3::x(),
            })
            .unwrap()
            .1;
        assert!(
            (side.t_m - 1.95).abs() < 1e-12
                && side.face == Face::Side
                && (side.normal + Vec3::x()).norm() < 1e-12
        );
        let above = Ray {
            origin_m: Vec3::new(2.01, 0.0, -3.0),
            direction: Vec3::z(),
        };
        let cap = solid.hit(&above).unwrap().1;
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
        let solid = Rods::new(&[bent]);
        assert!((solid.solids[0].arc.at(1.0).point_m.y - 0.06).abs() < 1e-12);
        assert!((solid.solids[0].arc.at(-1.0).point_m.y - 0.06).abs() < 1e-12);
        for i in -99..=99 {
            let s = f64::from(i) / 100.0;
            let at = solid.solids[0].arc.at(s);
            assert!((solid.solids[0].arc.parameter_of(&at.point_m) - s).abs() < 1e-12);
            // From outside, along the inward normal of the bend's outer side.
            let inwards = (Vec3::y() - at.direction * at.direction.y).normalize();
            let hit = solid
                .hit(&Ray {
                    origin_m: at.point_m - inwards,
                    direction: inwards,
                })
                .unwrap()
                .1;
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
        let solid = Rods::new(&[bent]);
        for i in 0..4000 {
            let s = f64::from(i) / 2000.0 - 0.9997;
            let at = solid.solids[0].arc.at(s);
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
        let solid = Rods::new(&[bent]);
        let end = solid.solids[0].arc.at(1.0);
        let across = Vec3::x().cross(&end.direction);
        for turn in 0..12 {
            let (sin, cos) = libm::sincos(f64::from(turn) * 0.523);
            let origin_m = end.point_m + (Vec3::x() * cos + across * sin) * 0.04 + end.direction;
            let hit = solid
                .hit(&Ray {
                    origin_m,
                    direction: -end.direction,
                })
                .unwrap()
                .1;
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
        let solid = Rods::new(&[rod(None)]);
        let along = |x_m: f64, z_m: f64| {
            solid.hit(&Ray {
                origin_m: Vec3::new(x_m, 0.0, z_m),
                direction: Vec3::z(),
            })
        };
        for off_m in [0.0, 0.02, 0.049_999] {
            let hit = along(2.0 + off_m, -3.0).unwrap().1;
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
            .unwrap()
            .1;
        assert_eq!(tilted.face, Face::Side);
        assert!((tilted.normal + Vec3::x()).norm() < 1e-12);
    }
}
