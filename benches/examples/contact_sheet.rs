//! Every shipped scene in every water, mode and backend on one page, to be looked at: does it look like the sea?
//!
//!     cargo run --release -p rodsight-benches --example contact_sheet -- FOLDER [SCENE …]

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rodsight_geometry::{Camera, Intrinsics, MountedCamera, Rig};
use rodsight_optics::water;
use rodsight_render::{AdapterChoice, CpuRenderer, GpuRenderer, Renderer, develop, write_image};
use rodsight_scene::{Mode, Scene};

const WATERS: [&str; 6] = ["IB", "II", "III", "1C", "3C", "5C"];
const MODES: [Mode; 4] = [Mode::Air, Mode::Koschmieder, Mode::Single, Mode::Full];
/// Daylight for mode `koschmieder` in scenes that have none, W m⁻² sr⁻¹: it knows no lamps.
const DAYLIGHT: [f64; 3] = [0.02, 0.06, 0.06];
const WIDTH_PX: f64 = 320.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("expected a folder to write to")?);
    let wanted: Vec<String> = arguments.collect();
    std::fs::create_dir_all(&folder)?;
    let gpu = GpuRenderer::new(AdapterChoice::HardwareOrSoftware)?;
    let mut page = String::from(
        "<!doctype html><meta charset=\"utf-8\"><title>rodsight: scenes × waters × modes</title>\
         <style>body{font:14px sans-serif}td,th{padding:2px}img{width:240px;display:block}</style>",
    );
    for path in scenes()? {
        let scene = Scene::load(&path)?;
        if wanted.is_empty() || wanted.contains(&scene.id) {
            table(&folder, &scene, &[&CpuRenderer, &gpu], &mut page)?;
        }
    }
    std::fs::write(folder.join("index.html"), page)?;
    Ok(())
}

fn scenes() -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    paths.retain(|path| {
        path.extension()
            .is_some_and(|extension| extension == "toml")
    });
    paths.sort();
    Ok(paths)
}

/// One scene: a row a water, a column a mode and backend.
fn table(
    folder: &Path,
    scene: &Scene,
    backends: &[&dyn Renderer],
    page: &mut String,
) -> Result<(), Box<dyn Error>> {
    write!(page, "<h2>{}</h2><table><tr><th>", scene.id)?;
    for mode in MODES {
        for backend in backends {
            write!(page, "<th>{mode:?}, {}", backend.backend())?;
        }
    }
    for name in WATERS {
        let row = water::by_name(name).ok_or("a water of the table")?;
        write!(page, "<tr><th>{name}")?;
        for mode in MODES {
            for backend in backends {
                let mut scene = scene.clone();
                scene.rig = reduced(&scene.rig)?;
                scene.mode = mode;
                scene.medium = row.medium();
                if mode == Mode::Koschmieder && scene.ambient_radiance == [0.0; 3] {
                    scene.ambient_radiance = DAYLIGHT;
                }
                let frame = backend.render(&scene, &|_| ())?;
                let image = develop(&frame, &scene)?.left;
                let file = format!("{}_{name}_{mode:?}_{}.png", scene.id, backend.backend());
                write_image(&folder.join(&file), &image)?;
                write!(page, "<td><img src=\"{file}\" alt=\"{file}\">")?;
            }
        }
    }
    page.push_str("</table>");
    Ok(())
}

/// The same cameras with fewer pixels.
fn reduced(rig: &Rig) -> Result<Rig, Box<dyn Error>> {
    let camera = |mounted: &MountedCamera| -> Result<MountedCamera, Box<dyn Error>> {
        let i = mounted.camera.intrinsics();
        let scale = WIDTH_PX / f64::from(i.width_px);
        let intrinsics = Intrinsics {
            width_px: WIDTH_PX as u32,
            height_px: (f64::from(i.height_px) * scale) as u32,
            fx_px: i.fx_px * scale,
            fy_px: i.fy_px * scale,
            cx_px: i.cx_px * scale,
            cy_px: i.cy_px * scale,
        };
        Ok(MountedCamera {
            camera: Camera::new(intrinsics, *mounted.camera.distortion())?,
            ..*mounted
        })
    };
    Ok(Rig {
        left: camera(&rig.left)?,
        right: camera(&rig.right)?,
    })
}
