//! The truth and what was found, drawn on the images.

use rodsight_geometry::{Image, ImageLine, Pixel};
use rodsight_render::{EyeFrame, EyeTruth, srgb_encode};
use rodsight_solver::Roi;

use super::canvas::{Canvas, Colour};
use super::{GREEN, YELLOW};

/// What is drawn on one image.
pub(crate) struct Annotation<'a> {
    pub(crate) image: &'a Image,
    pub(crate) truth: &'a EyeTruth,
    /// Lines that were found, with their colours.
    pub(crate) found: Vec<(ImageLine, Colour)>,
    /// Where the grasp is seen.
    pub(crate) grasp_px: Option<Pixel>,
}

/// The whole image: true limbs yellow, true axis green, found axes in their colours, a cross at the grasp.
pub(crate) fn annotated(annotation: &Annotation<'_>) -> Canvas {
    draw(annotation, Canvas::of_whole_image(annotation.image), 2.0)
}

/// The surroundings of the grasp, magnified.
pub(crate) fn close_up(
    annotation: &Annotation<'_>,
    width_px: u32,
    height_px: u32,
    magnify: u32,
) -> Option<Canvas> {
    let image = annotation.image;
    let centre = annotation.grasp_px?;
    let start = |middle: f64, size: u32, limit: u32| {
        (middle - f64::from(size) / 2.0).clamp(0.0, f64::from(limit.saturating_sub(size))) as u32
    };
    let window = Roi {
        x_px: start(centre.x, width_px, image.width_px()),
        y_px: start(centre.y, height_px, image.height_px()),
        width_px: width_px.min(image.width_px()),
        height_px: height_px.min(image.height_px()),
    };
    Some(draw(
        annotation,
        Canvas::of_image(image, window, magnify),
        1.5,
    ))
}

fn draw(annotation: &Annotation<'_>, mut canvas: Canvas, width_px: f64) -> Canvas {
    let truth = annotation.truth;
    if let Some(lines) = &truth.lines {
        canvas.line(&lines.plus_limb, YELLOW, width_px);
        canvas.line(&lines.minus_limb, YELLOW, width_px);
        canvas.line(&lines.axis, GREEN, width_px);
    }
    if let Some(curves) = &truth.curves {
        for (curve, colour) in [
            (&curves.plus_limb, YELLOW),
            (&curves.minus_limb, YELLOW),
            (&curves.axis, GREEN),
        ] {
            let points: Vec<Pixel> = curve.iter().map(|&point| point.into()).collect();
            canvas.polyline(&points, colour, width_px);
        }
    }
    for (line, colour) in &annotation.found {
        canvas.line(line, *colour, width_px);
    }
    if let Some(grasp_px) = &annotation.grasp_px {
        canvas.cross(grasp_px, 9.0, Colour(255, 255, 255), 2.0);
    }
    canvas
}

/// Depth, instances and the light scattered by the water of one eye; `gains` take radiance to full scale per band.
pub(crate) fn channel_panels(frame: &EyeFrame, gains: [f64; 3]) -> [(&'static str, Canvas); 3] {
    let window = Roi {
        x_px: 0,
        y_px: 0,
        width_px: frame.width_px,
        height_px: frame.height_px,
    };
    let near = frame
        .pixels
        .iter()
        .map(|p| p.depth_m)
        .fold(f32::INFINITY, f32::min);
    let far = frame
        .pixels
        .iter()
        .map(|p| p.depth_m)
        .filter(|d| d.is_finite())
        .fold(near, f32::max)
        .min(near * 6.0);
    let depth = Canvas::of(window, 1, |x, y| {
        let depth_m = frame.at(x, y).depth_m;
        if depth_m.is_finite() {
            viridis(1.0 - f64::from((depth_m - near) / (far - near).max(1e-6)))
        } else {
            Colour(0, 0, 0)
        }
    });
    let instances = Canvas::of(window, 1, |x, y| instance_colour(frame.at(x, y).instance));
    let scattered = Canvas::of(window, 1, |x, y| {
        let light = frame.at(x, y).backscatter;
        let encoded = |k: usize| (srgb_encode(gains[k] * f64::from(light[k])) * 255.0) as u8;
        Colour(encoded(0), encoded(1), encoded(2))
    });
    [
        ("depth", depth),
        ("instances", instances),
        ("light scattered by the water", scattered),
    ]
}

/// Nothing black, the seabed grey, rods in colours that also differ in lightness (Okabe and Ito 2008).
fn instance_colour(instance: u16) -> Colour {
    const RODS: [Colour; 6] = [
        Colour(230, 159, 0),
        Colour(86, 180, 233),
        Colour(0, 158, 115),
        Colour(240, 228, 66),
        Colour(213, 94, 0),
        Colour(204, 121, 167),
    ];
    match instance {
        0 => Colour(0, 0, 0),
        1 => Colour(70, 70, 70),
        rod => RODS[usize::from(rod - 2) % RODS.len()],
    }
}

/// Matplotlib's viridis, by nine of its nodes; 0 dark, 1 light.
fn viridis(value: f64) -> Colour {
    const NODES: [[f64; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    let at = value.clamp(0.0, 1.0) * 8.0;
    let low = (at as usize).min(7);
    let mix =
        |k: usize| (NODES[low][k] + (NODES[low + 1][k] - NODES[low][k]) * (at - low as f64)) as u8;
    Colour(mix(0), mix(1), mix(2))
}
