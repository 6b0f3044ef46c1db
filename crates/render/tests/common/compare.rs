//! Two renders of one scene: light, depth and ids, pixel by pixel.

use rodsight_geometry::Eye;
use rodsight_render::{EyeFrame, Frame, PixelTruth};
use rodsight_scene::EdgeSampling;
use rodsight_testkit::{Tolerance, compare_images};

/// Away from edges, all but one pixel in a thousand. Both sum the same terms, and `f32` keeps seven digits of each.
const MOST: Tolerance = Tolerance {
    max_rel: 2e-3,
    max_abs: 0.0,
    bad_fraction: 1e-3,
    bounded_by: "f32 against f64; shadows' ends are found to 1e-5",
};
/// The same, all but those that a shadow's edge crosses: a sample of such a pixel may fall on the other side.
const ALL: Tolerance = Tolerance {
    max_rel: 1e-2,
    bad_fraction: 1e-4,
    ..MOST
};
/// Beside limbs the depth is that of a ray which barely touches: a rounding error of the gap is a hundred of the depth.
const DEPTH: Tolerance = Tolerance {
    max_rel: 1e-5,
    max_abs: 0.0,
    bad_fraction: 2e-3,
    bounded_by: "f32; rays that graze a limb, and floors seen at grazing angles",
};
/// Ids differ only where a limb passes through the middle of a pixel within rounding.
const IDS_DIFFER: f64 = 1e-4;
/// Samples of a pixel at an edge that may fall on the other side of it.
const SAMPLES_DIFFER: f32 = 2.0;

/// Samples of a pixel at an outline, and where only the light changes.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    pub outline: f32,
    pub inner: f32,
}

/// Enough to compare, few enough for the reference in a test.
pub const SAMPLING: EdgeSampling = EdgeSampling::Fibonacci { points: 55 };
pub const SAMPLES: Samples = Samples {
    outline: 55.0,
    inner: 13.0,
};

/// Numbers of light of a pixel.
const LIGHT: usize = 18;

/// What of a pixel is compared, light first, scaled by nothing.
fn light(p: &PixelTruth) -> [f32; LIGHT] {
    let mut all = [0.0; LIGHT];
    let channels = [
        p.radiance,
        p.direct,
        p.forward,
        p.backscatter,
        p.clean,
        p.snow,
    ];
    for (three, value) in all.chunks_exact_mut(3).zip(channels) {
        three.copy_from_slice(&value);
    }
    all
}

/// Pixels that see more than one thing, or the same one at another depth, within so many pixels, and so are means over samples, by the
/// reference's own ids.
pub fn at_edges(frame: &EyeFrame, reach: u32) -> Vec<bool> {
    let (width, height) = (frame.width_px, frame.height_px);
    (0..height)
        .flat_map(|row| (0..width).map(move |column| (row, column)))
        .map(|(row, column)| {
            let here = frame.at(column, row);
            let rows = row.saturating_sub(reach)..(row + reach + 1).min(height);
            rows.flat_map(|r| {
                let columns = column.saturating_sub(reach)..(column + reach + 1).min(width);
                columns.map(move |c| frame.at(c, r))
            })
            .any(|there| {
                there.instance != here.instance
                    || (here.instance >= 2
                        && (there.range_m - here.range_m).abs() > 0.02 * here.range_m)
            })
        })
        .collect()
}

/// How an image differs from the reference's; what it says when it does not.
fn compare_eye(
    actual: &EyeFrame,
    reference: &EyeFrame,
    samples: Samples,
) -> Result<String, String> {
    let shape = [reference.height_px as usize, reference.width_px as usize];
    let pixels = shape[0] * shape[1];
    if pixels == 0 || reference.pixels.len() != pixels {
        return Err("no reference".to_owned());
    }
    if actual.pixels.len() != pixels {
        return Err(format!(
            "{} pixels instead of {pixels}",
            actual.pixels.len()
        ));
    }
    let ids = actual.pixels.iter().zip(&reference.pixels);
    let ids = ids
        .filter(|(a, r)| a.instance != r.instance || a.material != r.material)
        .count();
    if ids as f64 > (IDS_DIFFER * pixels as f64).max(4.0) {
        return Err(format!("{ids} of {pixels} ids differ"));
    }
    let (edges, outlines) = (at_edges(reference, 2), at_edges(reference, 1));
    // Light away from edges: what is at an edge is taken from the reference here, and looked at below.
    let planes =
        |of: &dyn Fn(usize) -> Vec<f32>| -> Vec<f32> { (0..pixels).flat_map(of).collect() };
    let inside = |frame: &EyeFrame| {
        planes(&|i| {
            let from = if edges[i] { reference } else { frame };
            light(&from.pixels[i]).to_vec()
        })
    };
    let (a, r) = (inside(actual), inside(reference));
    let mut report = String::new();
    // A hundred-thousandth of the brightest value is below a digit of 16 bits.
    let digit = 1e-5 * f64::from(r.iter().copied().fold(0.0, f32::max));
    for tolerance in [MOST, ALL].map(|t| Tolerance {
        max_abs: digit,
        ..t
    }) {
        let found = compare_images(&a, &r, [shape[0], shape[1], LIGHT], tolerance);
        report = format!(
            "light {:.1e}",
            found.map_err(|e| format!("light: {e}"))?.worst_rel
        );
    }
    let depth = |frame: &EyeFrame| {
        planes(&|i| {
            let (here, there) = (&frame.pixels[i], &reference.pixels[i]);
            let same = here.instance == there.instance && there.instance != 0;
            if same {
                vec![here.depth_m, here.range_m]
            } else {
                vec![1.0; 2]
            }
        })
    };
    let found = compare_images(
        &depth(actual),
        &depth(reference),
        [shape[0], shape[1], 2],
        DEPTH,
    );
    let found = found.map_err(|e| format!("depth: {e}"))?;
    // Anywhere: two samples of a pixel may see the other side of an edge. Of a few pixels at outlines one backend alone may have seen
    // that there is one.
    let (mut worst, mut unseen) = (0.0_f32, 0);
    for (i, is_outline) in outlines.into_iter().enumerate() {
        let (row, column) = ((i / shape[1]) as u32, (i % shape[1]) as u32);
        let (a, r) = (light(&actual.pixels[i]), light(&reference.pixels[i]));
        let around = (row.saturating_sub(1)..(row + 2).min(reference.height_px)).flat_map(|r| {
            let columns = column.saturating_sub(1)..(column + 2).min(reference.width_px);
            columns.map(move |c| light(reference.at(c, r)))
        });
        let brightest = around.fold([0.0_f32; LIGHT], |most, v| {
            core::array::from_fn(|k| most[k].max(v[k]))
        });
        // Of all samples, how many the difference is.
        let differ = |k: usize| {
            let off = (a[k] - r[k]).abs() - 2e-3 * r[k] - digit as f32;
            off / (brightest[k] / samples.outline).max(f32::MIN_POSITIVE)
        };
        let most = SAMPLES_DIFFER * samples.outline / samples.inner;
        // `!(…)` refuses NaN.
        if let Some(k) = (0..LIGHT).find(|&k| !(differ(k) <= most)) {
            return Err(format!(
                "column {column}, row {row}, channel {k}: {} instead of {}",
                a[k], r[k]
            ));
        }
        let here = (0..LIGHT).map(differ).fold(0.0, f32::max);
        unseen += usize::from(is_outline && here > SAMPLES_DIFFER);
        worst = worst.max(here);
    }
    if unseen as f64 > (IDS_DIFFER * pixels as f64).max(4.0) {
        return Err(format!(
            "{unseen} of {pixels} pixels at outlines differ by more than {SAMPLES_DIFFER} samples"
        ));
    }
    let edges = edges.iter().filter(|edge| **edge).count();
    Ok(format!(
        "{report}, depth {:.1e} ({} pixels beyond 1e-5), {ids} ids, {edges} pixels at edges, where {worst:.2} samples differ",
        found.worst_rel, found.bad_pixels
    ))
}

pub fn compare(actual: &Frame, reference: &Frame, samples: Samples) -> Result<String, String> {
    Eye::BOTH
        .iter()
        .map(|&eye| {
            let report = compare_eye(actual.eye(eye), reference.eye(eye), samples);
            report.map_err(|e| format!("{}: {e}", eye.name()))
        })
        .collect::<Result<Vec<_>, _>>()
        .map(|both| both.join("\n  "))
}
