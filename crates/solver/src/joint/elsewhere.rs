//! Which strips of several pairs are one rod.
//!
//! Where one pair does not tell how far off a rod is, pairs from elsewhere do: of all likely ways to take strips from each that one is
//! best whose tangent planes touch one cylinder.

use rodsight_geometry::TangentPlane;

use super::pair::{
    Candidate, Double, Sight, by_radius, doubles, likeness, sights, slack_px, touching,
};
use super::shot::Shot;
use super::strip::Strip;
use crate::RadiusPrior;

/// So many of the likeliest are taken on to the next pair.
const KEPT: usize = 24;
/// How likely it is that a pair's strips are without the rod, or that planes which place none will, as a share.
const DOUBTFUL: f64 = 0.3;

/// A rod as far as some pairs show it.
#[derive(Clone)]
struct Draft {
    strips: [Strip; 2],
    more: Vec<Option<[Strip; 2]>>,
    planes: Vec<TangentPlane>,
    /// How strong its strips are, and how alike.
    alike: f64,
    /// With how well its planes agree.
    score: f64,
    is_placed: bool,
}

/// All that score at least this share of the likeliest, likeliest first.
pub(crate) fn candidates(
    shots: &[Shot<'_>],
    prior: Option<RadiusPrior>,
    least_share: f64,
) -> Vec<Candidate> {
    let Some((first, more)) = shots.split_first() else {
        return Vec::new();
    };
    let slack_px = shots.iter().map(slack_px).fold(0.0, f64::max);
    let placed = |draft: Draft| draft.placed(first, prior.as_ref(), slack_px);
    let sights_of_first = sights(first);
    let doubles_of_first = likeliest(first, &sights_of_first, prior.is_some());
    let drafts = doubles_of_first.iter().map(Draft::new).map(placed);
    let mut drafts: Vec<Draft> = drafts.collect();
    for shot in more {
        let sights: [Vec<Sight<'_>>; 2] = sights(shot);
        let doubles = likeliest(shot, &sights, prior.is_some());
        let most = doubles.first().map_or(1.0, |double| double.most);
        let with_each = drafts.iter().flat_map(|draft| {
            let seen = doubles
                .iter()
                .map(|double| placed(draft.with(double, most)));
            seen.chain([draft.without()])
        });
        let mut next: Vec<Draft> = with_each.collect();
        next.sort_by(|a, b| b.score.total_cmp(&a.score));
        next.truncate(KEPT);
        drafts = next;
    }
    drafts.retain(|draft| draft.is_placed);
    let best = drafts.first().map_or(0.0, |draft| draft.score);
    drafts.retain(|draft| draft.score > 0.0 && draft.score >= least_share * best);
    let candidate = |draft: Draft| Candidate {
        strips: draft.strips,
        more: draft.more,
        score: draft.score,
    };
    drafts.into_iter().map(candidate).collect()
}

fn likeliest<'a>(
    shot: &Shot<'_>,
    sights: &'a [Vec<Sight<'a>>; 2],
    is_radius_known: bool,
) -> Vec<Double<'a>> {
    let mut doubles = doubles(shot, sights, is_radius_known);
    doubles.truncate(KEPT);
    doubles
}

impl Draft {
    fn new(double: &Double<'_>) -> Self {
        Self {
            strips: double.strips(),
            more: Vec::new(),
            planes: double.planes().to_vec(),
            alike: double.most,
            score: 0.0,
            is_placed: false,
        }
    }

    /// With what may be the same rod in one more pair, whose likeliest has `most`.
    fn with(&self, double: &Double<'_>, most: f64) -> Self {
        let mut draft = self.clone();
        draft.more.push(Some(double.strips()));
        draft.planes.extend(double.planes());
        draft.alike *= (double.most / most).sqrt() * likeness(&self.strips[0], double.left.strip);
        draft
    }

    /// Not seen in one more pair.
    fn without(&self) -> Self {
        let mut draft = self.clone();
        draft.more.push(None);
        draft.alike *= DOUBTFUL;
        draft.score *= DOUBTFUL;
        draft
    }

    /// With its score.
    fn placed(mut self, first: &Shot<'_>, prior: Option<&RadiusPrior>, slack_px: f64) -> Self {
        let touching = |known| {
            touching(
                &first.rig,
                first.lights()[0],
                &self.strips[0],
                &self.planes,
                known,
            )
        };
        let known = prior.map(|prior| prior.radius_m);
        let located = touching(None).or_else(|| known.and_then(|r| touching(Some(r))));
        self.is_placed = located.is_some();
        self.score = match located {
            None => DOUBTFUL * self.alike,
            Some((cylinder, residual_px)) => {
                let off = residual_px / slack_px;
                let radius = prior.map_or(1.0, |prior| by_radius(prior, cylinder.radius_m));
                self.alike * radius * libm::exp(-0.5 * off * off)
            }
        };
        self
    }
}
