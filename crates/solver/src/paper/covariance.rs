//! How uncertain the limbs are, and what that makes of everything computed from them.

use rodsight_geometry::ImageLine;

use crate::paper::{PaperParams, RefinedLine};

/// Number of line parameters: (shift, turn) of two limbs in two eyes.
const PARAMETERS: usize = 8;
/// Steps of the central differences: small against any floor, large against rounding.
const SHIFT_STEP_PX: f64 = 1e-3;
const TURN_STEP_RAD: f64 = 1e-6;

/// A cause of error with standard deviation one: how it moves (shift px, turn rad) of each limb.
type Mode = [f64; PARAMETERS];

/// The four limbs with their errors. A limb is shifted along its normal and turned about the mean of its points, where
/// the two do not correlate.
#[derive(Debug)]
pub(crate) struct UncertainLimbs<'a> {
    limbs: [[&'a RefinedLine; 2]; 2],
    modes: Vec<Mode>,
}

impl<'a> UncertainLimbs<'a> {
    /// Scatter of the points, and the declared floors:
    ///
    /// * var(ρ) = s²/n, var(θ) = s²/(n ⟨t²⟩), with s² the variance of the residuals, ⟨t²⟩ that of the positions along the line and
    ///   n the number of points, but no more than px of length: neighbours on a stair do not err independently;
    /// * a shift of both images alike, across the rod, a shift of each limb, and a tilt that moves its ends apart.
    ///
    /// What the last refinement still moved counts as tilt.
    /// A bend shifts a limb by itself, and tilts it.
    pub(crate) fn new(limbs: [[&'a RefinedLine; 2]; 2], params: &PaperParams) -> Self {
        let mut modes = Vec::new();
        let towards = limbs[0][0].line.normal() * params.common_floor_px;
        let mut common = [0.0; PARAMETERS];
        for (eye, pair) in limbs.iter().enumerate() {
            for (side, limb) in pair.iter().enumerate() {
                let at = 4 * eye + 2 * side;
                let mut mode = |offset: usize, sigma: f64| {
                    let mut mode = [0.0; PARAMETERS];
                    mode[at + offset] = sigma;
                    modes.push(mode);
                };
                let count = limb.support.max(3) as f64;
                let extent = limb.extent_px().max(1.0);
                let independent = count.min(extent).max(1.0);
                let sigma = libm::sqrt(limb.scatter_across_px2 / (count - 2.0) / independent);
                let spread = libm::sqrt((limb.scatter_along_px2 / count).max(1e-6));
                mode(0, sigma);
                mode(1, sigma / spread);
                mode(0, params.limb_floor_px);
                mode(1, params.tilt_floor_px / extent);
                mode(1, limb.moved_px / extent);
                if limb.is_bent() {
                    // A bow of sagitta s leaves the chord by s and its ends by 4 s / extent in slope.
                    mode(0, limb.sagitta_px.abs());
                    mode(1, 4.0 * limb.sagitta_px.abs() / extent);
                }
                common[at] = limb.line.normal().dot(&towards);
            }
        }
        modes.push(common);
        Self { limbs, modes }
    }

    /// Adds a shift of each limb by what may be unseen of it, px.
    pub(crate) fn hide(&mut self, unseen_px: [[f64; 2]; 2]) {
        for (k, sigma) in unseen_px.into_iter().flatten().enumerate() {
            let mut mode = [0.0; PARAMETERS];
            mode[2 * k] = sigma;
            self.modes.push(mode);
        }
    }

    /// Multiplies every standard deviation.
    pub(crate) fn widen(&mut self, factor: f64) {
        for entry in self.modes.iter_mut().flatten() {
            *entry *= factor;
        }
    }

    /// The limbs as fitted.
    pub(crate) fn lines(&self) -> [[ImageLine; 2]; 2] {
        self.moved(&[0.0; PARAMETERS])
    }

    fn moved(&self, by: &Mode) -> [[ImageLine; 2]; 2] {
        let limb = |eye: usize, side: usize| {
            let limb = self.limbs[eye][side];
            let at = 4 * eye + 2 * side;
            let line = ImageLine::new(0.0, limb.line.theta_rad + by[at + 1]);
            // ImageLine::new may turn the normal; the shift is along the limb's own.
            let alike = line.normal().dot(&limb.line.normal()) >= 0.0;
            let shift = if alike { by[at] } else { -by[at] };
            ImageLine {
                rho_px: line.normal().dot(&limb.centroid_px) + shift,
                ..line
            }
        };
        [[limb(0, 0), limb(0, 1)], [limb(1, 0), limb(1, 1)]]
    }

    /// Covariance of any quantities of the limbs by central differences; `None` where they are not defined nearby.
    pub(crate) fn propagate<const N: usize>(
        &self,
        quantities: impl Fn(&[[ImageLine; 2]; 2]) -> Option<[f64; N]>,
    ) -> Option<[[f64; N]; N]> {
        let mut jacobian = [[0.0; PARAMETERS]; N];
        for k in 0..PARAMETERS {
            let step = if k % 2 == 0 {
                SHIFT_STEP_PX
            } else {
                TURN_STEP_RAD
            };
            let at = |step: f64| {
                let mut by = [0.0; PARAMETERS];
                by[k] = step;
                quantities(&self.moved(&by))
            };
            let (after, before) = (at(step)?, at(-step)?);
            for (row, (a, b)) in jacobian.iter_mut().zip(after.iter().zip(&before)) {
                row[k] = (a - b) / (2.0 * step);
            }
        }
        let mut covariance = [[0.0; N]; N];
        for mode in &self.modes {
            let moved = jacobian.map(|row| row.iter().zip(mode).map(|(j, m)| j * m).sum::<f64>());
            for (row, a) in covariance.iter_mut().zip(&moved) {
                for (entry, b) in row.iter_mut().zip(&moved) {
                    *entry += a * b;
                }
            }
        }
        covariance
            .iter()
            .flatten()
            .all(|v| v.is_finite())
            .then_some(covariance)
    }
}

/// The block of a covariance that starts at `at`.
pub(crate) fn block<const N: usize, const M: usize>(
    covariance: &[[f64; N]; N],
    at: usize,
) -> [[f64; M]; M] {
    core::array::from_fn(|i| core::array::from_fn(|j| covariance[at + i][at + j]))
}
