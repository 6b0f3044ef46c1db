//! `rodsight demo`.

mod pictures;

use std::io::Write;
use std::path::Path;

use rodsight_bench::{Errors, Limit, limit, measure};
use rodsight_geometry::{Eye, StereoPair, degrees};
use rodsight_render::{Truth, write_whole};
use rodsight_scene::Scene;
use rodsight_solver::{
    Estimate, Method, PaperParams, Pick, Request, Roi, TimingMs, Trace, solve_traced,
};
use serde::Serialize;

use crate::args::DemoArgs;
use crate::commands::render::{Channels, RenderTiming, Rendered, render, write};
use crate::commands::solve::status_name;
use crate::commands::{print_json, print_text};
use crate::failure::{Failure, claim_output};
use crate::progress::Progress;
use crate::table::Table;

/// The founding scene travels inside the program: the demo needs no file.
const PAPER_SCENE: &str = include_str!("../../../../scenes/paper.toml");

/// Pixels that an operator's region leaves around the rod.
const REGION_MARGIN_PX: u32 = 60;

/// Everything the demo found: `result.json`.
#[derive(Serialize)]
struct DemoResult<'a> {
    schema: u32,
    truth: &'a Truth,
    /// How accurate any method could be on this pair.
    limit: Option<Limit>,
    methods: Vec<Solved>,
    render_timing_ms: RenderTiming,
}

/// One method's answer beside the truth.
#[derive(Serialize)]
struct Solved {
    estimate: Estimate,
    /// Null where the method refused.
    errors: Option<Errors>,
    #[serde(skip)]
    trace: Option<Trace>,
}

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let scene =
        Scene::from_toml(PAPER_SCENE, Path::new("scenes/paper.toml")).map_err(Failure::input)?;
    claim_output(&args.output)?;
    let mut rendered = render(&scene, args.backend)?;
    write(&args.output, &scene, &mut rendered, Channels::LeftOut)?;
    let progress = Progress::busy("locating, drawing");
    let methods = solve_all(&scene, &rendered)?;
    let limit = limit(&rendered.truth).map_err(Failure::failed)?;
    pictures::write(&args.output, &rendered, &methods)?;
    let result = DemoResult {
        schema: 1,
        truth: &rendered.truth,
        limit,
        methods,
        render_timing_ms: rendered.timing_ms,
    };
    let path = args.output.join("result.json");
    let json = serde_json::to_vec_pretty(&result).map_err(Failure::failed)?;
    write_whole(&path, |file| file.write_all(&json))?;
    let index = args.output.join("index.html");
    pictures::page(&rendered, limit.as_ref(), &result.methods)?.write(&index)?;
    drop(progress);
    if args.json {
        return print_json(&result);
    }
    print_text(&in_words(&rendered, limit.as_ref(), &result.methods))?;
    print_text(&format!("\n{}\n", index.display()))
}

fn solve_all(scene: &Scene, rendered: &Rendered) -> Result<Vec<Solved>, Failure> {
    let pair = StereoPair::new(
        scene.rig,
        rendered.developed.left.clone(),
        rendered.developed.right.clone(),
    )
    .map_err(Failure::input)?;
    let truth = &rendered.truth;
    let request = Request {
        pair: &pair,
        roi_left: region(rendered, Eye::Left),
        roi_right: region(rendered, Eye::Right),
        pick: Some(Pick {
            pixel: truth.grasp.pick_px.into(),
            eye: truth.grasp.pick_eye,
        }),
        radius: None,
        calibration: None,
        more: &[],
    };
    Method::ALL
        .iter()
        .map(|&method| {
            let (estimate, trace) =
                solve_traced(&request, method, &PaperParams::default()).map_err(Failure::input)?;
            Ok(Solved {
                errors: measure(truth, &estimate).map_err(Failure::failed)?,
                estimate,
                trace,
            })
        })
        .collect()
}

/// The region an operator would draw: the rod's pixels and some more.
fn region(rendered: &Rendered, eye: Eye) -> Option<Roi> {
    let frame = rendered.frame.eye(eye);
    let instance = rendered.truth.target().instance;
    let seen = |column: u32, row: u32| frame.at(column, row).instance == instance;
    let columns =
        (0..frame.width_px).filter(|&column| (0..frame.height_px).any(|row| seen(column, row)));
    let rows =
        (0..frame.height_px).filter(|&row| (0..frame.width_px).any(|column| seen(column, row)));
    let span = |indices: Vec<u32>, size: u32| {
        let from = indices.first()?.saturating_sub(REGION_MARGIN_PX);
        Some((
            from,
            (indices.last()? + 1 + REGION_MARGIN_PX).min(size) - from,
        ))
    };
    let (x_px, width_px) = span(columns.collect(), frame.width_px)?;
    let (y_px, height_px) = span(rows.collect(), frame.height_px)?;
    Some(Roi {
        x_px,
        y_px,
        width_px,
        height_px,
    })
}

/// Every number that is compared: its name, the truth, what each method says, the statistical limit.
fn comparison(truth: &Truth, limit: Option<&Limit>, methods: &[Solved]) -> Vec<Vec<String>> {
    let mm = |v: f64| format!("{:.3}", v * 1e3);
    let angle = |v: f64| format!("{:.4}", degrees(v));
    let metres = |v: [f64; 3]| format!("{:.4}, {:.4}, {:.4}", v[0], v[1], v[2]);
    let none = || "–".to_owned();
    let row = |name: &str,
               true_value: String,
               value: &dyn Fn(&Solved) -> Option<String>,
               limit: Option<String>| {
        let cells = methods
            .iter()
            .map(|solved| value(solved).unwrap_or_else(none));
        let ends = ([name.to_owned(), true_value], limit.unwrap_or_default());
        ends.0
            .into_iter()
            .chain(cells)
            .chain([ends.1])
            .collect::<Vec<_>>()
    };
    let error = |name: &str, value: &dyn Fn(&Errors) -> Option<String>, limit: Option<String>| {
        row(
            name,
            "0".to_owned(),
            &|solved| value(solved.errors.as_ref()?),
            limit,
        )
    };
    vec![
        row(
            "status",
            String::new(),
            &|s| Some(status_name(s.estimate.status).to_owned()),
            None,
        ),
        row(
            "grasp, m",
            metres(truth.grasp.point_m),
            &|s| Some(metres(s.estimate.grasp?.point_m?)),
            None,
        ),
        row(
            "direction",
            metres(truth.grasp.axis.direction),
            &|s| Some(metres(s.estimate.axis?.direction?)),
            None,
        ),
        row(
            "radius, mm",
            mm(truth.target().radius_m),
            &|s| s.estimate.radius_m.map(mm),
            None,
        ),
        error(
            "error: axis at the grasp, mm",
            &|e| Some(mm(e.axis_offset_m)),
            limit.map(|l| mm(l.axis_offset_m)),
        ),
        error("error: depth, mm", &|e| Some(mm(e.depth_m)), None),
        error(
            "error: axis angle, °",
            &|e| Some(angle(e.axis_angle_rad)),
            limit.map(|l| angle(l.axis_angle_rad)),
        ),
        error(
            "error: grasp across the rod, mm",
            &|e| Some(mm(e.grasp?.across_m)),
            None,
        ),
        error(
            "error: grasp along the rod, mm",
            &|e| Some(mm(e.grasp?.along_m)),
            None,
        ),
        error(
            "error: radius, mm",
            &|e| e.radius_m.map(mm),
            limit.map(|l| mm(l.radius_m)),
        ),
        row(
            "claimed σ of the grasp, mm",
            String::new(),
            &|s| claimed_sigma_m(s).map(mm),
            None,
        ),
    ]
}

fn claimed_sigma_m(solved: &Solved) -> Option<f64> {
    let covariance = solved.estimate.grasp?.covariance_m2?;
    Some((0..3).map(|k| covariance[k][k]).sum::<f64>().sqrt())
}

fn timing(methods: &[Solved]) -> Vec<Vec<String>> {
    let stage = |name: &str, value: fn(&TimingMs) -> f64| {
        let cells = methods
            .iter()
            .map(|solved| format!("{:.2}", value(&solved.estimate.timing_ms)));
        std::iter::once(name.to_owned())
            .chain(cells)
            .collect::<Vec<_>>()
    };
    vec![
        stage("segment", |t| t.segment),
        stage("canny", |t| t.canny),
        stage("hough", |t| t.hough),
        stage("refine", |t| t.refine),
        stage("pair", |t| t.pair),
        stage("locate", |t| t.locate),
        stage("total", |t| t.total),
    ]
}

fn header(first: &[&str], methods: &[Solved]) -> Vec<String> {
    let names = methods.iter().map(|solved| solved.estimate.method.clone());
    first.iter().map(ToString::to_string).chain(names).collect()
}

fn compared_header(methods: &[Solved]) -> Vec<String> {
    let mut cells = header(&["", "truth"], methods);
    cells.push("statistical limit (σ)".to_owned());
    cells
}

fn in_words(rendered: &Rendered, limit: Option<&Limit>, methods: &[Solved]) -> String {
    let text_table = |header: Vec<String>, rows: Vec<Vec<String>>| {
        let mut table = Table::new(header);
        for row in rows {
            table.row(row);
        }
        table.to_string()
    };
    let truth = &rendered.truth;
    let mut text = format!(
        "{} in {} water, rendered by the {} backend on {} ({}) in {:.1} s\n\n",
        truth.scene,
        truth.water.label,
        truth.backend,
        truth.adapter,
        rendered.why,
        rendered.timing_ms.render / 1e3
    );
    text += &text_table(compared_header(methods), comparison(truth, limit, methods));
    for solved in methods {
        if let Some(reason) = &solved.estimate.reason {
            text += &["  ", &solved.estimate.method, ": ", reason, "\n"].concat();
        }
    }
    text += "\nTime, ms\n";
    text + &text_table(header(&["stage"], methods), timing(methods))
}
