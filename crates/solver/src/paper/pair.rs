//! Which two lines are the sides of the rod: in one eye, then in both together.

use rodsight_geometry::{Camera, ImageLine, Pixel, radians};

use crate::Roi;
use crate::paper::{PaperParams, RefinedLine};

/// At most so many strips per eye are compared with those of the other eye.
const STRIPS_PER_EYE: usize = 8;

/// Two limbs with rod between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// The limbs; their inward normals point at each other.
    pub limbs: [RefinedLine; 2],
    /// Middle of the stretch in which both are seen, px.
    pub middle_px: Pixel,
    /// Half the length of that stretch, px.
    pub half_length_px: f64,
    /// Direction of the strip.
    pub direction: Pixel,
    /// Width in the middle, px.
    pub width_px: f64,
    /// Fraction of it that was taken for rod.
    pub fill: f64,
    /// Root of the product of the supports, times the fill.
    pub score: f64,
}

impl Strip {
    /// The limbs as lines.
    pub fn lines(&self) -> [ImageLine; 2] {
        [self.limbs[0].line, self.limbs[1].line]
    }

    /// How far a point lies outside the strip, across or beyond its ends, px.
    pub fn distance_px(&self, point: &Pixel) -> f64 {
        let across = self
            .limbs
            .iter()
            .map(|l| -l.line.distance_px(point) * l.polarity.sign())
            .fold(0.0, f64::max);
        // The longer limb tells how far the rod reaches.
        let (mut first, mut last) = (f64::MAX, f64::MIN);
        for end in self.limbs.iter().flat_map(RefinedLine::ends_px) {
            let t = (end - self.middle_px).dot(&self.direction);
            (first, last) = (first.min(t), last.max(t));
        }
        let t = (point - self.middle_px).dot(&self.direction);
        libm::hypot(across, (first - t).max(t - last).max(0.0))
    }

    /// Whether the other strip shows the same rod.
    pub fn is_same_rod(&self, other: &Self) -> bool {
        let offset = other.middle_px - self.middle_px;
        let across = offset - self.direction * offset.dot(&self.direction);
        across.norm() < 0.35 * self.width_px.max(other.width_px)
    }
}

/// Every pair of limbs that has rod between them, best first.
pub fn strips(
    lines: &[RefinedLine],
    mask: &[u8],
    roi: &Roi,
    camera: &Camera,
    params: &PaperParams,
) -> Vec<Strip> {
    let limbs: Vec<&RefinedLine> = lines.iter().filter(|l| l.is_limb(params)).collect();
    let mut strips = Vec::new();
    for (i, a) in limbs.iter().enumerate() {
        for b in &limbs[i + 1..] {
            strips.extend(strip(a, b, mask, roi, camera, params));
        }
    }
    strips.sort_by(|a, b| b.score.total_cmp(&a.score));
    strips
}

/// The strips worth comparing with the other eye's, best first: none if the pick is off all of them. The operator means the
/// rod under the pick, so a strip beside it counts less the further it is.
pub(crate) fn shortlist(
    strips: &[Strip],
    pick: Option<&Pixel>,
    params: &PaperParams,
) -> Vec<Strip> {
    let mut list: Vec<Strip> = strips
        .iter()
        .filter_map(|strip| {
            let off = pick.map_or(0.0, |pick| strip.distance_px(pick));
            let t = off / (0.3 * params.pick_margin_px).max(f64::MIN_POSITIVE);
            (off <= params.pick_margin_px).then(|| Strip {
                score: strip.score * libm::exp(-0.5 * t * t),
                ..strip.clone()
            })
        })
        .collect();
    list.sort_by(|a, b| b.score.total_cmp(&a.score));
    list.truncate(STRIPS_PER_EYE);
    list
}

fn strip(
    a: &RefinedLine,
    b: &RefinedLine,
    mask: &[u8],
    roi: &Roi,
    camera: &Camera,
    params: &PaperParams,
) -> Option<Strip> {
    let facing = -a.inward().dot(&b.inward());
    if facing < libm::cos(radians(params.parallel_tolerance_deg)) {
        return None;
    }
    let inward = (a.inward() - b.inward()).normalize();
    let direction = Pixel::new(-inward.y, inward.x);
    let range = |l: &RefinedLine| {
        let [p, q] = l.ends_px().map(|end| end.dot(&direction));
        [p.min(q), p.max(q)]
    };
    let (range_a, range_b) = (range(a), range(b));
    let (first, last) = (range_a[0].max(range_b[0]), range_a[1].min(range_b[1]));
    let shorter = (range_a[1] - range_a[0]).min(range_b[1] - range_b[0]);
    if !(last - first > params.min_overlap * shorter && shorter > 0.0) {
        return None;
    }
    // Where the limbs are at a place along the strip, measured across it.
    let offset = |l: &RefinedLine, t: f64| {
        let normal = l.line.normal();
        (l.line.rho_px - t * normal.dot(&direction)) / normal.dot(&inward)
    };
    let width = |t: f64| offset(b, t) - offset(a, t);
    if !(width(first) > 1.0 && width(last) > 1.0) {
        return None;
    }
    let (mut inside, mut total) = (0_u32, 0_u32);
    for k in 0..48 {
        let t = first + (last - first) * (f64::from(k) + 0.5) / 48.0;
        for j in 0..8 {
            let across = offset(a, t) + width(t) * (f64::from(j) + 0.5) / 8.0;
            if let Some(rod) = mask_at(mask, roi, camera, &(direction * t + inward * across)) {
                inside += u32::from(rod);
                total += 1;
            }
        }
    }
    let fill = f64::from(inside) / f64::from(total.max(1));
    if fill < params.min_fill {
        return None;
    }
    let middle = 0.5 * (first + last);
    Some(Strip {
        middle_px: direction * middle + inward * (offset(a, middle) + 0.5 * width(middle)),
        half_length_px: 0.5 * (last - first),
        direction,
        width_px: width(middle),
        fill,
        score: libm::sqrt(a.support as f64 * b.support as f64) * fill,
        limbs: [a.clone(), b.clone()],
    })
}

/// Whether the mask says rod at a point of the undistorted image; `None` outside the region.
fn mask_at(mask: &[u8], roi: &Roi, camera: &Camera, point: &Pixel) -> Option<bool> {
    let seen = if camera.is_pinhole() {
        *point
    } else {
        camera.project(&camera.without_distortion().ray(point)?)?
    };
    let (x, y) = (
        libm::floor(seen.x) - f64::from(roi.x_px),
        libm::floor(seen.y) - f64::from(roi.y_px),
    );
    let inside =
        (0.0..f64::from(roi.width_px)).contains(&x) && (0.0..f64::from(roi.height_px)).contains(&y);
    inside.then(|| mask[y as usize * roi.width_px as usize + x as usize] != 0)
}
