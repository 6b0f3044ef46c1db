//! What the demo draws: overlays, close-ups, the paper's figure 6, and the page that holds all of it.

use std::path::Path;

use rodsight_bench::Limit;
use rodsight_geometry::Eye;
use rodsight_solver::EyeTrace;

use super::{Solved, compared_header, comparison, header, timing};
use crate::commands::inspect::{eye_truth, grasp_px, provenance, rods_table};
use crate::commands::render::Rendered;
use crate::failure::Failure;
use crate::page::{Figure, HtmlTable, Page, Section};
use crate::picture::{
    Annotation, CYAN, Canvas, Colour, MAGENTA, WHITE, annotated, close_up, figure6,
};

const METHOD_COLOURS: [(Colour, &str); 3] =
    [(MAGENTA, "magenta"), (CYAN, "cyan"), (WHITE, "white")];

fn annotation<'a>(rendered: &'a Rendered, methods: &[Solved], eye: Eye) -> Annotation<'a> {
    let found = methods
        .iter()
        .zip(METHOD_COLOURS)
        .filter_map(|(solved, (colour, _))| {
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

/// The paper's steps in an eye.
fn steps(methods: &[Solved], eye: Eye) -> Option<&EyeTrace> {
    let trace = methods.iter().find_map(|solved| solved.trace.as_ref())?;
    Some(match eye {
        Eye::Left => &trace.left,
        Eye::Right => &trace.right,
    })
}

pub(super) fn write(folder: &Path, rendered: &Rendered, methods: &[Solved]) -> Result<(), Failure> {
    for eye in Eye::BOTH {
        let name = eye.name();
        let annotation = annotation(rendered, methods, eye);
        annotated(&annotation).write(&folder.join(format!("overlay-{name}.png")))?;
        if let Some(near) = close_up(&annotation, 160, 90, 10) {
            near.write(&folder.join(format!("closeup-{name}.png")))?;
        }
        if let Some(trace) = steps(methods, eye) {
            for (panel, _, picture) in figure6(trace) {
                picture.write(&folder.join(format!("figure6-{name}-{panel}.png")))?;
            }
        }
    }
    summary(rendered, methods).write(&folder.join("summary.png"))
}

/// The left eye in one strip: overlay, close-up, and the method's steps, all of one height.
fn summary(rendered: &Rendered, methods: &[Solved]) -> Canvas {
    const HEIGHT_PX: u32 = 360;
    let annotation = annotation(rendered, methods, Eye::Left);
    let steps = steps(methods, Eye::Left).map(figure6);
    let pictures = std::iter::once(annotated(&annotation))
        .chain(close_up(&annotation, 160, 90, 10))
        .chain(steps.into_iter().flatten().map(|(_, _, picture)| picture));
    Canvas::sheet(&[pictures
        .map(|picture| picture.of_height(HEIGHT_PX))
        .collect()])
}

pub(super) fn page(
    rendered: &Rendered,
    limit: Option<&Limit>,
    methods: &[Solved],
) -> Result<Page, Failure> {
    let truth = &rendered.truth;
    let colours: Vec<String> = methods
        .iter()
        .zip(METHOD_COLOURS)
        .map(|(solved, (_, colour))| format!("{} {colour}", solved.estimate.method))
        .collect();
    let legend = format!(
        "true limbs yellow, true axis green; found axes: {}",
        colours.join(", ")
    );
    let mut pairs = Vec::new();
    let mut overlays = Vec::new();
    let mut panels = Vec::new();
    for eye in Eye::BOTH {
        let annotation = annotation(rendered, methods, eye);
        let image = Canvas::of_whole_image(annotation.image);
        pairs.push(Figure::new(
            &image,
            format!("{} image, as the sensor gives it", eye.name()),
        )?);
        overlays.push(Figure::new(
            &annotated(&annotation),
            format!("{} image: {legend}", eye.name()),
        )?);
        if let Some(near) = close_up(&annotation, 160, 90, 10) {
            overlays.push(Figure::new(
                &near,
                format!("{}: around the grasp, ten times", eye.name()),
            )?);
        }
        if let Some(trace) = steps(methods, eye) {
            for (_, caption, picture) in figure6(trace) {
                panels.push(Figure::new(&picture, format!("{}: {caption}", eye.name()))?);
            }
        }
    }
    let section = |heading: &str,
                   text: &str,
                   tables: Vec<HtmlTable>,
                   figures: Vec<Figure>,
                   columns: usize| Section {
        heading: heading.to_owned(),
        text: text.to_owned(),
        tables,
        figures,
        columns,
    };
    let compared = HtmlTable {
        caption: "In the rig frame: x forward, y starboard, z down".to_owned(),
        header: compared_header(methods),
        rows: comparison(truth, limit, methods),
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
