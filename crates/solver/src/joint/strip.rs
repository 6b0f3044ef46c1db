//! Pairs of edges that may be the two limbs of a rod.

use rodsight_geometry::Pixel;

use super::light::Binned;
use super::sums::{Edge, dot};

/// Two edges of opposite polarity with something between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strip {
    pub(crate) edges: [Edge; 2],
    pub(crate) score: f32,
    /// Where the middle line is nearest to the middle of the region, or to the pick, px of the region.
    pub(crate) middle_px: Pixel,
    pub(crate) width_px: f64,
}

impl Strip {
    /// Whether a place of the region lies between the edges.
    pub(crate) fn holds(&self, pixel: &Pixel) -> bool {
        let [a, b] = self.edges.map(|edge| edge.line.distance_px(pixel));
        let [at_a, at_b] = self
            .edges
            .map(|edge| edge.line.distance_px(&self.middle_px));
        a * at_a > 0.0 && b * at_b > 0.0
    }
}

/// The limbs of a rod converge by no more than this.
const MOST_TAPER_RAD: f64 = 0.35;
/// Of the many pairs that noise makes none is stronger.
const LEAST_SCORE: f32 = 5.5;
/// Of steps that are not opposite.
const LEAST_LIKENESS: f32 = 0.1;
/// Nearer than this the two are one edge.
const LEAST_WIDTH: f64 = 1.2;

/// The chord of a line in a region: where it enters and leaves.
pub(crate) fn chord(edge: &Edge, size: [f64; 2]) -> Option<[Pixel; 2]> {
    let normal = edge.normal;
    let along = Pixel::new(-normal.y, normal.x);
    let rho = if edge.line.normal().dot(&normal) < 0.0 {
        -edge.line.rho_px
    } else {
        edge.line.rho_px
    };
    let foot = normal * rho;
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..2 {
        if along[axis] == 0.0 {
            if !(0.0..=size[axis]).contains(&foot[axis]) {
                return None;
            }
            continue;
        }
        let (a, b) = (
            -foot[axis] / along[axis],
            (size[axis] - foot[axis]) / along[axis],
        );
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from < to).then(|| [foot + along * from, foot + along * to])
}

/// The likeliest strips, at most so many, likeliest first; with a pick only those around it.
pub(crate) fn strips(
    edges: &[Edge],
    binned: &Binned,
    pick: Option<&Pixel>,
    most: usize,
) -> Vec<Strip> {
    let mut found = Vec::new();
    let factor = binned.factor;
    let size = [binned.width, binned.height].map(|pixels| (pixels * factor) as f64);
    let factor = factor as f64;
    for (i, a) in edges.iter().enumerate() {
        for b in &edges[i + 1..] {
            let turned = if a.normal.dot(&b.normal) < 0.0 {
                -1.0
            } else {
                1.0
            };
            let taper = a.line.angle_to(&b.line);
            if taper > MOST_TAPER_RAD {
                continue;
            }
            // A rod lit from one side may be brighter than what is behind it there and darker on the other side.
            let likeness = -turned as f32 * dot(&a.step, &b.step) / (a.score * b.score);
            let likeness = likeness.max(LEAST_LIKENESS);
            let Some([from, to]) = chord(a, size) else {
                continue;
            };
            let normal = a.normal;
            let rho_b = if b.line.normal().dot(&normal) < 0.0 {
                -b.line.rho_px
            } else {
                b.line.rho_px
            };
            let normal_b = b.normal * turned;
            // How far the other edge is at both ends of this one, along this one's normal.
            let gap = |at: &Pixel| (rho_b - normal_b.dot(at)) / normal_b.dot(&normal);
            let (g0, g1) = (gap(&from), gap(&to));
            if g0 * g1 <= 0.0 {
                continue;
            }
            let width_px = 0.5 * (g0 + g1).abs();
            if width_px < LEAST_WIDTH * factor {
                continue;
            }
            let middle = (from + to) * 0.5;
            let middle_px = match pick {
                None => middle + normal * (0.5 * gap(&middle)),
                Some(pick) => {
                    let to_a = pick - from;
                    let off_a = normal.dot(&to_a);
                    let on_a = pick - normal * off_a;
                    let width = gap(&on_a);
                    let margin = 0.1 * width.abs() + 1.5 * factor;
                    let share = off_a * width.signum();
                    if share < -margin || share > width.abs() + margin {
                        continue;
                    }
                    on_a + normal * (0.5 * width)
                }
            };
            let mut score = likeness.sqrt() * (a.score * b.score).sqrt();
            if let Some(pick) = pick {
                let inwards = [gap(&from).signum(), -gap(&from).signum() * turned];
                for (edge, inwards) in [a, b].into_iter().zip(inwards) {
                    score *= belonging(binned, edge, inwards, pick);
                }
            }
            if score < LEAST_SCORE {
                continue;
            }
            found.push(Strip {
                edges: [*a, *b],
                score,
                middle_px,
                width_px,
            });
        }
    }
    found.sort_by(|a: &Strip, b: &Strip| b.score.total_cmp(&a.score));
    found.truncate(most);
    found
}

/// Whether what was pointed at looks as what an edge has on its inner side rather than on its outer one, in [0, 1].
fn belonging(binned: &Binned, edge: &Edge, inwards: f64, pick: &Pixel) -> f32 {
    let factor = binned.factor as f64;
    let normal = edge.normal * inwards;
    let rho = if edge.line.normal().dot(&edge.normal) < 0.0 {
        -edge.line.rho_px
    } else {
        edge.line.rho_px
    };
    let foot = pick + edge.normal * (rho - edge.normal.dot(pick));
    let along = Pixel::new(-edge.normal.y, edge.normal.x);
    let mean = |middle: &Pixel, across: [f64; 2], reach: i32| {
        let (mut sums, mut count) = ([0.0_f32; 3], 0.0_f32);
        for k in -reach..=reach {
            for off in across {
                let at =
                    (middle + along * (f64::from(k) * factor) + normal * (off * factor)) / factor;
                let (x, y) = (at.x.floor(), at.y.floor());
                let is_inside =
                    x >= 0.0 && y >= 0.0 && x < binned.width as f64 && y < binned.height as f64;
                if is_inside {
                    let place = y as usize * binned.width + x as usize;
                    for (sum, plane) in sums.iter_mut().zip(&binned.planes) {
                        *sum += plane[place];
                    }
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then(|| sums.map(|sum| sum / count))
    };
    let (Some(picked), Some(inside), Some(outside)) = (
        mean(pick, [-0.5, 0.5], 1),
        mean(&foot, [1.2, 2.2], 4),
        mean(&foot, [-1.7, -2.7], 4),
    ) else {
        return 1.0;
    };
    // By the colour more than by the light, which the rod's roundness changes.
    let colour = |[r, g, b]: [f32; 3]| {
        let sum = (r + g + b).max(1e-4);
        [r / sum, g / sum, b / sum, 0.3 * sum]
    };
    let apart = |a: [f32; 3], b: [f32; 3]| {
        let (a, b) = (colour(a), colour(b));
        let squares = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f32>().sqrt()
    };
    let (near, far) = (apart(picked, inside), apart(picked, outside));
    let share = far / (near + far).max(1e-6);
    // Half and half says nothing.
    (2.0 * share).min(1.0) * share.max(0.1)
}
