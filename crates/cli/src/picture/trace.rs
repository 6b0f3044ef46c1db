//! The paper's figure 6: edges, lines by Hough, lines refined once, lines refined to the end.

use std::path::Path;

use rodsight_geometry::{Eye, Pixel};
use rodsight_solver::{EyeTrace, RefinedLine, Trace};

use super::canvas::{Canvas, Colour};
use super::{CYAN, GREEN, MAGENTA};
use crate::failure::Failure;

const DIM: Colour = Colour(38, 66, 78);
const EDGE: Colour = Colour(235, 235, 235);

/// The four panels of one eye, each with the name its file gets and its caption.
pub(crate) fn figure6(trace: &EyeTrace) -> [(&'static str, &'static str, Canvas); 4] {
    let edges = edge_picture(trace);
    let mut coarse = edges.clone();
    // Hough gives many lines; those that a refined line came from stand out.
    let used = |index: usize| {
        let mut first_round = trace.refined.first().into_iter().flatten();
        first_round.any(|line| line.sources.contains(&index))
    };
    let (bright, dim): (Vec<_>, Vec<_>) = trace
        .coarse
        .iter()
        .enumerate()
        .partition(|(index, _)| used(*index));
    for (lines, colour, width_px) in [(dim, DIM, 0.7), (bright, CYAN, 1.5)] {
        for (_, voted) in lines {
            coarse.line(&voted.line, colour, width_px);
        }
    }
    let refined = |round: Option<&Vec<RefinedLine>>, with_axis: bool| {
        let mut picture = edges.clone();
        for line in round.into_iter().flatten() {
            picture.line(&line.line, MAGENTA, 1.5);
        }
        if let (true, Some(axis)) = (with_axis, &trace.centerline) {
            picture.line(axis, GREEN, 1.5);
        }
        picture
    };
    let once = refined(trace.refined.first(), false);
    let last = refined(trace.refined.last(), true);
    [
        ("a-edges", "(a) edges", edges),
        (
            "b-hough",
            "(b) lines by Hough; those that were refined bright",
            coarse,
        ),
        ("c-refined-once", "(c) refined once", once),
        (
            "d-refined",
            "(d) refined to the end, and the centre line",
            last,
        ),
    ]
}

fn edge_picture(trace: &EyeTrace) -> Canvas {
    let roi = trace.roi;
    let is_rod = |x: u32, y: u32| {
        let index = (y - roi.y_px) as usize * roi.width_px as usize + (x - roi.x_px) as usize;
        trace.mask.get(index).is_some_and(|&value| value > 0)
    };
    let mut picture = Canvas::of(roi, 1, |x, y| {
        if is_rod(x, y) {
            Colour(58, 44, 18)
        } else {
            Colour(12, 16, 22)
        }
    });
    for edge in &trace.edges {
        let half = Pixel::new(0.5, 0.0);
        picture.polyline(&[edge.pixel - half, edge.pixel + half], EDGE, 1.0);
    }
    picture
}

/// Writes the panels of both eyes, `left-a-edges.png` and so on.
pub(crate) fn write_trace(folder: &Path, trace: &Trace) -> Result<(), Failure> {
    for (eye, eye_trace) in [(Eye::Left, &trace.left), (Eye::Right, &trace.right)] {
        for (name, _, picture) in figure6(eye_trace) {
            picture.write(&folder.join(format!("{}-{name}.png", eye.name())))?;
        }
    }
    Ok(())
}
