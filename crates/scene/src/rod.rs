//! The axis of a rod, straight or bent.

use rodsight_geometry::Vec3;

use crate::check::list;
use crate::error::Complaints;
use crate::file::{BendEntry, RodEntry};
use crate::{Bend, Material, Rod, SceneError};

/// The most an axis may be bent, sagitta over length: a half circle is at 0.318.
const MAX_BEND: f64 = 0.3;

/// With their tree they take a hundred megabytes.
const MOST_LUMPS: f64 = 300_000.0;

const GIVEN_BY: &str = "from_m and to_m, or centre_m, direction and length_m";

/// Middle, direction there, length, bend.
type Axis = (Vec3, Vec3, f64, Option<Bend>);

impl RodEntry {
    pub(crate) fn to_rod(&self, no: &Complaints<'_>, key: &str) -> Result<Rod, SceneError> {
        let sub = |name: &str| format!("{key}.{name}");
        if self.id.is_empty() {
            return Err(no.value(sub("id"), "a name", "\"\""));
        }
        let radius_m = no.extent(&sub("radius_m"), self.radius_m)?;
        let axis = if let Some((from, to)) = self.ends(no, key)? {
            self.axis_between(no, key, from, to)?
        } else {
            self.axis_around_centre(no, key)?
        };
        let (centre_m, direction, length_m, bend) = axis;
        let material = self.material(no, key)?;
        let surface = self.surface.unwrap_or_default();
        let rod = Rod {
            id: self.id.clone(),
            centre_m,
            direction,
            length_m,
            radius_m,
            bend,
            material,
            finish: surface.to_finish(no, &sub("surface"), material)?,
            fouling: surface.to_fouling(no, &sub("surface"))?,
        };
        if let Some(bend) = rod.bend {
            let limit_m = MAX_BEND * length_m;
            no.number(
                &sub("bend.sagitta_m"),
                bend.sagitta_m,
                &format!("at most {MAX_BEND} of the length ({limit_m:.4})"),
                |v| v <= limit_m,
            )?;
            let arc_m = arc_radius_m(length_m, bend.sagitta_m);
            no.number(
                &sub("radius_m"),
                radius_m,
                &format!("less than the radius of the bend ({arc_m:.4})"),
                |v| v < arc_m,
            )?;
        }
        if let Some(fouling) = rod.fouling {
            let lumps = fouling.lumps(&rod);
            let expected = format!("lumps so large that at most {MOST_LUMPS} cover the rod");
            no.number(
                &sub("surface.fouling.height_m"),
                fouling.height_m,
                &expected,
                |_| lumps <= MOST_LUMPS,
            )?;
        }
        Ok(rod)
    }

    fn axis_between(
        &self,
        no: &Complaints<'_>,
        key: &str,
        from: Vec3,
        to: Vec3,
    ) -> Result<Axis, SceneError> {
        let chord = to - from;
        let chord_m = chord.norm();
        if !(chord_m >= 1e-6) {
            let found = list(to.into());
            return Err(no.value(format!("{key}.to_m"), "a point other than from_m", found));
        }
        let (middle, direction) = ((from + to) * 0.5, chord / chord_m);
        let Some(entry) = self.bend else {
            return Ok((middle, direction, chord_m, None));
        };
        // The ends stay where they are; the middle goes away from the arc's centre.
        let bend = entry.to_bend(no, key, &direction)?;
        let sagitta_m = bend.sagitta_m;
        let half_angle = 2.0 * libm::atan2(2.0 * sagitta_m, chord_m);
        let arc_radius_m = (0.25 * chord_m * chord_m + sagitta_m * sagitta_m) / (2.0 * sagitta_m);
        let centre_m = middle - bend.towards * sagitta_m;
        Ok((
            centre_m,
            direction,
            2.0 * arc_radius_m * half_angle,
            Some(bend),
        ))
    }

    fn axis_around_centre(&self, no: &Complaints<'_>, key: &str) -> Result<Axis, SceneError> {
        let missing = |name: &str| no.value(format!("{key}.{name}"), GIVEN_BY, "nothing");
        let centre = self.centre_m.ok_or_else(|| missing("centre_m"))?;
        let direction = self.direction.ok_or_else(|| missing("direction"))?;
        let length = self.length_m.ok_or_else(|| missing("length_m"))?;
        let direction = no.direction(&format!("{key}.direction"), direction)?;
        let bend = self.bend.map(|entry| entry.to_bend(no, key, &direction));
        Ok((
            no.point(&format!("{key}.centre_m"), centre)?,
            direction,
            no.extent(&format!("{key}.length_m"), length)?,
            bend.transpose()?,
        ))
    }

    /// `from_m` and `to_m`, if the rod is given by them.
    fn ends(&self, no: &Complaints<'_>, key: &str) -> Result<Option<(Vec3, Vec3)>, SceneError> {
        let other = self.centre_m.is_some() || self.direction.is_some() || self.length_m.is_some();
        match (self.from_m, self.to_m) {
            (Some(_), _) | (_, Some(_)) if other => Err(no.value(key, GIVEN_BY, "some of both")),
            (Some(from), Some(to)) => Ok(Some((
                no.point(&format!("{key}.from_m"), from)?,
                no.point(&format!("{key}.to_m"), to)?,
            ))),
            (Some(_), None) => Err(no.value(key, GIVEN_BY, "from_m only")),
            (None, Some(_)) => Err(no.value(key, GIVEN_BY, "to_m only")),
            (None, None) if other => Ok(None),
            (None, None) => Err(no.value(key, GIVEN_BY, "none of them")),
        }
    }

    fn material(&self, no: &Complaints<'_>, key: &str) -> Result<Material, SceneError> {
        let expected = "either albedo or flat_radiance_w_per_m2_sr";
        match (self.albedo, self.flat_radiance_w_per_m2_sr) {
            (Some(albedo), None) => Ok(Material::Lambert(
                no.albedo(&format!("{key}.albedo"), albedo)?,
            )),
            (None, Some(radiance)) => Ok(Material::Flat(
                no.not_negative_bands(&format!("{key}.flat_radiance_w_per_m2_sr"), radiance)?,
            )),
            (Some(_), Some(_)) => Err(no.value(key, expected, "both")),
            (None, None) => Err(no.value(key, expected, "neither")),
        }
    }
}

impl BendEntry {
    fn to_bend(self, no: &Complaints<'_>, key: &str, direction: &Vec3) -> Result<Bend, SceneError> {
        Ok(Bend {
            sagitta_m: no.extent(&format!("{key}.bend.sagitta_m"), self.sagitta_m)?,
            towards: self.towards(no, key, direction)?,
        })
    }

    /// The unit vector perpendicular to the axis on the given side.
    fn towards(
        &self,
        no: &Complaints<'_>,
        key: &str,
        direction: &Vec3,
    ) -> Result<Vec3, SceneError> {
        let key = format!("{key}.bend.towards");
        let side = no.direction(&key, self.towards)?;
        let along = side.dot(direction);
        // What is perpendicular already stays as it is to the last bit.
        if along.abs() <= 4.0 * f64::EPSILON {
            return Ok(side);
        }
        let across = side - direction * along;
        if !(across.norm() > 1e-6) {
            return Err(no.value(key, "a direction across the rod", "one along it"));
        }
        // Once more: for a side nearly along the rod the first subtraction leaves rounding behind.
        let across = across.normalize();
        Ok((across - direction * across.dot(direction)).normalize())
    }
}

impl Rod {
    /// Radius of the arc of a bent rod's axis, m.
    pub fn bend_radius_m(&self) -> Option<f64> {
        self.bend
            .map(|bend| arc_radius_m(self.length_m, bend.sagitta_m))
    }

    /// The point of the axis at a distance along it from the middle, m, and the unit tangent there.
    pub fn axis_at(&self, along_m: f64) -> (Vec3, Vec3) {
        match self.bend {
            None => (self.centre_m + self.direction * along_m, self.direction),
            Some(Bend { sagitta_m, towards }) => {
                let radius_m = arc_radius_m(self.length_m, sagitta_m);
                let (sin, cos) = libm::sincos(along_m / radius_m);
                // 1 − cos by the half angle: a slight bend must not cancel.
                let half_sin = libm::sin(0.5 * along_m / radius_m);
                (
                    self.centre_m
                        + self.direction * (radius_m * sin)
                        + towards * (2.0 * radius_m * half_sin * half_sin),
                    self.direction * cos + towards * sin,
                )
            }
        }
    }

    /// Where along the axis, from the middle, a point is nearest; may lie beyond the ends.
    pub fn nearest_along_m(&self, point_m: &Vec3) -> f64 {
        let from_centre = point_m - self.centre_m;
        let forward = from_centre.dot(&self.direction);
        match self.bend {
            None => forward,
            Some(Bend { sagitta_m, towards }) => {
                let radius_m = arc_radius_m(self.length_m, sagitta_m);
                radius_m * libm::atan2(forward, radius_m - from_centre.dot(&towards))
            }
        }
    }

    /// Whether a point lies inside the rod.
    pub fn contains(&self, point_m: &Vec3) -> bool {
        let along_m = self.nearest_along_m(point_m);
        along_m.abs() <= 0.5 * self.length_m
            && (self.axis_at(along_m).0 - point_m).norm() < self.radius_m
    }
}

/// Radius of an arc of length L and sagitta s: (1 − cos φ)/φ = 2s/L with φ = L/2R, by Newton's method.
fn arc_radius_m(length_m: f64, sagitta_m: f64) -> f64 {
    let ratio = 2.0 * sagitta_m / length_m;
    let mut phi = 2.0 * ratio;
    for _ in 0..8 {
        let half_sin = libm::sin(0.5 * phi);
        let versine = 2.0 * half_sin * half_sin;
        let slope = (libm::sin(phi) * phi - versine) / (phi * phi);
        phi -= (versine / phi - ratio) / slope;
    }
    0.5 * length_m / phi
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;

    fn bent(sagitta_m: f64) -> Rod {
        Rod {
            id: "bent".to_owned(),
            centre_m: Vec3::new(2.0, 0.1, -0.5),
            direction: Vec3::y(),
            length_m: 2.0,
            radius_m: 0.05,
            bend: Some(Bend {
                sagitta_m,
                towards: Vec3::z(),
            }),
            material: Material::Lambert([0.5; 3]),
            finish: crate::Finish::default(),
            fouling: None,
        }
    }

    #[test]
    fn bend_has_the_sagitta_and_the_length_asked_for() {
        for sagitta_m in [1e-6, 0.01, 0.06, 0.3, 0.6] {
            let rod = bent(sagitta_m);
            for end in [-1.0, 1.0] {
                let (tip, tangent) = rod.axis_at(end);
                let height = (tip - rod.centre_m).dot(&Vec3::z());
                assert!((height - sagitta_m).abs() < 1e-12, "{sagitta_m}: {height}");
                assert!((tangent.norm() - 1.0).abs() < 1e-14);
                assert!((rod.nearest_along_m(&tip) - end).abs() < 1e-9);
            }
            let steps = 1000;
            let mut length = 0.0;
            for k in 0..steps {
                let at = |j: i32| rod.axis_at(2.0 * f64::from(j) / f64::from(steps) - 1.0).0;
                length += (at(k + 1) - at(k)).norm();
            }
            assert!((length - 2.0).abs() < 1e-5, "{sagitta_m}: {length}");
        }
    }

    #[test]
    fn rod_contains_its_axis_and_not_what_is_beyond_its_ends() {
        let rod = bent(0.06);
        assert!(rod.contains(&rod.axis_at(0.9).0));
        assert!(!rod.contains(&rod.axis_at(1.1).0));
        assert!(!rod.contains(&(rod.centre_m + Vec3::x() * 0.051)));
        // Where a straight rod would be, at the end, this one is not.
        assert!(!rod.contains(&(rod.centre_m + Vec3::y() * 0.99)));
    }
}
