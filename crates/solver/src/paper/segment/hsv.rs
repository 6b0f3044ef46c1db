//! Hue, saturation and value.

/// Hexagonal HSV.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hsv {
    /// Red 0°, green 120°, blue 240°, in [0, 360); 0 for greys.
    pub hue_deg: f32,
    /// (max − min)/max, in [0, 1].
    pub saturation: f32,
    /// Maximum, in [0, 1] of full scale.
    pub value: f32,
}

impl Hsv {
    /// From R, G, B in [0, 1].
    pub fn of([r, g, b]: [f32; 3]) -> Self {
        let max = r.max(g).max(b);
        let chroma = max - r.min(g).min(b);
        let hue_deg = if chroma <= 0.0 {
            0.0
        } else if max == r {
            60.0 * (g - b) / chroma + if g < b { 360.0 } else { 0.0 }
        } else if max == g {
            60.0 * (b - r) / chroma + 120.0
        } else {
            60.0 * (r - g) / chroma + 240.0
        };
        Self {
            hue_deg,
            saturation: if max > 0.0 { chroma / max } else { 0.0 },
            value: max,
        }
    }
}

/// a − b brought into (−180, 180].
pub(super) fn hue_difference_deg(a: f32, b: f32) -> f32 {
    let d = (a - b).rem_euclid(360.0);
    if d > 180.0 { d - 360.0 } else { d }
}

/// The pure colour of a hue as (R − B, G − B): the ray of the chroma plane on which all colours of that hue lie.
pub(super) fn hue_ray(hue_deg: f64) -> [f32; 2] {
    let h = hue_deg.rem_euclid(360.0) / 60.0;
    let channel = |shift: f64| ((h - shift).rem_euclid(6.0) - 3.0).abs();
    let clamp = |x: f64| x.clamp(0.0, 1.0);
    let r = clamp(channel(0.0) - 1.0);
    let g = clamp(channel(2.0) - 1.0);
    let b = clamp(channel(4.0) - 1.0);
    [(r - b) as f32, (g - b) as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hsv_known_colours() {
        for (rgb, hue) in [
            ([1.0, 0.0, 0.0], 0.0),
            ([1.0, 1.0, 0.0], 60.0),
            ([0.0, 1.0, 0.0], 120.0),
            ([0.0, 1.0, 1.0], 180.0),
            ([0.0, 0.0, 1.0], 240.0),
            ([1.0, 0.0, 1.0], 300.0),
            ([1.0, 0.5, 0.0], 30.0),
        ] {
            let hsv = Hsv::of(rgb);
            assert_eq!((hsv.hue_deg, hsv.saturation, hsv.value), (hue, 1.0, 1.0));
        }
    }

    #[test]
    fn hue_ray_points_along_the_pure_colour() {
        for hue in [0.0, 17.0, 60.0, 100.0, 180.0, 233.0, 300.0, 359.0] {
            let [x, y] = hue_ray(hue);
            // A colour on the ray, made non-negative with a grey.
            let b = (-x).max(-y).max(0.0);
            let found = Hsv::of([x + b, y + b, b]).hue_deg;
            assert!(
                hue_difference_deg(found, hue as f32).abs() < 1e-3,
                "{hue}: {found}"
            );
        }
    }
}
