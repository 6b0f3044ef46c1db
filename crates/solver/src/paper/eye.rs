//! The stages that each eye goes through by itself.

use std::time::Instant;

use rodsight_geometry::{Camera, Eye, ImageLine, Pixel};

use super::Centre;
use super::locate::centerline;
use super::segment::{self, Rule};
use super::{
    EdgePoint, EyeTrace, PaperParams, RefinedLine, Refusal, Strip, VotedLine, Votes, binarise,
    canny, hough, majority, milliseconds, refine, strips,
};
use crate::{EyeReport, Request, Roi, TimingMs};

/// One eye after segmentation, Canny, Hough, refinement and pairing.
#[derive(Debug)]
pub(crate) struct Seen {
    roi: Roi,
    mask: Vec<u8>,
    edges: Vec<EdgePoint>,
    votes: Votes,
    coarse: Vec<VotedLine>,
    refined: Vec<Vec<RefinedLine>>,
    pub strips: Vec<Strip>,
    pub refusal: Option<Refusal>,
    pub report: EyeReport,
    pub warning: Option<String>,
    pub timing_ms: TimingMs,
}

/// Both eyes, side by side. The rod's look is learned where the pick is, else in the left eye.
pub(crate) fn see_both(request: &Request<'_>, params: &PaperParams) -> [Seen; 2] {
    let start = Instant::now();
    let first = request.pick.map_or(Eye::Left, |pick| pick.eye);
    let pixel = request.pick.map(|pick| pick.pixel);
    let (image, roi) = (request.image(first), request.roi(first));
    let learned = segment::learn(image, &roi, pixel.as_ref(), params, first.name());
    let learning = milliseconds(start);
    let look = |eye: Eye| {
        let rule = match &learned {
            Ok(rule) if eye == first => *rule,
            Ok(rule) => segment::for_other_eye(rule, request.image(eye), &request.roi(eye), params),
            Err(refusal) => return Seen::blind(request.roi(eye), refusal.clone()),
        };
        let mut seen = see(request, eye, rule, params);
        seen.timing_ms.segment += learning;
        seen
    };
    let (left, right) = rayon::join(|| look(Eye::Left), || look(Eye::Right));
    [left, right]
}

fn see(request: &Request<'_>, eye: Eye, rule: Rule, params: &PaperParams) -> Seen {
    let (image, roi) = (request.image(eye), request.roi(eye));
    let camera = &request.pair.rig.eye(eye).camera;
    let mut timing_ms = TimingMs::default();

    let start = Instant::now();
    let mask = majority(
        &binarise(image, &roi, &rule),
        &roi,
        params.mask_median_radius_px,
    );
    timing_ms.segment = milliseconds(start);

    let start = Instant::now();
    let mut edges = canny(&mask, &roi, params);
    undistort(&mut edges, camera);
    timing_ms.canny = milliseconds(start);

    let start = Instant::now();
    let points: Vec<Pixel> = edges.iter().map(|e| e.pixel).collect();
    let (votes, coarse) = hough(&points, params);
    timing_ms.hough = milliseconds(start);

    let start = Instant::now();
    let refined = refine(&edges, &coarse, params);
    timing_ms.refine = milliseconds(start);

    let start = Instant::now();
    let last: &[RefinedLine] = refined.last().map_or(&[], Vec::as_slice);
    let strips = strips(last, &mask, &roi, camera, params);
    timing_ms.pair = milliseconds(start);

    let rod = count(&mask);
    let name = eye.name();
    let refusal = if rod == 0 {
        Some(Refusal::NoRegion {
            eye: name,
            rule: rule.to_string(),
        })
    } else if edges.is_empty() {
        Some(Refusal::NoEdges {
            eye: name,
            rule: rule.to_string(),
        })
    } else if !last.iter().any(|line| line.is_limb(params)) {
        Some(Refusal::NoLines {
            eye: name,
            edges: edges.len(),
        })
    } else if strips.is_empty() {
        Some(Refusal::NoPair {
            eye: name,
            lines: last.len(),
        })
    } else {
        None
    };
    let by_luminance = matches!(rule, Rule::Luminance { .. });
    let unasked = params.segmentation == super::SegmentationMode::Auto && image.channels() == 3;
    Seen {
        report: EyeReport {
            segmentation: Some(rule.to_string()),
            mask_fraction: Some(rod as f64 / roi.area_px() as f64),
            edges: Some(edges.len()),
            ..EyeReport::default()
        },
        warning: (by_luminance && unasked).then(|| {
            format!(
                "{name} image: rod and background do not differ in hue, luminance was used instead"
            )
        }),
        roi,
        mask,
        edges,
        votes,
        coarse,
        refined,
        strips,
        refusal,
        timing_ms,
    }
}

/// How many pixels are 255. Sums of at most 128 ones fit a byte, which makes vectors of them.
fn count(mask: &[u8]) -> usize {
    mask.chunks(128)
        .map(|chunk| usize::from(chunk.iter().map(|m| m >> 7).sum::<u8>()))
        .sum()
}

/// Edge points as the camera without distortion would see them; those it cannot see are dropped.
pub fn undistort(edges: &mut Vec<EdgePoint>, camera: &Camera) {
    if camera.is_pinhole() {
        return;
    }
    edges.retain_mut(|edge| match camera.undistort(&edge.pixel) {
        Some(pixel) => {
            edge.pixel = pixel;
            true
        }
        None => false,
    });
}

impl Seen {
    /// An eye that was not looked at: there is no rule to look by.
    fn blind(roi: Roi, refusal: Refusal) -> Self {
        let params = PaperParams::default();
        Self {
            roi,
            mask: vec![0; roi.area_px()],
            edges: Vec::new(),
            votes: super::vote(&[], &params),
            coarse: Vec::new(),
            refined: Vec::new(),
            strips: Vec::new(),
            refusal: Some(refusal),
            report: EyeReport::default(),
            warning: None,
            timing_ms: TimingMs::default(),
        }
    }

    pub(crate) fn into_trace(
        self,
        camera: &Camera,
        limbs: Option<[ImageLine; 2]>,
        centre: Centre,
    ) -> EyeTrace {
        EyeTrace {
            roi: self.roi,
            mask: self.mask,
            edges: self.edges,
            votes: self.votes,
            coarse: self.coarse,
            refined: self.refined,
            centerline: limbs.and_then(|limbs| centerline(camera, &limbs, centre)),
            limbs,
        }
    }
}
