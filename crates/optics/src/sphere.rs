//! A matt sphere, as its light comes from afar.

use core::f64::consts::PI;

/// Mean radiance of a Lambert sphere's disc over ρ E/π, E the irradiance on a plane that faces the lamp, for the cosine of the angle α at
/// the sphere between lamp and eye: ⅔ (sin α + (π − α) cos α)/π. That is 2/3 seen from the lamp, and all of it together sends
/// ρ E times the area of the disc.
#[inline]
pub fn sphere_share(cos_alpha: f64) -> f64 {
    let cos = cos_alpha.clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    2.0 / 3.0 * (sin / PI + (1.0 - libm::acos(cos) / PI) * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sphere_sends_what_falls_on_its_disc() {
        assert!((sphere_share(1.0) - 2.0 / 3.0).abs() < 1e-15);
        assert!((sphere_share(0.0) - 2.0 / (3.0 * PI)).abs() < 1e-15);
        assert!(sphere_share(-1.0).abs() < 1e-15);
        // ∫ share/π dΩ = 1.
        let steps = 20_000;
        let sum: f64 = (0..steps)
            .map(|i| sphere_share(-1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(steps)))
            .sum();
        let sent = 2.0 * sum * 2.0 / f64::from(steps);
        assert!((sent - 1.0).abs() < 1e-8, "{sent}");
    }
}
