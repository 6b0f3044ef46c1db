//! A sweep as a table in Markdown.

use std::fmt::Write as _;

use rodsight_solver::Method;

use super::summary::{MethodSummary, Summary};
use super::variable::Variable;

const NONE: &str = "–";

/// One line per value: `joint` in full, of the others how far off they are and how often they answer.
pub(crate) fn markdown(variable: &Variable, summaries: &[Summary]) -> String {
    let count = summaries
        .iter()
        .flat_map(|summary| &summary.methods)
        .map(|of| of.scenes)
        .max();
    let mut text = format!(
        "### {} (`{}`, {} scenes a value)\n\n",
        variable.title,
        variable.name,
        count.unwrap_or(0)
    );
    let meaning = variable.meaning;
    let heads = format!(
        "| {meaning} | joint: off, mm: median [95 %] | p95 | angle, °: median | ok / degraded / refused, % | ok and wrong | ANEES \
         | 95 % coverage | efficiency | limit, mm | paper: off, mm: median [95 %] | p95 | answered, % \
         | paper-bisector: off, mm: median [95 %] | p95 | answered, % |\n"
    );
    text += &heads;
    text += &"|---".repeat(heads.matches('|').count() - 1);
    text += "|\n";
    for summary in summaries {
        let mut cells = vec![summary.name.clone()];
        if let Some(joint) = summary.method(Method::Joint) {
            cells.extend(full(joint));
        }
        cells.push(short(summary.limit_mm));
        for method in [Method::Paper, Method::PaperBisector] {
            if let Some(of) = summary.method(method) {
                cells.extend([
                    interval(of),
                    short(of.p95_mm),
                    percent(Some(of.answered_share())),
                ]);
            }
        }
        // Writing to a string cannot fail.
        writeln!(text, "| {} |", cells.join(" | ")).expect("a string grows");
    }
    text
}

fn full(of: &MethodSummary) -> [String; 8] {
    let share = |count: usize| percent(Some(count as f64 / of.scenes.max(1) as f64));
    [
        interval(of),
        short(of.p95_mm),
        short(of.median_deg),
        format!(
            "{} / {} / {}",
            share(of.ok),
            share(of.degraded),
            share(of.refused())
        ),
        of.ok_and_wrong.to_string(),
        short(of.anees),
        percent(of.coverage_95),
        short(of.efficiency),
    ]
}

fn interval(of: &MethodSummary) -> String {
    of.median_mm.map_or(NONE.to_owned(), |median| {
        format!(
            "{} [{}, {}]",
            short(Some(median.middle)),
            short(Some(median.low)),
            short(Some(median.high))
        )
    })
}

/// Three digits, or two behind the point of what is large.
pub(crate) fn short(value: Option<f64>) -> String {
    let Some(value) = value else {
        return NONE.to_owned();
    };
    match value.abs() {
        size if size >= 1e4 => "> 10⁴".to_owned(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 0.01 || size == 0.0 => format!("{value:.3}"),
        _ => format!("{value:.4}"),
    }
}

fn percent(share: Option<f64>) -> String {
    share.map_or(NONE.to_owned(), |share| format!("{:.0}", 100.0 * share))
}
