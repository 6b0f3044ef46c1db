//! A balanced mix of waters, lamps, surfaces and noise, and what it comes to by each.

use std::error::Error;
use std::fmt::Write as _;

use rodsight_scene::{EmvaEntry, SensorEntry};
use rodsight_solver::Method;

use crate::scenes::draft::Draft;
use crate::scenes::looks::{self, LAMPS, SURFACES, WATERS};
use crate::solve::solve_one;
use crate::swept;
use crate::swept::rows::Row;
use crate::swept::summary::{MethodSummary, summarise};
use crate::swept::table::short;
use crate::swept::variable::{Values, Variable};

pub(crate) const NAME: &str = "core";

const ALL: Variable = Variable::new(
    NAME,
    ["A mix of everything", "mix"],
    Values::Named(&["all"]),
);

/// Beyond type 5C nothing is seen at these distances: the sweep of waters says so.
const MIXED_WATERS: &[&str] = WATERS.split_at(8).0;

/// A scene and what was drawn for it.
pub(crate) struct Mixed {
    pub(crate) draft: Draft,
    water: &'static str,
    lamps: &'static str,
    surface: &'static str,
}

pub(crate) fn mixed(seed: u64) -> Mixed {
    let mut draft = Draft::new(seed);
    let mut dice = draft.dice(3);
    let (water, lamps, surface) = (
        dice.one_of(MIXED_WATERS),
        dice.one_of(LAMPS),
        dice.one_of(SURFACES),
    );
    looks::water(&mut draft, water);
    looks::lamps(&mut draft, lamps);
    looks::surface(&mut draft, surface);
    draft.file.sensor = SensorEntry::Emva(EmvaEntry {
        full_well_e: dice.log_within(1000.0, 12_000.0),
        ..EmvaEntry::default()
    });
    Mixed {
        draft,
        water,
        lamps,
        surface,
    }
}

pub(crate) fn solve_all(count: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let is_good = |_, seed| mixed(seed).draft.finish().is_some();
    swept::solve_all(&ALL, count, is_good, |value, seed| {
        solve_one(mixed(seed).draft, value, seed)
    })
}

/// In Markdown: all, and what is alike in lamps, water or surface.
pub(crate) fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| scenes | n | ok | degraded | refused | off, mm: median | 95 % | angle, °: median | 95 % | ANEES | `ok` and wrong \
         | `degraded` and wrong | `paper` answers | off, mm: median | 95 % | `paper-bisector` answers | off, mm: median | 95 % |\n",
    );
    text += &"|---".repeat(text.matches('|').count() - 1);
    text += "|\n";
    let mut line = |name: &str, of: &dyn Fn(&Mixed) -> bool| {
        let rows: Vec<&Row> = rows.iter().filter(|row| of(&mixed(row.seed))).collect();
        let [joint, paper, bisector] =
            [Method::Joint, Method::Paper, Method::PaperBisector].map(|m| summarise(m, &rows));
        let cells = [full(&joint), brief(&paper), brief(&bisector)].concat();
        // Writing to a string cannot fail.
        writeln!(text, "| {name} | {} |", cells.join(" | ")).expect("a string grows");
    };
    line("all", &|_| true);
    for name in LAMPS {
        line(&format!("lamps: {name}"), &|mixed| mixed.lamps == *name);
    }
    for name in MIXED_WATERS {
        line(&format!("water: {name}"), &|mixed| mixed.water == *name);
    }
    for name in SURFACES {
        line(&format!("surface: {name}"), &|mixed| mixed.surface == *name);
    }
    text
}

fn full(of: &MethodSummary) -> Vec<String> {
    vec![
        of.scenes.to_string(),
        of.ok.to_string(),
        of.degraded.to_string(),
        of.refused().to_string(),
        short(of.median_mm.map(|median| median.middle)),
        short(of.p95_mm),
        short(of.median_deg),
        short(of.p95_deg),
        short(of.anees),
        of.ok_and_wrong.to_string(),
        of.degraded_and_wrong.to_string(),
    ]
}

fn brief(of: &MethodSummary) -> Vec<String> {
    vec![
        (of.ok + of.degraded).to_string(),
        short(of.median_mm.map(|median| median.middle)),
        short(of.p95_mm),
    ]
}
