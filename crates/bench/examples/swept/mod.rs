//! Sweeps: outcomes of the methods as one variable changes, as rows, tables and pictures, wherever the pairs come from.
#![allow(dead_code, reason = "each program uses a part")]
#![allow(
    clippy::allow_attributes,
    reason = "`expect` cannot say `in some of the programs`"
)]

mod picture;
pub(crate) mod rows;
pub(crate) mod summary;
pub(crate) mod table;
pub(crate) mod variable;

use std::error::Error;
use std::path::PathBuf;

use rayon::prelude::*;

use crate::asked::Failure;
use rows::Row;
use summary::Summary;
use variable::Variable;

/// What is to be done, as it was typed.
pub(crate) struct Orders {
    /// Scenes a value.
    pub(crate) count: usize,
    pub(crate) dir: PathBuf,
    /// Or the pictures are drawn again from the CSV.
    pub(crate) solves: bool,
    /// Of the sweeps; all of them if empty.
    names: Vec<String>,
}

impl Orders {
    /// `[-n COUNT] [-o DIR] [--redraw] [NAME…]`
    pub(crate) fn read(count: usize, known: &[&str]) -> Result<Self, Box<dyn Error>> {
        let (mut dir, mut solves, mut names) = (PathBuf::from("."), true, Vec::new());
        let mut count = count;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            match word.as_str() {
                "-n" => count = words.next().ok_or("-n asks for a number")?.parse()?,
                "-o" => dir = words.next().ok_or("-o asks for a folder")?.into(),
                "--redraw" => solves = false,
                _ if known.contains(&word.as_str()) => names.push(word),
                _ => {
                    let known = known.join(", ");
                    return Err(format!("expected one of {known}, found `{word}`").into());
                }
            }
        }
        std::fs::create_dir_all(&dir)?;
        Ok(Self {
            count,
            dir,
            solves,
            names,
        })
    }

    pub(crate) fn ask_for(&self, name: &str) -> bool {
        self.names.is_empty() || self.names.iter().any(|wanted| wanted == name)
    }

    /// Every outcome of a sweep, written to `NAME.csv` or read from it.
    pub(crate) fn rows(
        &self,
        name: &str,
        solve: impl FnOnce(usize) -> Result<Vec<Row>, Box<dyn Error>>,
    ) -> Result<Vec<Row>, Box<dyn Error>> {
        let file = self.dir.join(format!("{name}.csv"));
        if self.solves {
            rows::write(&file, &solve(self.count)?)?;
        }
        rows::read(&file)
    }

    /// Draws a sweep to `NAME.svg` and gives its table.
    pub(crate) fn report(
        &self,
        variable: &Variable,
        rows: &[Row],
    ) -> Result<String, Box<dyn Error>> {
        let summaries = Summary::of(variable, rows);
        let file = self.dir.join(format!("{}.svg", variable.name));
        picture::draw(&file, variable, &summaries)?;
        Ok(table::markdown(variable, &summaries))
    }
}

/// A row per value, seed and method. The seeds are the first that are good at every value: what is compared is the same scenes.
pub(crate) fn solve_all(
    variable: &Variable,
    count: usize,
    is_good: impl Fn(f64, u64) -> bool,
    solve: impl Fn((f64, &str), u64) -> Result<Vec<Row>, Failure> + Sync,
) -> Result<Vec<Row>, Box<dyn Error>> {
    let values = variable.values();
    let tried = 100 * count as u64;
    let seeds: Vec<u64> = (0..tried)
        .filter(|seed| values.iter().all(|(value, _)| is_good(*value, *seed)))
        .take(count)
        .collect();
    if seeds.len() < count {
        return Err(format!(
            "{}: expected {count} scenes whose rod is in both images at every value, found {} of {tried}",
            variable.name,
            seeds.len()
        )
        .into());
    }
    let scenes: Vec<(&(f64, String), u64)> = values
        .iter()
        .flat_map(|value| seeds.iter().map(move |seed| (value, *seed)))
        .collect();
    let rows: Vec<Vec<Row>> = scenes
        .par_iter()
        .map(|((value, name), seed)| solve((*value, name), *seed))
        .collect::<Result<_, Failure>>()
        .map_err(|failure| -> Box<dyn Error> { failure })?;
    Ok(rows.concat())
}
