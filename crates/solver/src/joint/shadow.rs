//! Where a lamp's light ends before a limb.

use super::bands::INSIDE_PX;
use super::block::Alike;
use super::climb::Fit;
use super::crossing::Middle;
use super::fit::sums;
use super::pool::Block;
use super::state::{MOST_AMOUNT, ROD, Shadow, of_shadow};

/// Where light may end, px from the limb: what is nearer looks as light that ends at the limb, and what is farther is not looked at.
const ENDS_PX: [f64; 6] = [0.6, 0.9, 1.3, 2.0, 2.8, 3.8];
const LEAST_END_PX: f64 = 0.4;
const MOST_END_PX: f64 = 0.85 * INSIDE_PX;
/// A shadow is one if it makes the pixels so much likelier: it has two unknowns (Akaike 1974).
const LEAST_GAIN: f64 = 2.0;

/// The shadows that a fit without them would like to have.
pub(crate) fn shadows(fit: &Fit, blocks: &[Block]) -> [[Option<Shadow>; 2]; 2] {
    let radii_px = [0, 1].map(|eye| {
        let radius_px =
            |side| Middle::of(&fit.state, blocks, eye, side).map_or(0.0, |middle| middle.radius_px);
        [radius_px(0), radius_px(1)]
    });
    let angle = |radius_px: f64, end_px: f64| libm::acos(1.0 - (end_px / radius_px).min(0.9));
    let mut best = [[(LEAST_GAIN, None); 2]; 2];
    for end_px in ENDS_PX {
        let mut state = fit.state;
        state.shadows = radii_px.map(|limbs| {
            limbs.map(|radius_px| {
                (radius_px > end_px).then(|| Shadow {
                    amount: 0.0,
                    angle_rad: angle(radius_px, end_px),
                    within_rad: [LEAST_END_PX, MOST_END_PX].map(|end_px| angle(radius_px, end_px)),
                })
            })
        });
        let here = sums(&state, blocks, &fit.lit, &Alike::default());
        // Of each alone, with the rod and the blurs as free as before.
        let free = here
            .normal
            .fixed_view::<{ ROD + 2 }, { ROD + 2 }>(0, 0)
            .into_owned();
        let scale = free
            .diagonal()
            .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
        let scaled = free.component_mul(&(scale * scale.transpose()));
        let Some(factor) = scaled.cholesky() else {
            continue;
        };
        for (eye, limbs) in best.iter_mut().enumerate() {
            for (side, best) in limbs.iter_mut().enumerate() {
                let k = of_shadow(eye, side);
                let cross = here
                    .normal
                    .fixed_view::<{ ROD + 2 }, 1>(0, k)
                    .component_mul(&scale);
                let by_free = factor.solve(&cross);
                let score = here
                    .score
                    .fixed_rows::<{ ROD + 2 }>(0)
                    .component_mul(&scale);
                let information = here.normal[(k, k)] - cross.dot(&by_free) + 1.0;
                let left = here.score[k] - score.dot(&by_free);
                let gain = 0.5 * left * left / information;
                // A shadow takes light away.
                if left > 0.0 && gain > best.0 {
                    let amount = (left / information).min(MOST_AMOUNT);
                    let shadow = state.shadows[eye][side];
                    *best = (gain, shadow.map(|shadow| Shadow { amount, ..shadow }));
                }
            }
        }
    }
    best.map(|limbs| limbs.map(|(_, shadow)| shadow))
}
