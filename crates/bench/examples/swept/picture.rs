//! A sweep as a picture: how far off the methods are, and how often `joint` answers.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use rodsight_solver::Method;

use super::summary::{MethodSummary, Summary};
use super::variable::{Values, Variable};
use crate::chart::panel::Panel;
use crate::chart::scale::{Scale, Spread};
use crate::chart::{
    AMBER, Area, BLUE, DrawError, GREEN, GREY, INK, LABEL_PX, Mark, TITLE_PX, VERMILION, WIDTH_PX,
    legend, text,
};

const HEIGHT_PX: u32 = 880;
/// Where the lower panel begins, px.
const LOWER_PX: u32 = 610;
/// Errors beyond these are drawn at them, mm.
const DRAWN_MM: [f64; 2] = [1e-3, 1e4];

fn colour(method: Method) -> RGBColor {
    match method {
        Method::Joint => BLUE,
        Method::Paper => VERMILION,
        Method::PaperBisector => GREEN,
    }
}

pub(crate) fn draw(
    path: &Path,
    variable: &Variable,
    summaries: &[Summary],
) -> Result<(), DrawError> {
    let root = SVGBackend::new(path, (WIDTH_PX, HEIGHT_PX)).into_drawing_area();
    root.fill(&WHITE)?;
    let left = |at: (i32, i32), size_px: u32, words: String| {
        root.draw(&Text::new(
            words,
            at,
            text(size_px, HPos::Left, VPos::Center),
        ))
    };
    left((16, 28), TITLE_PX, variable.title.to_owned())?;
    let lines = Method::ALL.map(|method| (Mark::Line, colour(method), method.name()));
    legend(&root, [20, 68], &lines)?;
    legend(
        &root,
        [20, 102],
        &[
            (Mark::Line, INK, "median, its 95 % interval"),
            (Mark::Dotted, INK, "p95"),
            (Mark::Dashed, INK, "Cramér–Rao limit"),
        ],
    )?;
    let (upper, lower) = root.split_vertically(LOWER_PX);
    let (_, upper) = upper.split_vertically(124);
    let x = Scale::over(
        variable.spread(),
        (summaries.iter())
            .map(|summary| (summary.value, summary.name.clone()))
            .collect(),
    );
    errors(&upper, &x, variable, summaries)?;
    let (head, lower) = lower.split_vertically(40);
    legend(
        &head,
        [20, 22],
        &[
            (Mark::Square, BLUE, "joint: ok"),
            (Mark::Square, AMBER, "degraded"),
            (Mark::Square, GREY, "refused"),
        ],
    )?;
    answers(&lower, &x, variable, summaries)?;
    let scenes = summaries
        .iter()
        .flat_map(|summary| &summary.methods)
        .map(|of| of.scenes)
        .max()
        .unwrap_or(0);
    root.draw(&Text::new(
        format!("{scenes} scenes a value"),
        (WIDTH_PX.cast_signed() - 22, 28),
        text(LABEL_PX, HPos::Right, VPos::Center),
    ))?;
    root.present()?;
    Ok(())
}

fn errors(
    area: &Area<'_>,
    x: &Scale,
    variable: &Variable,
    summaries: &[Summary],
) -> Result<(), DrawError> {
    let kept = |mm: f64| mm.clamp(DRAWN_MM[0], DRAWN_MM[1]);
    let drawn = summaries.iter().flat_map(|summary| {
        let errors = summary.methods.iter().flat_map(|of| {
            let median = of.median_mm.map(|m| [m.low, m.high]);
            median.into_iter().flatten().chain(of.p95_mm)
        });
        errors.chain(summary.limit_mm).map(kept)
    });
    let y = Scale::decades(drawn);
    let mut panel = Panel::new(area, [x, &y], None, "axis off at the grasp, mm")?;
    if matches!(variable.values, Values::Named(_)) {
        marks(&mut panel, [x, &y], summaries)
    } else {
        lines(&mut panel, [x, &y], summaries)
    }
}

/// What has an order: lines from value to value.
fn lines(
    panel: &mut Panel<'_, '_>,
    [x, y]: [&Scale; 2],
    summaries: &[Summary],
) -> Result<(), DrawError> {
    let at = |mm: f64| y.clamped(mm);
    for method in Method::ALL.into_iter().rev() {
        let of = |get: fn(&MethodSummary) -> Option<f64>| {
            stretches(summaries, |summary| {
                Some((x.at(summary.value), at(get(summary.method(method)?)?)))
            })
        };
        let bands = stretches(summaries, |summary| {
            let median = summary.method(method)?.median_mm?;
            Some((x.at(summary.value), at(median.low), at(median.high)))
        });
        for band in bands {
            panel.band(&band, colour(method))?;
        }
        for line in of(|of| of.p95_mm) {
            panel.dashed(&line, colour(method), 2)?;
        }
        for line in of(|of| Some(of.median_mm?.middle)) {
            panel.line(&line, colour(method), 5)?;
        }
    }
    for line in stretches(summaries, |summary| {
        Some((x.at(summary.value), at(summary.limit_mm?)))
    }) {
        panel.dashed(&line, INK, 10)?;
    }
    Ok(())
}

/// What has no order: marks beside each other.
fn marks(
    panel: &mut Panel<'_, '_>,
    [x, y]: [&Scale; 2],
    summaries: &[Summary],
) -> Result<(), DrawError> {
    const ASIDE: f64 = 0.03;
    for summary in summaries {
        let middle = x.at(summary.value);
        for (k, method) in Method::ALL.into_iter().enumerate() {
            let place = middle + ASIDE * (k as f64 - 1.0);
            let Some(of) = summary.method(method) else {
                continue;
            };
            if let Some(m) = of.median_mm {
                let [low, median, high] = [m.low, m.middle, m.high].map(|mm| y.clamped(mm));
                panel.whisker((place, low, median, high), colour(method), 7)?;
                let p95 = y.clamped(of.p95_mm.unwrap_or(m.high));
                panel.dashed(&[(place, median), (place, p95)], colour(method), 2)?;
            }
        }
        if let Some(limit_mm) = summary.limit_mm {
            let (limit, half) = (y.clamped(limit_mm), 2.0 * ASIDE);
            panel.dashed(&[(middle - half, limit), (middle + half, limit)], INK, 10)?;
        }
    }
    Ok(())
}

/// Points of values next to each other: a line is not drawn over values that have none.
fn stretches<T>(summaries: &[Summary], point: impl Fn(&Summary) -> Option<T>) -> Vec<Vec<T>> {
    let mut all = vec![Vec::new()];
    for summary in summaries {
        match (point(summary), all.last_mut()) {
            (Some(point), Some(last)) => last.push(point),
            _ => all.push(Vec::new()),
        }
    }
    all.retain(|stretch| !stretch.is_empty());
    all
}

fn answers(
    area: &Area<'_>,
    x: &Scale,
    variable: &Variable,
    summaries: &[Summary],
) -> Result<(), DrawError> {
    let named = [(0.0, "0"), (0.5, "50"), (1.0, "100")].map(|(v, name)| (v, name.to_owned()));
    let y = Scale::over(Spread::Linear, named.to_vec());
    let mut panel = Panel::new(area, [x, &y], Some(variable.meaning), "scenes, %")?;
    let places = x.places();
    let gaps = places.windows(2).map(|pair| pair[1] - pair[0]);
    let half = 0.4 * gaps.fold(0.06, f64::min);
    for summary in summaries {
        let Some(joint) = summary.method(Method::Joint) else {
            continue;
        };
        let (place, all) = (x.at(summary.value), joint.scenes.max(1) as f64);
        let mut from = 0.0;
        for (count, colour) in [
            (joint.ok, BLUE),
            (joint.degraded, AMBER),
            (joint.refused(), GREY),
        ] {
            let to = from + count as f64 / all;
            panel.bar(
                [(place - half, y.at(from)), (place + half, y.at(to))],
                colour,
            )?;
            from = to;
        }
    }
    Ok(())
}
