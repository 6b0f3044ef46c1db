//! Risk against coverage, and how often claimed ellipsoids hold the truth.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use rodsight_bench::SUCCESS_LEVELS;
use rodsight_bench::statistics::{coverage, holds, risk_coverage, share_interval};
use rodsight_solver::Status;

use crate::asked::answer::Answer;
use crate::chart::panel::Panel;
use crate::chart::scale::{Scale, Spread};
use crate::chart::{
    AMBER, Area, BLUE, DrawError, GREY, LABEL_PX, Mark, TITLE_PX, VERMILION, WIDTH_PX, legend, text,
};

/// The probabilities of the ellipsoids that are looked at.
const PROBABILITIES: [f64; 4] = [0.5, 0.9, 0.95, 0.99];

pub(crate) fn draw(dir: &Path, all: &[(&str, Vec<Answer>)]) -> Result<(), DrawError> {
    let answers = all.iter().flat_map(|(_, answers)| answers);
    let answers: Vec<&Answer> = answers.filter(|answer| answer.counts()).collect();
    risk(&dir.join("risk_coverage.svg"), &answers)?;
    claims(&dir.join("coverage.svg"), &answers)
}

fn titled<'a>(root: &Area<'a>, title: &str, scenes: usize) -> Result<Area<'a>, DrawError> {
    root.fill(&WHITE)?;
    root.draw(&Text::new(
        title.to_owned(),
        (16, 28),
        text(TITLE_PX, HPos::Left, VPos::Center),
    ))?;
    root.draw(&Text::new(
        format!("{scenes} scenes"),
        (WIDTH_PX.cast_signed() - 22, 70),
        text(LABEL_PX, HPos::Right, VPos::Center),
    ))?;
    Ok(root.split_vertically(96).1)
}

fn percents(values: &[f64]) -> Scale {
    let name = |share: &f64| (*share, format!("{}", (100.0 * share).round()));
    Scale::over(Spread::Linear, values.iter().map(name).collect())
}

/// Of answers in order of what they claim, ok before degraded: how many are farther off than each level of success.
fn risk(path: &Path, answers: &[&Answer]) -> Result<(), DrawError> {
    // Shares below are drawn at it: a logarithmic axis has no zero.
    const LEAST: f64 = 1e-3;
    let root = SVGBackend::new(path, (WIDTH_PX, 640)).into_drawing_area();
    let body = titled(
        &root,
        "joint: the share of answers that is lost, surest first",
        answers.len(),
    )?;
    let levels = SUCCESS_LEVELS.map(|level| format!("> {} mm", 1e3 * level.offset_m));
    let colours = [BLUE, AMBER, VERMILION];
    let entries: Vec<_> = (colours.iter().zip(&levels))
        .map(|(colour, name)| (Mark::Line, *colour, name.as_str()))
        .collect();
    legend(&root, [20, 70], &entries)?;
    let x = percents(&[0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    let named = [(LEAST, "≤ 0.1"), (0.01, "1"), (0.1, "10"), (1.0, "100")];
    let named = named.map(|(share, name)| (share, name.to_owned()));
    let y = Scale::over(Spread::Log, named.to_vec());
    let mut panel = Panel::new(
        &body,
        [&x, &y],
        Some("scenes answered, %"),
        "answers off by more, %",
    )?;
    for (level, colour) in SUCCESS_LEVELS.iter().zip(colours) {
        let claimed: Vec<(f64, bool)> = answers
            .iter()
            .filter(|answer| answer.is_answered())
            .map(|answer| {
                let after_ok = if answer.status() == Status::Ok {
                    0.0
                } else {
                    1e9
                };
                let claimed_m = answer.claimed_offset_m.unwrap_or(f64::INFINITY);
                let off_m = answer.answered().map(|errors| errors.axis_offset_m);
                // Of a rod that is not there: lost.
                (
                    after_ok + claimed_m,
                    off_m.is_none_or(|off_m| off_m > level.offset_m),
                )
            })
            .collect();
        let points: Vec<(f64, f64)> = risk_coverage(&claimed, answers.len())
            .into_iter()
            .map(|[share, risk]| (x.at(share), y.at(risk.max(LEAST))))
            .collect();
        panel.line(&points, colour, 1)?;
    }
    root.present()?;
    Ok(())
}

/// How often the ellipsoid of a probability holds the truth.
fn claims(path: &Path, answers: &[&Answer]) -> Result<(), DrawError> {
    let root = SVGBackend::new(path, (WIDTH_PX, 640)).into_drawing_area();
    let body = titled(
        &root,
        "joint: how often the truth is within what is claimed",
        answers.len(),
    )?;
    let entries = [
        (Mark::Line, BLUE, "ok"),
        (Mark::Line, AMBER, "degraded"),
        (Mark::Dashed, GREY, "as claimed"),
    ];
    legend(&root, [20, 70], &entries)?;
    let x = Scale::over(
        Spread::Even,
        PROBABILITIES
            .map(|p| (p, format!("{}", (100.0 * p).round())))
            .to_vec(),
    );
    let y = percents(&[0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    let mut panel = Panel::new(
        &body,
        [&x, &y],
        Some("probability claimed, %"),
        "truth within, %",
    )?;
    let claimed = PROBABILITIES.map(|p| (x.at(p), y.at(p)));
    panel.dashed(&claimed, GREY, 10)?;
    for (status, colour) in [(Status::Ok, BLUE), (Status::Degraded, AMBER)] {
        let nees: Vec<_> = answers
            .iter()
            .filter(|answer| answer.status() == status)
            .filter_map(|answer| answer.nees())
            .collect();
        let band: Vec<(f64, f64, f64)> = PROBABILITIES
            .into_iter()
            .filter_map(|p| {
                let held = nees.iter().filter(|nees| holds(nees, p)).count();
                let [low, high] = share_interval(held, nees.len(), 0.95)?;
                Some((x.at(p), y.at(low), y.at(high)))
            })
            .collect();
        let points: Vec<(f64, f64)> = PROBABILITIES
            .into_iter()
            .filter_map(|p| Some((x.at(p), y.at(coverage(&nees, p)?))))
            .collect();
        panel.band(&band, colour)?;
        panel.line(&points, colour, 6)?;
    }
    root.present()?;
    Ok(())
}
