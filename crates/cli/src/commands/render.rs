//! `rodsight render`.

use std::path::Path;
use std::time::Instant;

use rodsight_render::{Developed, Frame, PairPaths, Truth, develop, write_pair};
use rodsight_scene::Scene;
use serde::Serialize;

use crate::args::{Backend, RenderArgs};
use crate::backend::Chosen;
use crate::commands::{print_json, print_text};
use crate::failure::{Failure, claim_output};
use crate::progress::Progress;

/// A rendered pair and how it came about.
pub(crate) struct Rendered {
    pub(crate) frame: Frame,
    pub(crate) developed: Developed,
    pub(crate) truth: Truth,
    /// Why this backend.
    pub(crate) why: String,
    pub(crate) timing_ms: RenderTiming,
}

/// Wall-clock times, ms.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct RenderTiming {
    pub(crate) render: f64,
    pub(crate) develop: f64,
    pub(crate) write: f64,
}

#[derive(Serialize)]
struct Summary<'a> {
    schema: u32,
    scene: &'a str,
    seed: u64,
    backend: &'a str,
    adapter: &'a str,
    backend_reason: &'a str,
    files: Vec<String>,
    timing_ms: RenderTiming,
}

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let mut scene = Scene::load(&args.scene).map_err(Failure::input)?;
    if let Some(seed) = args.seed {
        scene.seed = seed;
    }
    claim_output(&args.output)?;
    let mut rendered = render(&scene, args.backend).map_err(|failure| failure.of(&args.scene))?;
    let paths = write(&args.output, &scene, &mut rendered, Channels::Written)?;
    let mut files = vec![&paths.left_image, &paths.right_image];
    if rendered.developed.raw.is_some() {
        files.extend([&paths.left_raw, &paths.right_raw]);
    }
    files.extend([&paths.left_exr, &paths.right_exr]);
    let props = scene.props.iter();
    let props: Vec<_> = props
        .map(|prop| args.output.join(prop.written_file()))
        .collect();
    files.extend(&props);
    files.extend([&paths.rig_toml, &paths.scene_toml, &paths.truth_json]);
    if args.json {
        return print_json(&Summary {
            schema: 1,
            scene: &scene.id,
            seed: scene.seed,
            backend: rendered.frame.backend,
            adapter: &rendered.frame.adapter,
            backend_reason: &rendered.why,
            files: files
                .iter()
                .map(|path| path.display().to_string())
                .collect(),
            timing_ms: rendered.timing_ms,
        });
    }
    let [u_px, v_px] = rendered.truth.grasp.pick_px;
    let folder = args.output.display();
    let names = files.iter();
    let names = names.filter_map(|path| path.strip_prefix(&args.output).ok()?.to_str());
    let names: Vec<&str> = names.collect();
    let warning = rendered
        .truth
        .beyond_model
        .as_ref()
        .map_or(String::new(), |beyond| {
            let [left, right] = [beyond.left_share, beyond.right_share].map(|share| 100.0 * share);
            format!(
                "beyond the model: {left:.1} % of left, {right:.1} % of right: {}\n",
                beyond.meaning
            )
        });
    print_text(&format!(
        "{} rendered by the {} backend on {} ({}) in {:.1} s, written in {:.1} s\n\
         {folder}: {}\n{}\
         next: rodsight solve --left {} --right {} --rig {folder}/rig.toml --pick {u_px:.1},{v_px:.1},{}\n",
        scene.id,
        rendered.frame.backend,
        rendered.frame.adapter,
        rendered.why,
        rendered.timing_ms.render / 1e3,
        rendered.timing_ms.write / 1e3,
        names.join(" "),
        warning,
        paths.left_image.display(),
        paths.right_image.display(),
        rendered.truth.grasp.pick_eye.name(),
    ))
}

/// Renders and develops a scene, with progress.
pub(crate) fn render(scene: &Scene, backend: Backend) -> Result<Rendered, Failure> {
    let mut chosen = Chosen::new(backend)?;
    let progress = Progress::new(&format!("rendering {}", scene.id));
    let start = Instant::now();
    let frame = chosen.render(scene, &|fraction| progress.set(fraction))?;
    let render_ms = start.elapsed().as_secs_f64() * 1e3;
    let start = Instant::now();
    let developed = develop(&frame, scene)?;
    let develop_ms = start.elapsed().as_secs_f64() * 1e3;
    let truth = Truth::of(scene, &frame, developed.gain).ok_or_else(|| {
        Failure::Input(anyhow::anyhow!(
            "scene \"{}\": its grasp point cannot be picked",
            scene.id
        ))
    })?;
    Ok(Rendered {
        frame,
        developed,
        truth,
        why: chosen.why,
        timing_ms: RenderTiming {
            render: render_ms,
            develop: develop_ms,
            write: 0.0,
        },
    })
}

/// Whether the truth channels, 35 MB an eye, are wanted on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channels {
    Written,
    LeftOut,
}

/// Writes the pair and the resolved scene.
pub(crate) fn write(
    folder: &Path,
    scene: &Scene,
    rendered: &mut Rendered,
    channels: Channels,
) -> Result<PairPaths, Failure> {
    let _progress = Progress::busy("writing");
    let start = Instant::now();
    let frame = (channels == Channels::Written).then_some(&rendered.frame);
    let paths = write_pair(folder, scene, frame, &rendered.developed, &rendered.truth)?;
    rendered.timing_ms.write = start.elapsed().as_secs_f64() * 1e3;
    Ok(paths)
}
