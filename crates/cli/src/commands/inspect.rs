//! `rodsight inspect`.

use std::path::Path;

use anyhow::Context as _;
use rodsight_geometry::{Eye, Pixel, Vec3, degrees};
use rodsight_render::{EyeTruth, PairPaths, RodTruth, Truth, read_exr, read_image};

use crate::args::InspectArgs;
use crate::commands::{print_json, print_text};
use crate::failure::Failure;
use crate::page::{Figure, HtmlTable, Page, Section};
use crate::picture::{Annotation, Canvas, annotated, channel_panels, close_up};
use crate::progress::Progress;

pub(crate) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let paths = PairPaths::found_in(&args.folder);
    let truth = load_truth(&paths.truth_json)?;
    let progress = Progress::busy("drawing");
    let left = EyePictures::load(&truth, Eye::Left, &paths.left_image, &paths.left_exr)?;
    let right = EyePictures::load(&truth, Eye::Right, &paths.right_image, &paths.right_exr)?;

    // A row for each eye.
    let sheet_rows = [&left, &right].map(|eye| {
        let channels = eye.channels.iter().map(|(_, channel)| channel);
        let pictures = std::iter::once(&eye.whole).chain(&eye.near).chain(channels);
        pictures.map(|picture| picture.shrunk(640)).collect()
    });
    let sheet = args.folder.join("inspect.png");
    Canvas::sheet(&sheet_rows).write(&sheet)?;
    let page = args.folder.join("inspect.html");
    inspection_page(&truth, [&left, &right])?.write(&page)?;
    drop(progress);
    if args.json {
        return print_json(&truth);
    }
    let missing = if left.channels.is_empty() || right.channels.is_empty() {
        "no left.exr, right.exr: without depth, instances and scattered light (`rodsight render` writes them)\n"
    } else {
        ""
    };
    print_text(&format!(
        "{}\n{}\n{missing}{}",
        sheet.display(),
        page.display(),
        in_words(&truth)
    ))
}

fn load_truth(path: &Path) -> Result<Truth, Failure> {
    std::fs::read_to_string(path)
        .map_err(anyhow::Error::from)
        .and_then(|text| serde_json::from_str(&text).map_err(anyhow::Error::from))
        .with_context(|| format!("{}: expected the truth written by `rodsight render`", path.display()))
        .map_err(Failure::Input)
        .and_then(|truth: Truth| {
            truth.rig.to_rig(path).map_err(Failure::input)?;
            if truth.schema == Truth::SCHEMA && truth.grasp.rod < truth.rods.len() {
                return Ok(truth);
            }
            Err(Failure::Input(anyhow::anyhow!(
                "{}: expected schema {} and a grasp on one of its rods, found schema {}, grasp on rod {} of {}",
                path.display(),
                Truth::SCHEMA,
                truth.schema,
                truth.grasp.rod,
                truth.rods.len()
            )))
        })
}

/// The pictures of one eye.
struct EyePictures {
    eye: Eye,
    whole: Canvas,
    near: Option<Canvas>,
    /// Empty where there is no file of them.
    channels: Vec<(&'static str, Canvas)>,
}

impl EyePictures {
    fn load(truth: &Truth, eye: Eye, png: &Path, exr: &Path) -> Result<Self, Failure> {
        let camera = match eye {
            Eye::Left => &truth.rig.left,
            Eye::Right => &truth.rig.right,
        };
        let expected = (camera.width_px, camera.height_px);
        let check = |path: &Path, found: (u32, u32)| {
            let (path, (w, h), (found_w, found_h)) = (path.display(), expected, found);
            if found == expected {
                return Ok(());
            }
            Err(Failure::Input(anyhow::anyhow!(
                "{path}: expected {w}×{h} px as in truth.json, found {found_w}×{found_h}"
            )))
        };
        let image = read_image(png)?;
        check(png, (image.width_px(), image.height_px()))?;
        let mut channels = Vec::new();
        if exr.exists() {
            let frame = read_exr(exr)?;
            check(exr, (frame.width_px, frame.height_px))?;
            channels.extend(channel_panels(
                &frame,
                truth.white_balance.map(|balance| truth.gain * balance),
            ));
        }
        let annotation = Annotation {
            image: &image,
            truth: eye_truth(truth.target(), eye),
            found: Vec::new(),
            grasp_px: grasp_px(truth, eye),
        };
        Ok(Self {
            eye,
            whole: annotated(&annotation),
            near: close_up(&annotation, 160, 90, 10),
            channels,
        })
    }

    fn all(&self) -> Vec<(String, &Canvas)> {
        let name = self.eye.name();
        let whole = (
            format!("{name}: true limbs yellow, true axis green, grasp ×"),
            &self.whole,
        );
        let near = self
            .near
            .iter()
            .map(|near| (format!("{name}: around the grasp, ten times"), near));
        let channels = self
            .channels
            .iter()
            .map(|(what, picture)| (format!("{name}: {what}"), picture));
        std::iter::once(whole).chain(near).chain(channels).collect()
    }
}

pub(crate) fn eye_truth(rod: &RodTruth, eye: Eye) -> &EyeTruth {
    match eye {
        Eye::Left => &rod.left,
        Eye::Right => &rod.right,
    }
}

/// Where an eye sees the true grasp point.
pub(crate) fn grasp_px(truth: &Truth, eye: Eye) -> Option<Pixel> {
    let rig = truth.rig.to_rig(Path::new("truth.json")).ok()?;
    rig.eye(eye).project(&Vec3::from(truth.grasp.point_m))
}

fn inspection_page(truth: &Truth, eyes: [&EyePictures; 2]) -> Result<Page, Failure> {
    let mut sections = Vec::new();
    for eye in eyes {
        let figures: Result<Vec<_>, _> = eye
            .all()
            .into_iter()
            .map(|(caption, c)| Figure::new(c, caption))
            .collect();
        sections.push(Section {
            heading: format!("The {} eye", eye.eye.name()),
            text: String::new(),
            tables: Vec::new(),
            figures: figures?,
            columns: 2,
        });
    }
    sections.push(Section {
        heading: "What is true".to_owned(),
        text: "In the rig frame: x forward, y starboard, z down.".to_owned(),
        tables: vec![rods_table(truth)],
        figures: Vec::new(),
        columns: 1,
    });
    Ok(Page {
        title: format!("Truth of \"{}\"", truth.scene),
        lead: format!(
            "A stereo pair in {} water, mode {:?}, with what is to be found in it.",
            truth.water.label, truth.mode
        ),
        sections,
        provenance: provenance(truth),
    })
}

pub(crate) fn provenance(truth: &Truth) -> Vec<(String, String)> {
    [
        ("generator", truth.generator.clone()),
        ("scene", truth.scene.clone()),
        ("seed", truth.seed.to_string()),
        ("backend", truth.backend.clone()),
        ("adapter", truth.adapter.clone()),
        ("water", truth.water.label.clone()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

pub(crate) fn rods_table(truth: &Truth) -> HtmlTable {
    let metres = |v: &[f64; 3]| format!("{:.4}, {:.4}, {:.4}", v[0], v[1], v[2]);
    let header = [
        "rod",
        "point, m",
        "direction",
        "radius, mm",
        "to the baseline",
        "visible px (left, right)",
        "contrast/noise per limb (left; right)",
    ];
    let rows = truth.rods.iter().map(|rod| {
        vec![
            rod.id.clone(),
            metres(&rod.axis.point_m),
            metres(&rod.axis.direction),
            format!("{:.1}", rod.radius_m * 1e3),
            format!("{:.2}°", degrees(rod.angle_to_baseline_rad)),
            format!("{}, {}", rod.left.visible_px, rod.right.visible_px),
            format!("{}; {}", contrast(&rod.left), contrast(&rod.right)),
        ]
    });
    HtmlTable {
        caption: format!(
            "Rods; grasp on \"{}\" at {} m",
            truth.target().id,
            metres(&truth.grasp.point_m)
        ),
        header: header.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    }
}

fn contrast(eye: &EyeTruth) -> String {
    let [a, b] = eye
        .contrast_to_noise
        .map(|c| c.map_or_else(|| "–".to_owned(), |c| format!("{c:.1}")));
    format!("{a}, {b}")
}

fn in_words(truth: &Truth) -> String {
    let table = rods_table(truth);
    let named = |row: &Vec<String>| -> Vec<String> {
        let pairs = table.header.iter().zip(row);
        pairs
            .map(|(name, value)| format!("  {name}: {value}"))
            .collect()
    };
    let rows = table.rows.iter().flat_map(named);
    let mut lines: Vec<String> = std::iter::once(table.caption.clone()).chain(rows).collect();
    lines.push(String::new());
    lines.join("\n")
}
