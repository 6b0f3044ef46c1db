//! What the rod looks like, from the pick or from the picture.

use rodsight_geometry::{Image, Pixel, Samples};

use super::binarise::luminance;
use super::hsv::{Hsv, hue_difference_deg};
use super::{HueSource, Rule, Sample};
use crate::Roi;
use crate::paper::{HueWindow, PaperParams, Refusal, SegmentationMode};

/// Looking at more pixels than this teaches nothing new.
const SAMPLE_LIMIT: usize = 40_000;
/// A hue window that holds so much of the rim is held against luminance.
const CROWDED_RIM: f64 = 0.2;
/// Below this saturation the hue of an 8-bit image is mostly noise.
const COLOURLESS: f32 = 0.06;

/// Chooses the rule by which `image` is binarised. `eye` is only named in messages.
///
/// # Errors
/// Hue was demanded and does not tell rod from background.
pub fn learn(
    image: &Image,
    roi: &Roi,
    pick: Option<&Pixel>,
    params: &PaperParams,
    eye: &'static str,
) -> Result<Rule, Refusal> {
    let colour = image.channels() == 3;
    let refuse = |detail| Refusal::HueNotDistinct { eye, detail };
    match params.segmentation {
        SegmentationMode::Otsu => return Ok(otsu(image, roi, pick, params, None)),
        SegmentationMode::Auto if !colour => return Ok(otsu(image, roi, pick, params, None)),
        SegmentationMode::Hue if !colour => return Err(refuse("the image is grey")),
        SegmentationMode::Auto | SegmentationMode::Hue => {}
    }
    if let Some(window) = params.hue_window {
        let source = HueSource::Given;
        return Ok(Rule::Hue { window, source });
    }
    let rim = hsv_of(image, &rim_pixels(roi, params.learn_rim_px));
    let learned = match pick {
        Some(pick) => {
            let disc = hsv_of(image, &disc_pixels(image, pick, params.learn_radius_px));
            window_of(&disc, &rim, params).map(|window| (window, HueSource::Pick))
        }
        None => picture_window(image, roi, &rim, params).map(|w| (w, HueSource::Picture)),
    };
    match (learned, params.segmentation) {
        (Some((window, source)), SegmentationMode::Auto) => {
            let rule = Rule::Hue { window, source };
            let Some(pick) = pick else { return Ok(rule) };
            let rim = rim_pixels(roi, params.learn_rim_px);
            let disc = disc_pixels(image, pick, params.learn_radius_px);
            // A window that holds much of the rim may still be the best there is.
            let by_hue = separation(image, &rule, &disc, &rim);
            let other = otsu(image, roi, Some(pick), params, None);
            let by_luminance = separation(image, &other, &disc, &rim);
            let crowded = by_hue < 1.0 - CROWDED_RIM && by_luminance > by_hue;
            Ok(if crowded { other } else { rule })
        }
        (Some((window, source)), _) => Ok(Rule::Hue { window, source }),
        (None, SegmentationMode::Auto) => Ok(otsu(image, roi, pick, params, None)),
        (None, _) => Err(refuse("the hues of rod and background overlap")),
    }
}

/// How much more of `rod` than of `background` a rule takes for rod, in [−1, 1].
fn separation(image: &Image, rule: &Rule, rod: &[[u32; 2]], background: &[[u32; 2]]) -> f64 {
    let share = |pixels: &[[u32; 2]]| {
        let inside = match rule {
            Rule::Hue { window, .. } => hsv_of(image, pixels)
                .iter()
                .filter(|p| window_holds(window, p))
                .count(),
            Rule::Luminance {
                threshold,
                rod_is_bright,
            } => luminance_of(image, pixels)
                .iter()
                .filter(|v| (f64::from(**v) > *threshold) == *rod_is_bright)
                .count(),
        };
        inside as f64 / pixels.len().max(1) as f64
    };
    share(rod) - share(background)
}

/// The rule for the other eye: the same hues; for luminance its own threshold but the same side of it.
pub(crate) fn for_other_eye(rule: &Rule, image: &Image, roi: &Roi, params: &PaperParams) -> Rule {
    match rule {
        Rule::Hue { .. } if image.channels() == 3 => *rule,
        Rule::Hue { .. } => otsu(image, roi, None, params, None),
        Rule::Luminance { rod_is_bright, .. } => {
            otsu(image, roi, None, params, Some(*rod_is_bright))
        }
    }
}

/// The window around the hue of `rod` that keeps off the hue of `background`; `None` if it would not keep off.
fn window_of(rod: &[Hsv], background: &[Hsv], params: &PaperParams) -> Option<HueWindow> {
    let coloured = |pixels: &[Hsv]| -> Vec<Hsv> {
        let keep = |p: &&Hsv| p.saturation >= COLOURLESS && p.value > 0.0;
        pixels.iter().filter(keep).copied().collect()
    };
    let rod_coloured = coloured(rod);
    if rod_coloured.is_empty() || 2 * rod_coloured.len() < rod.len() {
        return None;
    }
    let (hue, _) = hue_centre(&rod_coloured)?;
    let saturation = median(rod_coloured.iter().map(|p| p.saturation))?;
    let value = median(rod_coloured.iter().map(|p| p.value))?;

    // The rod itself crosses the rim: its own hue is no background.
    let far: Vec<Hsv> = background
        .iter()
        .filter(|p| {
            hue_difference_deg(p.hue_deg, hue).abs() > 10.0 || p.saturation < 0.5 * saturation
        })
        .copied()
        .collect();
    let (least, most) = (
        params.hue_half_width_min_deg as f32,
        params.hue_half_width_max_deg as f32,
    );
    let (mut below, mut above) = (most, most);
    let mut min_saturation = 0.25 * saturation;
    let far_coloured = coloured(&far);
    let background_saturation = median(far.iter().map(|p| p.saturation)).unwrap_or(0.0);
    match hue_centre(&far_coloured) {
        Some((other, spread)) if 2 * far_coloured.len() > far.len() && spread < 30.0 => {
            // Half way to the background on the side where it is nearer; the other way round is further.
            let gap = hue_difference_deg(other, hue);
            let towards = (0.5 * gap.abs()).clamp(least, most);
            let away = (0.5 * (360.0 - gap.abs())).clamp(least, most);
            (below, above) = if gap > 0.0 {
                (away, towards)
            } else {
                (towards, away)
            };
            if gap.abs() < 2.0 * least {
                min_saturation = min_saturation.max(0.5 * (saturation + background_saturation));
            }
        }
        // A colourless background has every hue: only saturation keeps it off.
        _ => min_saturation = min_saturation.max(0.5 * (saturation + background_saturation)),
    }
    let window = HueWindow {
        from_deg: f64::from((hue - below).rem_euclid(360.0)),
        to_deg: f64::from((hue + above).rem_euclid(360.0)),
        min_saturation: f64::from(min_saturation.max(COLOURLESS.min(0.5 * saturation))),
        min_value: f64::from(0.15 * value),
    };
    let share = |pixels: &[Hsv]| {
        let inside = pixels.iter().filter(|p| window_holds(&window, p)).count();
        inside as f64 / pixels.len().max(1) as f64
    };
    (share(rod) > 0.5 && share(background) < 0.5).then_some(window)
}

/// Without a pick: the hue that has most chroma, away from the rim's hue, is taken for the rod's.
fn picture_window(
    image: &Image,
    roi: &Roi,
    rim: &[Hsv],
    params: &PaperParams,
) -> Option<HueWindow> {
    const BINS: usize = 72;
    let all = hsv_of(image, &grid_pixels(roi));
    let bin = |p: &Hsv| ((p.hue_deg / 5.0) as usize).min(BINS - 1);
    let histogram = |pixels: &[Hsv]| {
        let mut bins = [0.0_f32; BINS];
        for p in pixels.iter().filter(|p| p.saturation >= COLOURLESS) {
            bins[bin(p)] += p.saturation * p.value;
        }
        let raw = bins;
        for (i, b) in bins.iter_mut().enumerate() {
            *b = raw[(i + BINS - 1) % BINS] + 2.0 * raw[i] + raw[(i + 1) % BINS];
        }
        bins
    };
    let rim_coloured: Vec<Hsv> = rim
        .iter()
        .filter(|p| p.saturation >= COLOURLESS)
        .copied()
        .collect();
    // Only a rim that has a colour of its own rules hues out.
    let rim_hue = hue_centre(&rim_coloured)
        .filter(|(_, spread)| 2 * rim_coloured.len() > rim.len() && *spread < 30.0)
        .map(|(hue, _)| hue);
    let bins = histogram(&all);
    let mut best: Option<usize> = None;
    for i in 0..BINS {
        let centre = (i as f32 + 0.5) * 5.0;
        let off_rim = rim_hue.is_none_or(|hue| hue_difference_deg(centre, hue).abs() > 30.0);
        if off_rim && bins[i] > best.map_or(0.0, |b| bins[b]) {
            best = Some(i);
        }
    }
    let hue = (best? as f32 + 0.5) * 5.0;
    let rod: Vec<Hsv> = all
        .iter()
        .filter(|p| p.saturation >= COLOURLESS && hue_difference_deg(p.hue_deg, hue).abs() < 12.0)
        .copied()
        .collect();
    // A thousandth of the region at least: less is noise or snow.
    if rod.len() * 1000 < all.len() {
        return None;
    }
    let most = quantile(rod.iter().map(|p| p.saturation * p.value), 0.9)?;
    let bright: Vec<Hsv> = rod
        .iter()
        .filter(|p| p.saturation * p.value >= 0.5 * most)
        .copied()
        .collect();
    window_of(&bright, rim, params)
}

fn window_holds(window: &HueWindow, p: &Hsv) -> bool {
    let width = (window.to_deg - window.from_deg).rem_euclid(360.0);
    (f64::from(p.hue_deg) - window.from_deg).rem_euclid(360.0) <= width
        && f64::from(p.saturation) >= window.min_saturation
        && p.saturation > 0.0
        && f64::from(p.value) >= window.min_value
}

/// Median hue and its robust spread (1.4826 times the median deviation), degrees; taken around the fullest 30° so that a
/// minority of another colour does not pull it.
fn hue_centre(pixels: &[Hsv]) -> Option<(f32, f32)> {
    let mut bins = [0_usize; 36];
    for p in pixels {
        bins[((p.hue_deg / 10.0) as usize).min(35)] += 1;
    }
    let around = |i: usize| bins[(i + 35) % 36] + bins[i] + bins[(i + 1) % 36];
    let fullest = (0..36).max_by_key(|&i| around(i))?;
    let mode = fullest as f32 * 10.0 + 5.0;
    let shift = median(pixels.iter().map(|p| hue_difference_deg(p.hue_deg, mode)))?;
    let centre = (mode + shift).rem_euclid(360.0);
    let spread = median(
        pixels
            .iter()
            .map(|p| hue_difference_deg(p.hue_deg, centre).abs()),
    )?;
    Some((centre, 1.4826 * spread))
}

fn median(values: impl Iterator<Item = f32>) -> Option<f32> {
    quantile(values, 0.5)
}

fn quantile(values: impl Iterator<Item = f32>, at: f64) -> Option<f32> {
    let mut values: Vec<f32> = values.collect();
    if values.is_empty() {
        return None;
    }
    let index = ((values.len() - 1) as f64 * at) as usize;
    Some(*values.select_nth_unstable_by(index, f32::total_cmp).1)
}

/// Otsu's threshold on luminance. Which side is rod: as given, else where the pick is, else the side with less of the rim.
fn otsu(
    image: &Image,
    roi: &Roi,
    pick: Option<&Pixel>,
    params: &PaperParams,
    rod_is_bright: Option<bool>,
) -> Rule {
    let values = luminance_of(image, &grid_pixels(roi));
    let (low, high) = values
        .iter()
        .fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let threshold = otsu_threshold(&values, low, high);
    let is_bright = rod_is_bright.unwrap_or_else(|| {
        let share = |pixels: &[[u32; 2]]| {
            let values = luminance_of(image, pixels);
            let above = values.iter().filter(|v| **v > threshold).count();
            2 * above > values.len()
        };
        match pick {
            Some(pick) => share(&disc_pixels(image, pick, params.learn_radius_px)),
            None => !share(&rim_pixels(roi, params.learn_rim_px)),
        }
    });
    Rule::Luminance {
        threshold: f64::from(threshold),
        rod_is_bright: is_bright,
    }
}

/// Maximises the variance between the classes over 256 bins between the extremes (Otsu 1979).
fn otsu_threshold(values: &[f32], low: f32, high: f32) -> f32 {
    let step = (high - low) / 256.0;
    if !(step > 0.0) {
        return high;
    }
    let mut bins = [0_u32; 256];
    for v in values {
        bins[(((v - low) / step) as usize).min(255)] += 1;
    }
    let total: f64 = values.len() as f64;
    let sum: f64 = (0_u32..)
        .zip(&bins)
        .map(|(i, n)| f64::from(i) * f64::from(*n))
        .sum();
    let (mut below, mut sum_below, mut best, mut first, mut last) = (0.0, 0.0, -1.0, 0, 0);
    for (i, n) in (0_u32..).zip(&bins) {
        below += f64::from(*n);
        sum_below += f64::from(i) * f64::from(*n);
        if below == 0.0 || below == total {
            continue;
        }
        let between = (sum_below * total - sum * below) * (sum_below * total - sum * below)
            / (below * (total - below));
        // Between two well separated classes the variance is flat: take the middle of the plateau.
        if between > best * (1.0 + 1e-12) {
            (best, first, last) = (between, i, i);
        } else if between >= best * (1.0 - 1e-12) {
            last = i;
        }
    }
    low + step * (0.5 * (first + last) as f32 + 1.0)
}

/// A regular sample of the region.
fn grid_pixels(roi: &Roi) -> Vec<[u32; 2]> {
    let mut stride = 1;
    while roi.area_px() / (stride * stride) > SAMPLE_LIMIT {
        stride += 1;
    }
    let along = |start: u32, length: u32| (start..start + length).step_by(stride);
    along(roi.y_px, roi.height_px)
        .flat_map(|y| along(roi.x_px, roi.width_px).map(move |x| [x, y]))
        .collect()
}

/// The border of the region.
fn rim_pixels(roi: &Roi, rim_px: u32) -> Vec<[u32; 2]> {
    let rim = rim_px.min(roi.width_px / 2).min(roi.height_px / 2).max(1);
    let (right, bottom) = (roi.x_px + roi.width_px, roi.y_px + roi.height_px);
    let mut pixels = Vec::new();
    for y in roi.y_px..bottom {
        let across = if y < roi.y_px + rim || y + rim >= bottom {
            [roi.x_px..right, right..right]
        } else {
            [roi.x_px..roi.x_px + rim, right - rim..right]
        };
        pixels.extend(across.into_iter().flatten().map(|x| [x, y]));
    }
    let stride = pixels.len().div_ceil(SAMPLE_LIMIT).max(1);
    pixels.into_iter().step_by(stride).collect()
}

/// The pixels whose centres lie in a disc, at least the one that holds its centre.
fn disc_pixels(image: &Image, centre: &Pixel, radius_px: f64) -> Vec<[u32; 2]> {
    let range = |c: f64, size: u32| {
        let clamp = |v: f64| v.clamp(0.0, f64::from(size) - 1.0) as u32;
        clamp(c - radius_px)..=clamp(c + radius_px)
    };
    let mut pixels = Vec::new();
    for y in range(centre.y, image.height_px()) {
        for x in range(centre.x, image.width_px()) {
            let at = Pixel::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            if (at - centre).norm() <= radius_px.max(0.75) {
                pixels.push([x, y]);
            }
        }
    }
    pixels
}

fn hsv_of(image: &Image, pixels: &[[u32; 2]]) -> Vec<Hsv> {
    fn each<T: Sample>(image: &Image, samples: &[T], pixels: &[[u32; 2]]) -> Vec<Hsv> {
        let width = image.width_px() as usize;
        let at = |[x, y]: &[u32; 2]| {
            let i = 3 * (*y as usize * width + *x as usize);
            Hsv::of([0, 1, 2].map(|c| samples[i + c].into() / T::FULL))
        };
        pixels.iter().map(at).collect()
    }
    match image.samples() {
        Samples::U8(samples) => each(image, samples, pixels),
        Samples::U16(samples) => each(image, samples, pixels),
    }
}

fn luminance_of(image: &Image, pixels: &[[u32; 2]]) -> Vec<f32> {
    fn each<T: Sample>(image: &Image, samples: &[T], pixels: &[[u32; 2]]) -> Vec<f32> {
        let (width, channels) = (image.width_px() as usize, image.channels() as usize);
        let at = |[x, y]: &[u32; 2]| {
            let i = channels * (*y as usize * width + *x as usize);
            luminance(&samples[i..i + channels]) / T::FULL
        };
        pixels.iter().map(at).collect()
    }
    match image.samples() {
        Samples::U8(samples) => each(image, samples, pixels),
        Samples::U16(samples) => each(image, samples, pixels),
    }
}
