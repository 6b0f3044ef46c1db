//! A coarse edge followed through the pixels: section by section the place where the light steps.

use rodsight_geometry::{ImageLine, Pixel};

use super::light::Light;
use super::strip::chord;
use super::sums::Edge;

/// Sections of an edge.
const SECTIONS: usize = 32;
/// Places along an edge are so far from each other, px.
const STEP_PX: f64 = 2.0;
/// Of the derivative of a Gaussian that finds a step, px.
const SMOOTH_PX: f64 = 1.5;

/// Follows an edge within some pixels to either side, `polarity` times the light growing along its normal.
pub(crate) fn trace(
    light: &Light<'_>,
    edge: &Edge,
    axis: &[f64; 3],
    polarity: f64,
    reach_px: usize,
) -> Option<Edge> {
    let size = [light.width as f64, light.height as f64];
    let [from, to] = chord(edge, size)?;
    let length_px = (to - from).norm();
    let along = (to - from) / length_px;
    let normal = edge.normal;
    let channels = light.channels();
    let axis = &axis[..channels];
    let offsets = 2 * reach_px + 1;
    let kernel = kernel();
    let mut found: Vec<(f64, f64, f64)> = Vec::with_capacity(SECTIONS);
    for section in 0..SECTIONS {
        let [s0, s1] = [section, section + 1].map(|k| k as f64 * length_px / SECTIONS as f64);
        let steps = (((s1 - s0) / STEP_PX).ceil() as usize).max(1);
        let mut profile = vec![0.0; offsets];
        let mut counts = vec![0.0; offsets];
        for step in 0..steps {
            let s = s0 + (step as f64 + 0.5) * (s1 - s0) / steps as f64;
            let middle = from + along * s;
            for (k, (sum, count)) in profile.iter_mut().zip(&mut counts).enumerate() {
                let at = middle + normal * (k as f64 - reach_px as f64);
                if let Some(value) = bilinear(light, axis, &at) {
                    *sum += value;
                    *count += 1.0;
                }
            }
        }
        if counts.iter().any(|count| *count < 0.5 * steps as f64) {
            continue;
        }
        for (sum, count) in profile.iter_mut().zip(&counts) {
            *sum *= polarity / count;
        }
        let slopes = sloped(&profile, &kernel);
        let Some(peak) = (1..slopes.len() - 1).max_by(|a, b| slopes[*a].total_cmp(&slopes[*b]))
        else {
            continue;
        };
        let [before, here, after] = [slopes[peak - 1], slopes[peak], slopes[peak + 1]];
        let curvature = before - 2.0 * here + after;
        if here <= 0.0 || curvature >= 0.0 {
            continue;
        }
        let place = peak as f64 + 0.5 * (before - after) / curvature;
        let offset_px = place + kernel.len() as f64 / 2.0 - 0.5 - reach_px as f64;
        found.push((0.5 * (s0 + s1), offset_px, here));
    }
    if found.len() < 6 {
        return None;
    }
    let middle = 0.5 * length_px;
    let (mut shift, mut turn) = (0.0, 0.0);
    let mut scale = reach_px as f64;
    for _ in 0..20 {
        let weights: Vec<f64> = found
            .iter()
            .map(|(s, offset, strength)| {
                let off = (offset - shift - turn * (s - middle)) / scale;
                strength / (1.0 + off * off)
            })
            .collect();
        let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
            let terms = found.iter().zip(&weights);
            terms
                .map(|((s, offset, _), w)| w * f(s - middle, *offset))
                .sum()
        };
        let (w, ws, wss) = (sum(&|_, _| 1.0), sum(&|s, _| s), sum(&|s, _| s * s));
        let (wo, wso) = (sum(&|_, o| o), sum(&|s, o| s * o));
        let det = w * wss - ws * ws;
        if !(det > 0.0) {
            return None;
        }
        (shift, turn) = ((wss * wo - ws * wso) / det, (w * wso - ws * wo) / det);
        scale = (0.7 * scale).max(0.5);
    }
    let a = from + normal * (shift - turn * middle);
    let b = to + normal * (shift + turn * middle);
    let line = ImageLine::through(&a, &b);
    let normal = if line.normal().dot(&normal) < 0.0 {
        -line.normal()
    } else {
        line.normal()
    };
    Some(Edge {
        line,
        normal,
        ..*edge
    })
}

fn kernel() -> Vec<f64> {
    let half = (3.0 * SMOOTH_PX).ceil() as i32;
    (-half..=half)
        .map(|k| {
            let x = f64::from(k) / SMOOTH_PX;
            x * libm::exp(-0.5 * x * x)
        })
        .collect()
}

fn sloped(profile: &[f64], kernel: &[f64]) -> Vec<f64> {
    profile
        .windows(kernel.len())
        .map(|window| window.iter().zip(kernel).map(|(a, b)| a * b).sum())
        .collect()
}

fn bilinear(light: &Light<'_>, axis: &[f64], at: &Pixel) -> Option<f64> {
    let (x, y) = (at.x - 0.5, at.y - 0.5);
    if !(x >= 0.0 && y >= 0.0) {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    if column + 1 >= light.width || row + 1 >= light.height {
        return None;
    }
    let (a, b) = (x - column as f64, y - row as f64);
    let value = |dx, dy| light.along(axis, column + dx, row + dy);
    let above = (1.0 - a) * value(0, 0) + a * value(1, 0);
    let below = (1.0 - a) * value(0, 1) + a * value(1, 1);
    Some((1.0 - b) * above + b * below)
}
