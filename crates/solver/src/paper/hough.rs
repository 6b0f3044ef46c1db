//! The Hough transform, eqs (1)–(3), with unbiased cells.

use core::f64::consts::PI;

use rodsight_geometry::{ImageLine, Pixel};

use crate::paper::{PaperParams, VoteThreshold};

/// The accumulator. Cell (i, j) stands for the line of angle `i Δθ` at distance `(j − half) Δρ` from `centre_px`.
#[derive(Clone, Debug, PartialEq)]
pub struct Votes {
    /// Number of angles over [0, π).
    pub theta_count: usize,
    /// Number of distances: odd, the middle one is ρ = 0.
    pub rho_count: usize,
    /// Δθ, rad.
    pub theta_step_rad: f64,
    /// Δρ, px.
    pub rho_step_px: f64,
    /// Where ρ is measured from: the centre of the region, so that ρ and θ errors do not mix.
    pub centre_px: Pixel,
    /// Votes, shape `[theta_count, rho_count]`.
    pub counts: Vec<u32>,
}

/// A cell that is a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VotedLine {
    /// Its centre, in the whole (undistorted) image.
    pub line: ImageLine,
    /// How many points voted for it.
    pub votes: u32,
}

impl Votes {
    /// The line at the centre of a cell. `OpenCV` 4 reports a line half a cell off when the number of distances is even
    /// (opencv/opencv#25038); the paper's tables carry that 1.25 px.
    pub fn line(&self, theta_index: usize, rho_index: usize) -> ImageLine {
        let (sin, cos) = libm::sincos(theta_index as f64 * self.theta_step_rad);
        let half = (self.rho_count / 2) as f64;
        let rho = (rho_index as f64 - half) * self.rho_step_px;
        ImageLine::new(
            rho + self.centre_px.x * cos + self.centre_px.y * sin,
            theta_index as f64 * self.theta_step_rad,
        )
    }
}

/// Every point votes once for each angle (2), in the cell whose centre is nearest (in place of (3), which names a corner).
pub fn vote(points: &[Pixel], params: &PaperParams) -> Votes {
    let theta_count = libm::round(180.0 / params.hough_theta_step_deg).max(1.0) as usize;
    let theta_step_rad = PI / theta_count as f64;
    let rho_step_px = params.hough_rho_step_px;
    let (low, high) = points.iter().fold(
        (Pixel::repeat(f64::MAX), Pixel::repeat(f64::MIN)),
        |(low, high), p| (low.inf(p), high.sup(p)),
    );
    let (centre_px, reach_px) = if points.is_empty() {
        (Pixel::zeros(), 0.0)
    } else {
        (0.5 * (low + high), 0.5 * (high - low).norm())
    };
    let half = libm::ceil(reach_px / rho_step_px) as usize + 1;
    let rho_count = 2 * half + 1;
    let mut counts = vec![0_u32; theta_count * rho_count];

    // Angles outside, points inside: one row of the accumulator stays in the first-level cache.
    let us: Vec<f32> = points.iter().map(|p| (p.x - centre_px.x) as f32).collect();
    let vs: Vec<f32> = points.iter().map(|p| (p.y - centre_px.y) as f32).collect();
    for (i, row) in counts.chunks_exact_mut(rho_count).enumerate() {
        let (sin, cos) = libm::sincos(i as f64 * theta_step_rad);
        let (sin, cos) = ((sin / rho_step_px) as f32, (cos / rho_step_px) as f32);
        // Adding a positive half makes truncation a rounding to the nearest.
        let offset = half as f32 + 0.5;
        let mut cells = [0_i32; 32];
        for (us, vs) in us.chunks(32).zip(vs.chunks(32)) {
            for ((cell, u), v) in cells.iter_mut().zip(us).zip(vs) {
                *cell = (u * cos + v * sin + offset) as i32;
            }
            for cell in &cells[..us.len()] {
                if let Some(count) = row.get_mut(*cell as usize) {
                    *count += 1;
                }
            }
        }
    }
    Votes {
        theta_count,
        rho_count,
        theta_step_rad,
        rho_step_px,
        centre_px,
        counts,
    }
}

/// The cells that are fullest in their neighbourhood and pass the threshold, fullest first. The neighbourhood goes on across
/// θ = π, where ρ changes its sign.
pub fn peaks(votes: &Votes, params: &PaperParams) -> Vec<VotedLine> {
    let most = votes.counts.iter().max().copied().unwrap_or(0);
    let threshold = match params.hough_threshold {
        VoteThreshold::Votes(threshold) => threshold,
        VoteThreshold::FractionOfMax(fraction) => libm::ceil(fraction * f64::from(most)) as u32,
    }
    .max(2);
    let reach = params.hough_suppress_bins as usize;
    let (thetas, rhos) = (votes.theta_count, votes.rho_count);
    // `i` and `j` are given plus the reach, so that they are never negative.
    let index_of = |i: usize, j: usize| -> Option<usize> {
        let j = j.checked_sub(reach).filter(|j| *j < rhos)?;
        // Every passage through θ = 0 or π turns the normal round: ρ changes its sign.
        let turns = thetas * (reach / thetas + 1);
        let from_zero = i + turns - reach;
        let passages = (from_zero / thetas).abs_diff(turns / thetas);
        let j = if passages.is_multiple_of(2) {
            j
        } else {
            rhos - 1 - j
        };
        Some(from_zero % thetas * rhos + j)
    };
    let mut found: Vec<(u32, usize)> = Vec::new();
    for (here, &count) in votes.counts.iter().enumerate() {
        if count < threshold {
            continue;
        }
        let (i, j) = (here / rhos, here % rhos);
        // Of equal neighbours the first is kept.
        let beats = |there: usize| {
            let other = votes.counts[there];
            other > count || (other == count && there < here)
        };
        let inside = i >= reach && i + reach < thetas && j >= reach && j + reach < rhos;
        let beaten = (0..=2 * reach).any(|di| {
            if inside {
                let first = (i + di - reach) * rhos + j - reach;
                return (first..=first + 2 * reach).any(beats);
            }
            (0..=2 * reach).any(|dj| index_of(i + di, j + dj).is_some_and(beats))
        });
        if !beaten {
            found.push((count, here));
        }
    }
    found.sort_by_key(|&(count, index)| (core::cmp::Reverse(count), index));
    found.truncate(params.hough_max_lines);
    found
        .into_iter()
        .map(|(count, index)| VotedLine {
            line: votes.line(index / votes.rho_count, index % votes.rho_count),
            votes: count,
        })
        .collect()
}

/// [`vote`] and [`peaks`].
pub fn hough(points: &[Pixel], params: &PaperParams) -> (Votes, Vec<VotedLine>) {
    let votes = vote(points, params);
    let lines = peaks(&votes, params);
    (votes, lines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rodsight_geometry::radians;

    fn points_of(line: &ImageLine, centre: &Pixel, half_length: i32) -> Vec<Pixel> {
        let foot = centre - line.normal() * line.distance_px(centre);
        (-half_length..=half_length)
            .map(|t| foot + line.direction() * f64::from(t))
            .collect()
    }

    #[test]
    fn hough_cell_centres_are_unbiased() {
        // Lines of the bin's own angle at all offsets within a bin: the mean error of ρ must vanish, its bound is half a cell.
        for (rho_step, theta_step, angle_deg) in [
            (2.5, 4.5, -13.5),
            (2.5, 4.5, 0.0),
            (1.0, 1.0, 63.0),
            (0.5, 0.25, 90.0),
        ] {
            let params = PaperParams {
                hough_rho_step_px: rho_step,
                hough_theta_step_deg: theta_step,
                ..PaperParams::default()
            };
            let mut sum = 0.0;
            let steps = 40;
            for k in 0..steps {
                let beside = 30.0 + rho_step * (f64::from(k) + 0.5) / f64::from(steps);
                let normal = ImageLine::new(0.0, radians(angle_deg)).normal();
                let rho = normal.dot(&Pixel::new(960.0, 540.0)) + beside;
                let line = ImageLine::new(rho, radians(angle_deg));
                // A frame of two lone points keeps the accumulator's centre where it is.
                let mut points = points_of(&line, &Pixel::new(960.0, 540.0), 100);
                points.extend([Pixel::new(0.5, 0.5), Pixel::new(1919.5, 1079.5)]);
                let found = hough(&points, &params).1[0];
                assert!(found.line.angle_to(&line) < 1e-9, "{found:?}");
                let error = found.line.rho_px - line.rho_px;
                assert!(error.abs() <= 0.5 * rho_step + 1e-3, "{angle_deg} {error}");
                sum += error;
            }
            let bias = sum / f64::from(steps);
            assert!(
                bias.abs() < 0.03 * rho_step,
                "{rho_step} {angle_deg}: {bias}"
            );
        }
    }

    #[test]
    fn hough_suppression_wraps_over_theta() {
        // θ just below and above 90°·2: the same line seen from both ends of the range, with ρ of opposite sign.
        for offset in [-40.0, 0.0, 40.0] {
            let mut points = Vec::new();
            for y in 0..200 {
                // Tilted by half a bin: cells at 0 and at π − Δθ get alike votes.
                let y = f64::from(y);
                points.push(Pixel::new(
                    100.0 + offset + (y - 100.0) * libm::tan(radians(1.9)),
                    y,
                ));
            }
            points.extend([Pixel::new(0.0, 0.0), Pixel::new(200.0, 200.0)]);
            let params = PaperParams {
                hough_threshold: VoteThreshold::FractionOfMax(0.9),
                hough_suppress_bins: 3,
                ..PaperParams::default()
            };
            let votes = vote(&points, &params);
            let lines = peaks(&votes, &params);
            let upright = lines
                .iter()
                .filter(|l| l.line.angle_to(&ImageLine::new(0.0, 0.0)) < 0.2)
                .count();
            assert_eq!(upright, 1, "{offset}: {lines:?}");
        }
    }

    #[test]
    fn hough_threshold_and_number_of_lines() {
        let mut points = points_of(&ImageLine::new(100.0, 0.0), &Pixel::new(100.0, 100.0), 100);
        points.extend(points_of(
            &ImageLine::new(50.0, 0.0),
            &Pixel::new(50.0, 100.0),
            30,
        ));
        let with = |hough_threshold, hough_max_lines| {
            let params = PaperParams {
                hough_threshold,
                hough_max_lines,
                ..PaperParams::default()
            };
            hough(&points, &params).1
        };
        let upright =
            |lines: &[VotedLine]| lines.iter().filter(|l| l.line.theta_rad == 0.0).count();
        assert_eq!(upright(&with(VoteThreshold::Votes(150), 64)), 1);
        assert_eq!(upright(&with(VoteThreshold::Votes(50), 64)), 2);
        assert_eq!(upright(&with(VoteThreshold::FractionOfMax(0.25), 64)), 2);
        assert_eq!(with(VoteThreshold::Votes(2), 3).len(), 3);
        assert!(hough(&[], &PaperParams::default()).1.is_empty());
    }
}
