//! The colours by which each limb stands out.

use rodsight_geometry::{Band, MountedCamera};

use super::bands::{INSIDE_PX, Rows, Window, stretches};
use super::light::Light;
use super::noise;
use super::state::State;

/// A few rows are enough for a median.
const WINDOW: Window = Window {
    inside_px: INSIDE_PX,
    blur_px2: 0.0,
    row_step: 4,
    block_step: 1,
};

/// How an eye is looked through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) mounted: MountedCamera,
    /// Of both limbs (plus, minus) the axis of colours along which light steps most over its noise.
    pub(crate) axes: [[f64; 3]; 2],
}

/// Fisher's discriminant of each limb, with channels taken for independent. Behind a port that parts the bands only that of one band is
/// at one place: the band that steps most.
pub(crate) fn view(mounted: &MountedCamera, light: &Light<'_>, rod: &State) -> Option<View> {
    let channels = light.channels();
    let mut found = [[0.0; 3]; 2];
    let mut worth = [0.0; 3];
    let in_band = |channel: usize| {
        if channels == 3 && mounted.disperses() {
            mounted.in_band(Band::ALL[channel])
        } else {
            *mounted
        }
    };
    for channel in 0..channels {
        let mut unit = [0.0; 3];
        unit[channel] = 1.0;
        let mounted = in_band(channel);
        let stretches = stretches(&mounted, light, &[unit; 2], rod, &WINDOW)?;
        for (side, axis) in found.iter_mut().enumerate() {
            let rows = || {
                stretches
                    .iter()
                    .filter_map(|stretch| stretch.limbs[side].as_ref())
            };
            let step = |rows: &Rows| Some(rows.mean(0.7, 3.0)? - rows.mean(-5.0, -1.0)?);
            let mut steps: Vec<f64> = rows().filter_map(step).collect();
            if steps.is_empty() {
                continue;
            }
            let middle = steps.len() / 2;
            let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
            axis[channel] = *median / noise::typical(rows());
            worth[channel] += *median * axis[channel];
        }
    }
    let unit = |axis: [f64; 3]| {
        let length = axis.iter().map(|v| v * v).sum::<f64>().sqrt();
        if length > 0.0 {
            axis.map(|v| v / length)
        } else {
            [1.0, 0.0, 0.0]
        }
    };
    if !mounted.disperses() || channels == 1 {
        return Some(View {
            mounted: *mounted,
            axes: found.map(unit),
        });
    }
    let best = (0..3).max_by(|a, b| worth[*a].total_cmp(&worth[*b]))?;
    let mut axis = [0.0; 3];
    axis[best] = 1.0;
    Some(View {
        mounted: in_band(best),
        axes: [axis; 2],
    })
}
