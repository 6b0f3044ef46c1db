//! `rodsight demo`.

use std::path::Path;

use anyhow::Context as _;
use rodsight_geometry::{Eye, StereoPair, degrees};
use rodsight_render::Truth;
use rodsight_scene::Scene;
use rodsight_solver::{Estimate, EyeTrace, Method, PaperParams, Pick, Request, Roi, TimingMs, Trace, solve_traced};
use serde::Serialize;

use crate::args::DemoArgs;
use crate::commands::inspect::{eye_truth, grasp_px, provenance, rods_table};
use crate::commands::render::{RenderTiming, Rendered, render, write};
use crate::commands::solve::status_name;
use crate::commands::{print_json, print_text};
use crate::failure::{Failure, claim_output};
use crate::page::{Figure, HtmlTable, Page, Section};
use crate::picture::{Annotation, CYAN, Canvas, Colour, MAGENTA, annotated, close_up, figure6};
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
    trace: Trace,
}

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let scene = Scene::from_toml(PAPER_SCENE, Path::new("scenes/paper.toml")).map_err(Failure::input)?;
    claim_output(&args.output)?;
    let mut rendered = render(&scene)?;
    let methods = solve_all(&scene, &rendered)?;
    write(&args.output, &scene, &mut rendered)?;
    write_pictures(&args.output, &rendered, &methods)?;
    let result =
        DemoResult { schema: 1, truth: &rendered.truth, methods, render_timing_ms: rendered.timing_ms };
    let path = args.output.join("result.json");
    std::fs::write(&path, serde_json::to_vec_pretty(&result).map_err(Failure::failed)?)
        .with_context(|| path.display().to_string())
        .map_err(Failure::Input)?;
    let index = args.output.join("index.html");
    page(&rendered, &result.methods)?.write(&index)?;
    if args.json {
        return print_json(&result);
    }
    print_text(&in_words(&rendered, &result.methods))?;
    print_text(&format!("\n{}\n", index.display()))
}

fn solve_all(scene: &Scene, rendered: &Rendered) -> Result<Vec<Solved>, Failure> {
    let pair = StereoPair::new(scene.rig, rendered.developed.left.clone(), rendered.developed.right.clone())
        .map_err(Failure::input)?;
    let truth = &rendered.truth;
    let request = Request {
        pair: &pair,
        roi_left: region(rendered, Eye::Left),
        roi_right: region(rendered, Eye::Right),
        pick: Some(Pick { pixel: truth.grasp.pick_px.into(), eye: truth.grasp.pick_eye }),
        radius: None,
    };
    Method::ALL
        .iter()
        .map(|&method| {
            let (estimate, trace) = solve_traced(&request, method, &PaperParams::default()).map_err(Failure::input)?;
            Ok(Solved { errors: Errors::of(&estimate, truth), estimate, trace })
        })
        .collect()
}

/// The region an operator would draw: the rod's pixels and some more.
fn region(rendered: &Rendered, eye: Eye) -> Option<Roi> {
    let frame = rendered.frame.eye(eye);
    let instance = rendered.truth.target().instance;
    let seen = |column: u32, row: u32| frame.at(column, row).instance == instance;
    let columns = (0..frame.width_px).filter(|&column| (0..frame.height_px).any(|row| seen(column, row)));
    let rows = (0..frame.height_px).filter(|&row| (0..frame.width_px).any(|column| seen(column, row)));
    let span = |indices: Vec<u32>, size: u32| {
        let from = indices.first()?.saturating_sub(REGION_MARGIN_PX);
        Some((from, (indices.last()? + 1 + REGION_MARGIN_PX).min(size) - from))
    };
    let (x_px, width_px) = span(columns.collect(), frame.width_px)?;
    let (y_px, height_px) = span(rows.collect(), frame.height_px)?;
    Some(Roi { x_px, y_px, width_px, height_px })
}

const METHOD_COLOURS: [(Colour, &str); 2] = [(MAGENTA, "magenta"), (CYAN, "cyan")];

fn annotation<'a>(rendered: &'a Rendered, methods: &[Solved], eye: Eye) -> Annotation<'a> {
    let found = methods.iter().zip(METHOD_COLOURS).filter_map(|(solved, (colour, _))| {
        let lines = solved.estimate.centerlines.as_ref()?;
        let line = match eye {
            Eye::Left => lines.left,
            Eye::Right => lines.right,
        };
        Some((line?, colour))
    });
    Annotation {
        image: rendered.developed.eye(eye),
        truth: eye_truth(rendered.truth.target(), eye),
        found: found.collect(),
        grasp_px: grasp_px(&rendered.truth, eye),
    }
}

fn eye_trace(solved: &Solved, eye: Eye) -> &EyeTrace {
    match eye {
        Eye::Left => &solved.trace.left,
        Eye::Right => &solved.trace.right,
    }
}

fn write_pictures(folder: &Path, rendered: &Rendered, methods: &[Solved]) -> Result<(), Failure> {
    for eye in Eye::BOTH {
        let name = eye.name();
        let annotation = annotation(rendered, methods, eye);
        annotated(&annotation).write(&folder.join(format!("overlay-{name}.png")))?;
        if let Some(near) = close_up(&annotation, 160, 90, 10) {
            near.write(&folder.join(format!("closeup-{name}.png")))?;
        }
        if let Some(solved) = methods.first() {
            for (panel, _, picture) in figure6(eye_trace(solved, eye)) {
                picture.write(&folder.join(format!("figure6-{name}-{panel}.png")))?;
            }
        }
    }
    Ok(())
}

/// Name and value of every number that is compared.
fn comparison(truth: &Truth, methods: &[Solved]) -> Vec<Vec<String>> {
    let millimetres = |v: f64| format!("{:.2}", v * 1e3);
    let metres = |v: [f64; 3]| format!("{:.4}, {:.4}, {:.4}", v[0], v[1], v[2]);
    let row = |name: &str, true_value: String, value: &dyn Fn(&Solved) -> Option<String>| {
        let cells = methods.iter().map(|solved| value(solved).unwrap_or_else(|| "–".to_owned()));
        [name.to_owned(), true_value].into_iter().chain(cells).collect::<Vec<_>>()
    };
    let error = |pick: fn(&Errors) -> Option<f64>, show: fn(f64) -> String| {
        move |solved: &Solved| solved.errors.as_ref().and_then(pick).map(show)
    };
    let mm: fn(f64) -> String = |v| format!("{:.2}", v * 1e3);
    vec![
        row("status", String::new(), &|s| Some(status_name(s.estimate.status).to_owned())),
        row("grasp, m", metres(truth.grasp.point_m), &|s| Some(metres(s.estimate.grasp.as_ref()?.point_m?))),
        row("direction", metres(truth.grasp.axis.direction), &|s| Some(metres(s.estimate.axis.as_ref()?.direction?))),
        row("radius, mm", millimetres(truth.target().radius_m), &|s| s.estimate.radius_m.map(millimetres)),
        row("error: axis at the grasp, mm", "0".to_owned(), &error(|e| Some(e.axis_offset_m), mm)),
        row("error: axis angle, °", "0".to_owned(), &error(|e| Some(degrees(e.axis_angle_rad)), |v| format!("{v:.3}"))),
        row("error: grasp across the rod, mm", "0".to_owned(), &error(|e| e.grasp_across_m, mm)),
        row("error: grasp along the rod, mm", "0".to_owned(), &error(|e| e.grasp_along_m, mm)),
        row("error: radius, mm", "0".to_owned(), &error(|e| e.radius_m, mm)),
    ]
}

fn timing(methods: &[Solved]) -> Vec<Vec<String>> {
    let stage = |name: &str, value: fn(&TimingMs) -> f64| {
        let cells = methods.iter().map(|solved| format!("{:.2}", value(&solved.estimate.timing_ms)));
        std::iter::once(name.to_owned()).chain(cells).collect::<Vec<_>>()
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

fn in_words(rendered: &Rendered, methods: &[Solved]) -> String {
    let text_table = |header: Vec<String>, rows: Vec<Vec<String>>| {
        let mut table = Table::new(header);
        rows.into_iter().for_each(|row| table.row(row));
        table.to_string()
    };
    let truth = &rendered.truth;
    let mut text = format!(
        "{} in {} water, rendered by the {} backend on {} in {:.1} s\n\n",
        truth.scene,
        truth.water.label,
        truth.backend,
        truth.adapter,
        rendered.timing_ms.render / 1e3
    );
    text += &text_table(header(&["", "truth"], methods), comparison(truth, methods));
    for solved in methods {
        if let Some(reason) = &solved.estimate.reason {
            text += &format!("  {}: {reason}\n", solved.estimate.method);
        }
    }
    text += "\nTime, ms\n";
    text + &text_table(header(&["stage"], methods), timing(methods))
}

fn page(rendered: &Rendered, methods: &[Solved]) -> Result<Page, Failure> {
    let truth = &rendered.truth;
    let colours: Vec<String> = methods
        .iter()
        .zip(METHOD_COLOURS)
        .map(|(solved, (_, colour))| format!("{} {colour}", solved.estimate.method))
        .collect();
    let legend = format!("true limbs yellow, true axis green; found axes: {}", colours.join(", "));
    let mut pairs = Vec::new();
    let mut overlays = Vec::new();
    let mut panels = Vec::new();
    for eye in Eye::BOTH {
        let annotation = annotation(rendered, methods, eye);
        let image = Canvas::of_whole_image(annotation.image);
        pairs.push(Figure::new(&image, format!("{} image, as the sensor gives it", eye.name()))?);
        overlays.push(Figure::new(&annotated(&annotation), format!("{} image: {legend}", eye.name()))?);
        if let Some(near) = close_up(&annotation, 160, 90, 10) {
            overlays.push(Figure::new(&near, format!("{}: around the grasp, ten times", eye.name()))?);
        }
        if let Some(solved) = methods.first() {
            for (_, caption, picture) in figure6(eye_trace(solved, eye)) {
                panels.push(Figure::new(&picture, format!("{}: {caption}", eye.name()))?);
            }
        }
    }
    let section = |heading: &str, text: &str, tables: Vec<HtmlTable>, figures: Vec<Figure>, columns: usize| Section {
        heading: heading.to_owned(),
        text: text.to_owned(),
        tables,
        figures,
        columns,
    };
    let compared = HtmlTable {
        caption: "In the rig frame: x forward, y starboard, z down".to_owned(),
        header: header(&["", "truth"], methods),
        rows: comparison(truth, methods),
    };
    let times = HtmlTable {
        caption: "Wall-clock time of each stage, ms (both eyes side by side)".to_owned(),
        header: header(&["stage"], methods),
        rows: timing(methods),
    };
    Ok(Page {
        title: "rodsight: the founding scene".to_owned(),
        lead: format!(
            "A cable under water ({}), seen by two cameras a metre apart: where it is, where it was found, and how far off that is.",
            truth.water.label
        ),
        sections: vec![
            section("The pair", "", Vec::new(), pairs, 2),
            section(
                "Truth and estimates",
                "Both methods start from the same edges. The paper averages the two limbs of each image, which puts the axis r²/Z too \
                 near; paper-bisector takes the plane that bisects the two tangent planes.",
                vec![compared, rods_table(truth), times],
                Vec::new(),
                1,
            ),
            section("Overlay", "", Vec::new(), overlays, 2),
            section(
                "The paper's figure 6",
                "Pixels taken for rod (brown) and their edges (white), Hough's lines (cyan), the lines fitted to the edges nearby (magenta).",
                Vec::new(),
                panels,
                4,
            ),
        ],
        provenance: provenance(truth),
    })
}

/// TEMP
#[derive(Serialize)]
struct Errors { axis_offset_m: f64, axis_angle_rad: f64, grasp_across_m: Option<f64>, grasp_along_m: Option<f64>, radius_m: Option<f64> }
impl Errors {
    fn of(e: &Estimate, t: &Truth) -> Option<Self> {
        use rodsight_geometry::{Line3, Vec3};
        let a = e.axis.as_ref()?;
        let axis = Line3::new(a.point_m?.into(), &Vec3::from(a.direction?));
        let g: Vec3 = t.grasp.point_m.into();
        let ta = Line3::new(g, &Vec3::from(t.grasp.axis.direction));
        let d = e.grasp.as_ref().and_then(|x| x.point_m).map(|p| Vec3::from(p) - g);
        Some(Self { axis_offset_m: axis.distance_m(&g), axis_angle_rad: axis.angle_to(&ta),
            grasp_across_m: d.map(|d| (d - ta.direction * ta.direction.dot(&d)).norm()), grasp_along_m: d.map(|d| d.dot(&ta.direction)), radius_m: e.radius_m.map(|r| r - t.target().radius_m) })
    }
}
