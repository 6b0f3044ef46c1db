//! Everything computed from the limbs in one row, so that it is differentiated together.

use rodsight_geometry::Vec3;

use super::Centre;
use super::covariance::UncertainLimbs;
use super::locate::{Location, Setting, locate};

/// Point, direction, depth, radius left, radius right, radius, grasp.
pub(crate) const QUANTITIES: usize = 13;
pub(crate) const DEPTH: usize = 6;
pub(crate) const RADIUS_LEFT: usize = 7;
pub(crate) const RADIUS_RIGHT: usize = 8;
pub(crate) const RADIUS: usize = 9;
pub(crate) const GRASP: usize = 10;

pub(crate) type Covariance = [[f64; QUANTITIES]; QUANTITIES];

/// The point of [`Location`] and all that is computed with it, differentiated together, and the bias of averaging.
pub(crate) fn covariance_of(
    uncertain: &UncertainLimbs<'_>,
    setting: &Setting<'_>,
    nominal: &Location,
    between: &Vec3,
    warnings: Option<&mut Vec<String>>,
) -> Option<Covariance> {
    let mut covariance =
        uncertain.propagate(|lines| quantities(&locate(setting, lines)?, nominal, between))?;
    if setting.centre == Centre::Average {
        add_averaging_bias(
            &mut covariance,
            setting,
            uncertain,
            nominal,
            between,
            warnings,
        );
    }
    if let Some((radius_m, sigma_m)) = setting.by_radius.filter(|(_, sigma)| *sigma > 0.0) {
        let step = sigma_m.min(0.01 * radius_m);
        let at = |radius_m: f64| {
            let setting = Setting {
                by_radius: Some((radius_m, 0.0)),
                ..*setting
            };
            let location = locate(&setting, &uncertain.lines())?;
            quantities(&location, nominal, between)
        };
        let (more, less) = (at(radius_m + step)?, at(radius_m - step)?);
        let mode: [f64; QUANTITIES] =
            core::array::from_fn(|i| (more[i] - less[i]) * (0.5 * sigma_m / step));
        add_mode(&mut covariance, &mode);
    }
    Some(covariance)
}

fn add_mode(covariance: &mut Covariance, mode: &[f64; QUANTITIES]) {
    for (row, a) in covariance.iter_mut().zip(mode) {
        for (entry, b) in row.iter_mut().zip(mode) {
            *entry += a * b;
        }
    }
}

fn quantities(l: &Location, nominal: &Location, between: &Vec3) -> Option<[f64; QUANTITIES]> {
    let turned = l.axis.direction.dot(&nominal.axis.direction) < 0.0;
    let (p, d) = (
        l.axis.point_m,
        l.axis.direction * if turned { -1.0 } else { 1.0 },
    );
    let depth = (l.seen_m - between).norm() * l.seen_along_m.signum();
    // Where the nominal case has a grasp point and this one has none, nothing is known of how it moves.
    let g = match nominal.grasp_m {
        Some(_) => l.grasp_m?,
        None => p,
    };
    let [left, right] = l.radii_m;
    let mut all = [0.0; QUANTITIES];
    all[..DEPTH].copy_from_slice(&[p.x, p.y, p.z, d.x, d.y, d.z]);
    all[DEPTH..GRASP].copy_from_slice(&[depth, left, right, l.radius_m]);
    all[GRASP..].copy_from_slice(g.as_slice());
    Some(all)
}

/// Averaging (ρ, θ) is biased, by −r²/Z in depth for a rod across the view, and the limbs themselves say by how much: what the
/// bisector makes of them differs by just that. The method stays the paper's, its covariance is honest about it.
fn add_averaging_bias(
    covariance: &mut Covariance,
    setting: &Setting<'_>,
    uncertain: &UncertainLimbs<'_>,
    nominal: &Location,
    between: &Vec3,
    warnings: Option<&mut Vec<String>>,
) {
    let bisector = Setting {
        centre: Centre::Bisector,
        ..*setting
    };
    let Some(other) = locate(&bisector, &uncertain.lines()) else {
        return;
    };
    let (Some(a), Some(b)) = (
        quantities(nominal, nominal, between),
        quantities(&other, nominal, between),
    ) else {
        return;
    };
    let bias: [f64; QUANTITIES] = core::array::from_fn(|i| a[i] - b[i]);
    if let Some(warnings) = warnings
        && bias[DEPTH].abs() > 3.0 * covariance[DEPTH][DEPTH].sqrt()
    {
        warnings.push(format!(
            "averaging the limbs of so thick a rod puts it about {:.1} mm off in depth; {} does not",
            1e3 * bias[DEPTH].abs(),
            Centre::Bisector.name()
        ));
    }
    add_mode(covariance, &bias);
}
