//! The shadows that rods cast into the water: where along a camera ray a lamp is hidden.

use rodsight_geometry::Vec3;

use super::solid::{Capped, Ray};

/// Stretches shorter than this send no light worth a sum, m.
pub(super) const MIN_STRETCH_M: f64 = 1e-9;
/// Sine of the angle between plane and axis from which on a section is short.
const STEEP: f64 = 0.2;
/// Shadow rays end this much short of the point they ask about, relative.
const GAP: f64 = 1e-6;

/// What may stand in the light of one lamp: straight pieces of rods.
#[derive(Clone, Debug)]
pub(crate) struct Shadows {
    pub(crate) lamp_m: Vec3,
    pub(crate) casters: Vec<Caster>,
}

/// A capped cylinder as its lamp sees it. Vectors are from the lamp.
#[derive(Clone, Debug)]
pub(crate) struct Caster {
    pub(crate) piece: Capped,
    /// The rod it is of.
    pub(crate) rod: usize,
    centre_m: Vec3,
    /// The lines along which the two planes through the lamp touch the side, by their point beside the piece's centre; none if
    /// the lamp looks at a cap only.
    pub(crate) touching_m: Option<[Vec3; 2]>,
}

/// The plane of a lamp and a ray: unit vectors, and the lamp's distance from the ray.
pub(crate) struct Section {
    pub(crate) normal: Vec3,
    /// From the lamp towards the nearest point of the ray.
    pub(crate) across: Vec3,
    pub(crate) along: Vec3,
    pub(crate) distance_m: f64,
    /// Unit, to where the ray begins and ends.
    pub(crate) ends: [Direction; 2],
}

/// A direction in the plane of lamp and ray as the lamp sees it: (across, along).
pub(crate) type Direction = (f64, f64);

impl Section {
    fn direction(&self, point_m: &Vec3) -> Direction {
        (self.across.dot(point_m), self.along.dot(point_m))
    }

    /// Whether a disc in the plane lies beyond the ray or outside the angle under which the lamp sees it.
    fn misses(&self, centre_m: &Vec3, radius_m: f64) -> bool {
        let (x, y) = self.direction(centre_m);
        let [from, to] = self.ends;
        x - radius_m > self.distance_m
            || from.0 * y - from.1 * x < -radius_m
            || to.1 * x - to.0 * y < -radius_m
    }

    /// The part of the ray between the first and the last place of a convex figure in the plane, as the lamp sees them less than half a
    /// turn apart; `None` if the ray cannot be in its shadow.
    fn between(&self, first: Direction, last: Direction) -> Option<Span> {
        let h = self.distance_m;
        // The chord between both places lies in the figure. A ray on its near side is lit; the rest of the figure is as far or in its way.
        if first.0 >= h && last.0 >= h {
            return None;
        }
        let meets = |(x, y): Direction| (x > 0.0).then(|| h * y / x);
        match (meets(first), meets(last)) {
            (None, None) => None,
            (from, to) => Some(Span {
                from_m: from.unwrap_or(f64::NEG_INFINITY),
                to_m: to.unwrap_or(f64::INFINITY),
                is_behind: first.0 <= h && last.0 <= h,
            }),
        }
    }
}

/// The part of a ray that looks at its lamp across a piece, by distances from the ray's point nearest to the lamp.
pub(crate) struct Span {
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
    /// The piece is between them for sure; else a probe tells.
    pub(crate) is_behind: bool,
}

impl Shadows {
    /// Pieces come with the index of their rod.
    pub(crate) fn new(lamp_m: Vec3, pieces: impl Iterator<Item = (usize, Capped)>) -> Self {
        let casters = pieces.map(|(rod, piece)| {
            let (axis, radius_m) = (piece.cylinder.axis, piece.cylinder.radius_m);
            let centre_m = axis.point_m - lamp_m;
            let touching_m = piece.cylinder.tangent_planes(&lamp_m).map(|planes| {
                [
                    centre_m - planes.plus * radius_m,
                    centre_m + planes.minus * radius_m,
                ]
            });
            Caster {
                piece,
                rod,
                centre_m,
                touching_m,
            }
        });
        Self {
            lamp_m,
            casters: casters.collect(),
        }
    }

    /// The stretches of the first `distance_m` of a ray that the lamp does not reach, in order; they may overlap. The ray must end
    /// where it first meets a rod.
    pub(super) fn dark_stretches(&self, ray: &Ray, distance_m: f64) -> Vec<(f64, f64)> {
        let mut dark = Vec::new();
        let nearest_t_m = (self.lamp_m - ray.origin_m).dot(&ray.direction);
        let foot = ray.at(nearest_t_m) - self.lamp_m;
        let distance_to_ray_m = foot.norm();
        // All points of a ray through the lamp are in its light: the ray ends at what could stand between.
        if !(distance_to_ray_m > 1e-9) {
            return dark;
        }
        let across = foot / distance_to_ray_m;
        let section = Section {
            normal: across.cross(&ray.direction),
            across,
            along: ray.direction,
            distance_m: distance_to_ray_m,
            ends: [-nearest_t_m, distance_m - nearest_t_m].map(|along_m| {
                let far_m = (distance_to_ray_m * distance_to_ray_m + along_m * along_m).sqrt();
                (distance_to_ray_m / far_m, along_m / far_m)
            }),
        };
        for caster in &self.casters {
            let Some(span) = caster.span(&section) else {
                continue;
            };
            let from = (nearest_t_m + span.from_m).max(0.0);
            let to = (nearest_t_m + span.to_m).min(distance_m);
            if to - from > MIN_STRETCH_M
                && (span.is_behind || self.is_dark(caster, &ray.at(0.5 * (from + to))))
            {
                dark.push((from, to));
            }
        }
        dark.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        dark
    }

    fn is_dark(&self, caster: &Caster, point_m: &Vec3) -> bool {
        let to_point = point_m - self.lamp_m;
        let distance = to_point.norm();
        let ray = Ray {
            origin_m: self.lamp_m,
            direction: to_point / distance,
        };
        caster.piece.blocks(&ray, distance * (1.0 - GAP))
    }
}

impl Caster {
    /// The part of the ray that looks at the lamp across the piece; `None` if none of it can be in the piece's shadow.
    ///
    /// The plane of lamp and ray cuts the piece in a convex figure, an ellipse without what lies beyond the caps. The angles under
    /// which the lamp sees it end where the lamp's tangents touch the ellipse or at its corners, where the rims of the caps cross
    /// the plane. A ray that does not enter the piece is wholly behind or wholly before it between these angles, so that one probe
    /// tells whether it is dark there, where the angles' ends do not.
    pub(crate) fn span(&self, section: &Section) -> Option<Span> {
        let d = self.piece.cylinder.axis.direction;
        let (half, radius) = (self.piece.half_length_m, self.piece.cylinder.radius_m);
        let (off, tilt) = (section.normal.dot(&self.centre_m), section.normal.dot(&d));
        // Of many rods most are out of it: the plane misses the piece, or the ray the disc that holds the section of a steep one.
        if off.abs() > half * tilt.abs() + radius
            || (tilt.abs() > STEEP
                && section.misses(&(self.centre_m - d * (off / tilt)), radius / tilt.abs()))
        {
            return None;
        }
        let mut span: Option<(Direction, Direction)> = None;
        let mut see = |point_m: &Vec3| {
            let seen = section.direction(point_m);
            let turn = |from: Direction| from.0 * seen.1 - from.1 * seen.0;
            let (first, last) = span.unwrap_or((seen, seen));
            span = Some((
                if turn(first) < 0.0 { seen } else { first },
                if turn(last) > 0.0 { seen } else { last },
            ));
        };
        for line_m in self.touching_m.iter().flatten() {
            let off = -section.normal.dot(line_m);
            // A plane that holds the line is told by the corners.
            if off.abs() <= half * tilt.abs() && tilt != 0.0 {
                see(&(line_m + d * (off / tilt)));
            }
        }
        // Across the axis the plane is the line of points m with normal·m = −distance.
        let flat = section.normal - d * tilt;
        let flat2 = flat.norm_squared();
        for end in [-half, half] {
            let distance = off + tilt * end;
            let chord2 = radius * radius * flat2 - distance * distance;
            if chord2 >= 0.0 && flat2 > 1e-20 {
                let middle = self.centre_m + d * end - flat * (distance / flat2);
                let chord = d.cross(&section.normal) * (chord2.sqrt() / flat2);
                see(&(middle - chord));
                see(&(middle + chord));
            }
        }
        let (first, last) = span?;
        section.between(first, last)
    }
}

#[cfg(test)]
mod tests {
    use rodsight_geometry::{Cylinder, Line3};

    use super::*;

    /// A stream of numbers in [−1, 1), for scenes of all kinds.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 0x9E37_79B9_u32;
        move || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            f64::from(state) / 2_147_483_648.0 - 1.0
        }
    }

    fn point(next: &mut impl FnMut() -> f64, scale_m: f64) -> Vec3 {
        Vec3::new(next(), next(), next()) * scale_m
    }

    /// Dark by the closed form and dark by a march with a shadow test at each step, over random pieces, lamps and rays.
    #[test]
    fn stretches_agree_with_a_march_of_shadow_tests() {
        const STEPS: u32 = 2000;
        let mut next = numbers();
        let (mut shadowed, mut from_the_end) = (0, 0);
        for case in 0..4000 {
            let piece = Capped {
                cylinder: Cylinder {
                    axis: Line3::new(point(&mut next, 0.4), &point(&mut next, 1.0)),
                    radius_m: 0.15 + 0.1 * next(),
                },
                half_length_m: 0.4 + 0.35 * next(),
            };
            let mut lamp_m = point(&mut next, 2.0);
            if case % 4 == 0 {
                // Beyond an end, within the cylinder made longer.
                lamp_m = piece.cylinder.axis.point_m
                    + piece.cylinder.axis.direction * 1.5
                    + point(&mut next, 0.03);
                from_the_end += u32::from(piece.cylinder.tangent_planes(&lamp_m).is_none());
            }
            let origin_m = point(&mut next, 2.0);
            let ray = Ray {
                origin_m,
                direction: (point(&mut next, 0.8) - origin_m).normalize(),
            };
            let inside = |p: &Vec3| {
                let w = p - piece.cylinder.axis.point_m;
                let s = w.dot(&piece.cylinder.axis.direction);
                s.abs() <= piece.half_length_m
                    && piece.cylinder.axis.distance_m(p) <= piece.cylinder.radius_m
            };
            if inside(&lamp_m) || inside(&origin_m) {
                continue;
            }
            let distance_m = piece.hit(&ray).map_or(4.0, |hit| hit.t_m);
            let shadows = Shadows::new(lamp_m, core::iter::once((0, piece)));
            let dark = shadows.dark_stretches(&ray, distance_m);
            let found: f64 = dark.iter().map(|(from, to)| to - from).sum();
            let step = distance_m / f64::from(STEPS);
            let is_dark = |i: u32| {
                let p = ray.at(step * (f64::from(i) + 0.5));
                shadows.is_dark(&shadows.casters[0], &p)
            };
            let marched = f64::from((0..STEPS).filter(|&i| is_dark(i)).count() as u32) * step;
            assert!(
                (found - marched).abs() < 3.0 * step,
                "case {case}: {found} and {marched}"
            );
            shadowed += u32::from(marched > 0.0);
        }
        assert!(
            shadowed > 400 && from_the_end > 300,
            "{shadowed} shadows, {from_the_end} lamps before a cap"
        );
    }

    #[test]
    fn ray_through_the_lamp_is_all_lit() {
        let piece = Capped {
            cylinder: Cylinder {
                axis: Line3::new(Vec3::new(2.0, 0.0, 0.0), &Vec3::z()),
                radius_m: 0.1,
            },
            half_length_m: 1.0,
        };
        let shadows = Shadows::new(Vec3::zeros(), core::iter::once((0, piece)));
        let ray = Ray {
            origin_m: Vec3::zeros(),
            direction: Vec3::x(),
        };
        assert!(shadows.dark_stretches(&ray, 1.9).is_empty());
    }
}
