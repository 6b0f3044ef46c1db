//! Gate and refit, eqs (4)–(9): points near a coarse line are collected and fitted, lines that coincide become one.

use rodsight_geometry::{ImageLine, LineFit, Pixel, radians};

use crate::paper::{EdgePoint, PaperParams, VotedLine};

/// On which side of a line the rod is: how the mask changes along the line's normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarity {
    /// From background to rod.
    Rising,
    /// From rod to background.
    Falling,
}

impl Polarity {
    /// +1 or −1: the sign of gradient · normal.
    pub fn sign(self) -> f64 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// Less bow than this is no bend, px: pixels and the drift of the threshold along a limb make as much.
const BOW_FLOOR_PX: f64 = 0.4;

/// A line refitted to the edge points of one side of something.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedLine {
    /// The line, in the whole (undistorted) image.
    pub line: ImageLine,
    /// On which side of it the rod is.
    pub polarity: Polarity,
    /// Number of its edge points.
    pub support: usize,
    /// Their mean, px.
    pub centroid_px: Pixel,
    /// Sum of their squared distances to the line, px².
    pub scatter_across_px2: f64,
    /// Sum of their squared distances to the centroid along the line, px².
    pub scatter_along_px2: f64,
    /// Where they begin and end along the line's direction (first and last percent left out), px from the centroid.
    pub along_px: [f64; 2],
    /// How far its ends bow from its middle, px, positive towards the normal.
    pub sagitta_px: f64,
    /// Standard deviation of `sagitta_px`, px.
    pub sagitta_sigma_px: f64,
    /// How far an end moved in this round, px: large means not settled.
    pub moved_px: f64,
    /// Indices of the coarse lines that led here.
    pub sources: Vec<usize>,
}

impl RefinedLine {
    /// Unit normal that points into the rod.
    pub fn inward(&self) -> Pixel {
        self.line.normal() * self.polarity.sign()
    }

    /// Length over which it was seen, px.
    pub fn extent_px(&self) -> f64 {
        self.along_px[1] - self.along_px[0]
    }

    /// First and last point, px.
    pub fn ends_px(&self) -> [Pixel; 2] {
        self.along_px
            .map(|t| self.centroid_px + self.line.direction() * t)
    }

    /// Root mean square distance of its points, px.
    pub fn rms_px(&self) -> f64 {
        (self.scatter_across_px2 / self.support.max(1) as f64).sqrt()
    }

    /// Whether it is bowed more than a straight limb on a stair of pixels.
    pub fn is_bent(&self) -> bool {
        self.sagitta_px.abs() > (3.0 * self.sagitta_sigma_px).max(BOW_FLOOR_PX)
    }

    /// Whether so many points, so dense and so near the line are a limb and not chance.
    pub fn is_limb(&self, params: &PaperParams) -> bool {
        self.support >= params.min_support
            && self.support as f64 >= params.min_coverage * self.extent_px()
            && self.rms_px() <= params.max_rms_px
    }
}

/// A line on its way from one round to the next.
struct Candidate {
    line: ImageLine,
    polarity: Polarity,
    sources: Vec<usize>,
}

/// One list of lines per round, most points first. Each coarse line may give two: one for each side the rod can be on.
/// Points must be those of the undistorted image.
pub fn refine(
    points: &[EdgePoint],
    coarse: &[VotedLine],
    params: &PaperParams,
) -> Vec<Vec<RefinedLine>> {
    let mut candidates: Vec<Candidate> = coarse
        .iter()
        .enumerate()
        .flat_map(|(i, voted)| {
            [Polarity::Rising, Polarity::Falling].map(|polarity| Candidate {
                line: voted.line,
                polarity,
                sources: vec![i],
            })
        })
        .collect();
    let mut rounds: Vec<Vec<RefinedLine>> = Vec::new();
    let mut near = Vec::new();
    for _ in 0..params.refine_iterations {
        let fitted = candidates
            .iter()
            .filter_map(|candidate| refit(points, candidate, params, &mut near))
            .collect();
        let lines = merge(fitted, params);
        candidates = lines
            .iter()
            .map(|line| Candidate {
                line: line.line,
                polarity: line.polarity,
                sources: line.sources.clone(),
            })
            .collect();
        let settled = lines.iter().all(|line| line.moved_px == 0.0);
        rounds.push(lines);
        if settled {
            break;
        }
    }
    rounds
}

fn refit(
    points: &[EdgePoint],
    candidate: &Candidate,
    params: &PaperParams,
    near: &mut Vec<Pixel>,
) -> Option<RefinedLine> {
    collect(points, &candidate.line, candidate.polarity, params, near);
    if near.len() < params.min_support {
        return None;
    }
    let fit = LineFit::of(near)?;
    let old = candidate.line.normal();
    let turned = fit.line.normal().dot(&old) < 0.0;
    let direction = fit.line.direction();
    let mut along: Vec<f64> = near
        .iter()
        .map(|p| (p - fit.centroid_px).dot(&direction))
        .collect();
    let (sagitta_px, sagitta_sigma_px) = sagitta(near, &fit, &along);
    let mut at = |index: usize| *along.select_nth_unstable_by(index, f64::total_cmp).1;
    let cut = near.len() / 100;
    let mut line = RefinedLine {
        line: fit.line,
        polarity: match (candidate.polarity, turned) {
            (Polarity::Rising, false) | (Polarity::Falling, true) => Polarity::Rising,
            (Polarity::Falling, false) | (Polarity::Rising, true) => Polarity::Falling,
        },
        support: near.len(),
        centroid_px: fit.centroid_px,
        scatter_across_px2: fit.scatter_across_px2,
        scatter_along_px2: fit.scatter_along_px2,
        along_px: [at(cut), at(near.len() - 1 - cut)],
        sagitta_px,
        sagitta_sigma_px,
        moved_px: 0.0,
        sources: candidate.sources.clone(),
    };
    line.moved_px = line
        .ends_px()
        .iter()
        .map(|end| candidate.line.distance_px(end).abs())
        .fold(0.0, f64::max);
    Some(line)
}

/// The quadratic that is left beside the line, over the half length, and its standard deviation.
fn sagitta(points: &[Pixel], fit: &LineFit, along: &[f64]) -> (f64, f64) {
    let n = along.len() as f64;
    let half = along.iter().fold(1.0, |most: f64, t| most.max(t.abs()));
    let moment = |k: i32| along.iter().map(|t| (t / half).powi(k)).sum::<f64>() / n;
    let (m2, m3) = (moment(2), moment(3));
    // Orthogonal to a constant and to t over these very points.
    let bow = |t: f64| (t / half) * (t / half) - m2 - m3 / m2 * (t / half);
    let (mut qq, mut qr) = (0.0, 0.0);
    for (point, t) in points.iter().zip(along) {
        let q = bow(*t);
        qq += q * q;
        qr += q * fit.line.distance_px(point);
    }
    if !(qq > 0.0) {
        return (0.0, 0.0);
    }
    // Neighbours on a stair do not err independently: no more of them than px of length.
    let repeats = (n / (2.0 * half)).max(1.0);
    let sigma = libm::sqrt(fit.scatter_across_px2 / n / qq * repeats);
    (qr / qq, sigma)
}

/// The points whose distance (4) is below the threshold and whose gradient points to the rod's side.
fn collect(
    points: &[EdgePoint],
    line: &ImageLine,
    polarity: Polarity,
    params: &PaperParams,
    near: &mut Vec<Pixel>,
) {
    near.clear();
    let normal = line.normal();
    let inward = normal * polarity.sign();
    let cos = libm::cos(radians(params.refine_gradient_tolerance_deg));
    for point in points {
        if (normal.dot(&point.pixel) - line.rho_px).abs() >= params.refine_threshold_px {
            continue;
        }
        let gradient = Pixel::new(f64::from(point.gradient[0]), f64::from(point.gradient[1]));
        let along = gradient.dot(&inward);
        if along > 0.0 && along * along >= cos * cos * gradient.norm_squared() {
            near.push(point.pixel);
        }
    }
}

/// Lines of one side that coincide become the one with most points. Equal lines give equal points, so nothing is lost.
fn merge(mut lines: Vec<RefinedLine>, params: &PaperParams) -> Vec<RefinedLine> {
    // A stable sort: equal supports stay in the order of the coarse lines.
    lines.sort_by_key(|line| core::cmp::Reverse(line.support));
    let mut kept: Vec<RefinedLine> = Vec::new();
    for line in lines {
        let same = kept.iter_mut().find(|other| {
            other.inward().dot(&line.inward()) > 0.0
                && other.line.angle_to(&line.line) <= radians(params.merge_theta_deg)
                && other.line.distance_px(&line.centroid_px).abs() <= params.merge_rho_px
        });
        match same {
            Some(other) => {
                other.sources.extend(line.sources);
                other.sources.sort_unstable();
                other.sources.dedup();
            }
            None => kept.push(line),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edge points every px along a line, rounded to pixel centres; the gradient along `inward · normal`.
    fn edge(line: &ImageLine, centre: &Pixel, half: i32, inward: f64) -> Vec<EdgePoint> {
        let foot = centre - line.normal() * line.distance_px(centre);
        let gradient = line.normal() * (inward * 800.0);
        (-half..=half)
            .map(|t| {
                let p = foot + line.direction() * f64::from(t);
                EdgePoint {
                    pixel: p.map(|x| libm::floor(x) + 0.5),
                    gradient: [gradient.x as i16, gradient.y as i16],
                }
            })
            .collect()
    }

    #[test]
    fn a_bow_is_measured() {
        for (bow, bent) in [(0.0, false), (1.5, true), (-1.5, true)] {
            let points: Vec<Pixel> = (-100..=100)
                .map(f64::from)
                .map(|t| Pixel::new(t, 50.0 + bow * (t / 100.0) * (t / 100.0)))
                .collect();
            let fit = LineFit::of(&points).unwrap();
            let along: Vec<f64> = points
                .iter()
                .map(|p| (p - fit.centroid_px).dot(&fit.line.direction()))
                .collect();
            let (sagitta_px, sigma_px) = sagitta(&points, &fit, &along);
            assert!((sagitta_px.abs() - bow.abs()).abs() < 1e-6, "{sagitta_px}");
            assert_eq!(sagitta_px.abs() > (3.0 * sigma_px).max(BOW_FLOOR_PX), bent);
        }
    }

    fn voted(rho_px: f64, theta_deg: f64) -> VotedLine {
        VotedLine {
            line: ImageLine::new(rho_px, radians(theta_deg)),
            votes: 0,
        }
    }

    #[test]
    fn refine_pulls_coarse_lines_to_one_and_keeps_the_rounds() {
        let truth = ImageLine::new(476.4, radians(-11.2));
        let points = edge(&truth, &Pixel::new(600.0, 600.0), 400, 1.0);
        // The paper's situation: one limb found twice, 2.25° off to either side.
        let foot = Pixel::new(600.0, 600.0)
            - truth.normal() * truth.distance_px(&Pixel::new(600.0, 600.0));
        let through = |theta_deg: f64| {
            let line = ImageLine::new(0.0, radians(theta_deg));
            voted(line.normal().dot(&foot), theta_deg)
        };
        let coarse = [through(-13.5), through(-9.0)];
        let params = PaperParams {
            refine_iterations: 6,
            ..PaperParams::default()
        };
        let rounds = refine(&points, &coarse, &params);
        let last = rounds.last().unwrap();
        assert_eq!(last.len(), 1, "{last:?}");
        assert_eq!(last[0].sources, [0, 1]);
        assert_eq!(last[0].support, points.len());
        assert!(last[0].line.angle_to(&truth) < 2e-4);
        assert!(last[0].line.distance_px(&foot).abs() < 0.1);
        assert!(rounds.len() > 1 && rounds.len() <= 6);
    }

    #[test]
    fn refine_keeps_the_two_sides_of_a_thin_rod_apart() {
        // Two sides 4 px apart, one coarse line in the middle, everything within its 3 px gate.
        let (a, b) = (ImageLine::new(300.0, 0.2), ImageLine::new(304.0, 0.2));
        let centre = Pixel::new(300.0, 200.0);
        let mut points = edge(&a, &centre, 150, 1.0);
        points.extend(edge(&b, &centre, 150, -1.0));
        let rounds = refine(
            &points,
            &[VotedLine {
                line: ImageLine::new(302.0, 0.2),
                votes: 0,
            }],
            &PaperParams::default(),
        );
        let last = rounds.last().unwrap();
        assert_eq!(last.len(), 2, "{last:?}");
        let of = |polarity| {
            last.iter()
                .find(|l| l.polarity == polarity)
                .unwrap()
                .line
                .rho_px
        };
        assert!((of(Polarity::Rising) - 300.0).abs() < 0.2);
        assert!((of(Polarity::Falling) - 304.0).abs() < 0.2);
    }

    #[test]
    fn refine_polarity_follows_the_normal_across_the_wrap() {
        // A line whose fitted θ may fall on either side of ±90°.
        for theta_deg in [89.9, -89.9] {
            let truth = ImageLine::new(
                if theta_deg > 0.0 { 200.0 } else { -200.0 },
                radians(theta_deg),
            );
            let points = edge(&truth, &Pixel::new(300.0, 200.0), 200, 1.0);
            let inward = truth.normal();
            let rounds = refine(&points, &[voted(200.0, 90.0)], &PaperParams::default());
            let line = &rounds.last().unwrap()[0];
            assert!(line.inward().dot(&inward) > 0.99, "{theta_deg} {line:?}");
        }
    }
}
