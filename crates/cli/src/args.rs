//! What can be typed.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use rodsight_geometry::{Eye, Pixel, radians};
use rodsight_solver::{CalibrationSigma, Method, Pick, RadiusPrior, Roi};

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 bad usage or input, 3 refused or gate not met, 4 no adapter, 75 retry later, 130 interrupted.";

/// Renders ground-truth stereo pairs of rods under water, locates the rod in such a pair, and measures how accurate that was.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = EXIT_CODES, arg_required_else_help = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render the founding scene, locate the rod by every method, compare with the truth, make a page of it
    Demo(DemoArgs),
    /// Render one ground-truth stereo pair with every truth channel
    Render(RenderArgs),
    /// Locate the rod in a stereo pair
    Solve(Box<SolveArgs>),
    /// Draw the truth of a rendered pair on its images
    Inspect(InspectArgs),
    /// Print the JSON Schema of a file format
    Schema(SchemaArgs),
    /// Print a completion script for a shell
    Completions(CompletionsArgs),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  rodsight demo
  rodsight demo -o /tmp/demo --json | jq '.methods[].errors.axis_offset_m'

Writes index.html (all of it on one page), result.json, summary.png, the pictures, and the pair as `rodsight render` does but for the
truth channels (left.exr right.exr).")]
pub(crate) struct DemoArgs {
    /// Folder to write to
    #[arg(short, long, default_value = "rodsight-demo")]
    pub(crate) output: PathBuf,
    /// What renders: auto takes a graphics card if there is one, or else the cpu, and says which and why
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(crate) backend: Backend,
    /// Print result.json instead of tables
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  rodsight render scenes/paper.toml -o pair
  rodsight solve --left pair/left.png --right pair/right.png --rig pair/rig.toml --pick 1029.3,637.0

Writes left.png right.png (the sensor's images; left.jpg right.jpg if the scene asks for JPEG, and left_raw.png right_raw.png if it
asks for raw codes), left.exr right.exr (linear radiance as R, G, B and every truth channel by name), props/ID.glb (the mesh of each
prop), rig.toml, scene.toml (the scene with every default written out) and truth.json.")]
pub(crate) struct RenderArgs {
    /// Scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Folder to write to
    #[arg(short, long)]
    pub(crate) output: PathBuf,
    /// What renders: auto takes a graphics card if there is one, or else the cpu, and says which and why
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(crate) backend: Backend,
    /// Seed instead of the scene's: texture, stones, growth, snow and noise
    #[arg(long, allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Print a summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Backend {
    /// A graphics card if there is one, or else the cpu
    Auto,
    /// The f64 reference renderer
    Cpu,
    /// A graphics card, or a software Vulkan driver; exits with 4 if there is neither
    Gpu,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  rodsight solve --left pair/left.png --right pair/right.png --rig pair/rig.toml --pick 1029.3,637.0
  rodsight solve --left l.png --right r.png --rig camchain.yaml --roi-left 700,0,640,1080 --roi-right 80,0,640,1080 \\
      --pick 1029,637,left --radius-m 0.05,0.001 --calibration-sigma 0.05,0.02 --json
  rodsight solve --left l.png --right r.png --rig camchain.yaml --method paper --trace steps
  rodsight solve --left pair/left.png --right pair/right.png --rig pair/rig.toml --also heaved.toml

heaved.toml is a second pair of the same rod, taken 0.3 m higher (`rodsight schema also` has all keys):
  schema = 1
  left = \"heaved/left.png\"
  right = \"heaved/right.png\"
  rig_from_moved = { rpy_deg = [0, 0, 0], translation_m = [0, 0, -0.3] }
  sigma = { translation_m = 0.002, rotation_deg = 0.05 }

Everything in the answer is in the rig frame: x forward, y starboard, z down. Regions and picks are image pixels from the
top-left corner, whatever origin the rig file declares. A refusal prints its reason (and its JSON) and exits with 3.")]
pub(crate) struct SolveArgs {
    /// Left image (PNG or JPEG; grey or RGB, 8 or 16 bits)
    #[arg(long)]
    pub(crate) left: PathBuf,
    /// Right image
    #[arg(long)]
    pub(crate) right: PathBuf,
    /// Rig: a rodsight TOML, an OpenCV stereo YAML or a Kalibr camchain YAML
    #[arg(long)]
    pub(crate) rig: PathBuf,
    /// A further pair of the same rod, from where the rig went: images, move and how well that is known (TOML); joint fits one rod to
    /// all pairs, which places also what is parallel to the baseline
    #[arg(long, value_name = "PAIR.toml")]
    pub(crate) also: Vec<PathBuf>,
    /// Region of the left image, pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_roi, allow_hyphen_values = true)]
    pub(crate) roi_left: Option<Roi>,
    /// Region of the right image, pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_roi, allow_hyphen_values = true)]
    pub(crate) roi_right: Option<Roi>,
    /// Where to grasp, pixels, in the left image unless it says right
    #[arg(long, value_name = "U,V[,left|right]", value_parser = parse_pick, allow_hyphen_values = true)]
    pub(crate) pick: Option<Pick>,
    /// Radius of the rod if it is known, m, and its standard deviation
    #[arg(long, value_name = "R[,SIGMA]", value_parser = parse_radius, allow_hyphen_values = true)]
    pub(crate) radius_m: Option<RadiusPrior>,
    /// How to locate it
    #[arg(long, default_value = Method::Joint.name(), value_parser = parse_method)]
    pub(crate) method: Method,
    /// How well the cameras are known: standard deviation of where an eye sees anything, px, and of its roll, degrees; joint adds
    /// it to what it is not sure of
    #[arg(long, value_name = "PX[,ROLL_DEG]", value_parser = parse_calibration, allow_hyphen_values = true)]
    pub(crate) calibration_sigma: Option<CalibrationSigma>,
    /// Parameters of the paper's methods (TOML); what it does not name keeps its default
    #[arg(long)]
    pub(crate) params: Option<PathBuf>,
    /// Write edges, votes and lines of the paper's methods (its figure 6) as PNG to this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) trace: Option<PathBuf>,
    /// Print the answer as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  rodsight render scenes/paper.toml -o pair && rodsight inspect pair

Writes FOLDER/inspect.png: per eye the image with the true axis (green), limbs (yellow) and pick, its close-up, and, where
there is left.exr right.exr, depth, instances and the light scattered by the water; and FOLDER/inspect.html with the numbers.")]
pub(crate) struct InspectArgs {
    /// Folder written by `rodsight render` or `rodsight demo`
    pub(crate) folder: PathBuf,
    /// Print the truth's numbers as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  rodsight schema scene > scene.schema.json")]
pub(crate) struct SchemaArgs {
    /// Which format
    #[arg(value_enum)]
    pub(crate) format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Scene files
    Scene,
    /// Rig files
    Rig,
    /// What `rodsight solve --json` prints
    Result,
    /// truth.json
    Truth,
    /// Parameters of the paper's methods
    Params,
    /// Further pairs for `rodsight solve --also`
    Also,
}

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  rodsight completions bash > ~/.local/share/bash-completion/completions/rodsight"
)]
pub(crate) struct CompletionsArgs {
    /// Which shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

fn numbers<T: std::str::FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(',')
        .map(|part| part.trim().parse().ok())
        .collect()
}

fn parse_roi(text: &str) -> Result<Roi, String> {
    match numbers::<u32>(text).as_deref() {
        Some(&[x_px, y_px, width_px, height_px]) => Ok(Roi {
            x_px,
            y_px,
            width_px,
            height_px,
        }),
        _ => Err(
            "expected four whole numbers of pixels, x,y,width,height, as 700,0,640,1080".to_owned(),
        ),
    }
}

fn parse_pick(text: &str) -> Result<Pick, String> {
    let (coordinates, eye) = match text.rsplit_once(',') {
        Some((rest, "left")) => (rest, Eye::Left),
        Some((rest, "right")) => (rest, Eye::Right),
        _ => (text, Eye::Left),
    };
    match numbers::<f64>(coordinates).as_deref() {
        Some(&[u_px, v_px]) if u_px.is_finite() && v_px.is_finite() => Ok(Pick {
            pixel: Pixel::new(u_px, v_px),
            eye,
        }),
        _ => Err("expected two numbers and perhaps an eye, as 1029.3,637.0,left".to_owned()),
    }
}

fn parse_radius(text: &str) -> Result<RadiusPrior, String> {
    match numbers::<f64>(text).as_deref() {
        Some(&[radius_m]) => Ok(RadiusPrior {
            radius_m,
            sigma_m: None,
        }),
        Some(&[radius_m, sigma_m]) => Ok(RadiusPrior {
            radius_m,
            sigma_m: Some(sigma_m),
        }),
        _ => Err("expected metres, as 0.05 or 0.05,0.001".to_owned()),
    }
}

fn parse_calibration(text: &str) -> Result<CalibrationSigma, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    let (pixel_px, roll_deg) = match numbers.as_deref() {
        Ok(&[pixel_px]) => (pixel_px, 0.0),
        Ok(&[pixel_px, roll_deg]) => (pixel_px, roll_deg),
        _ => return Err("expected pixels and degrees, as 0.05 or 0.05,0.02".to_owned()),
    };
    Ok(CalibrationSigma {
        pixel_px,
        roll_rad: radians(roll_deg),
    })
}

fn parse_method(text: &str) -> Result<Method, String> {
    text.parse::<Method>().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn arguments_are_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn pick_takes_an_eye_or_means_the_left_one() {
        assert_eq!(
            parse_pick("3,4").unwrap(),
            Pick {
                pixel: Pixel::new(3.0, 4.0),
                eye: Eye::Left
            }
        );
        assert_eq!(
            parse_pick("3.5,-4,right").unwrap(),
            Pick {
                pixel: Pixel::new(3.5, -4.0),
                eye: Eye::Right
            }
        );
        for bad in ["3", "3,4,5", "a,b", "3,NaN", "3,4,up", ""] {
            assert!(parse_pick(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn region_is_four_whole_numbers() {
        assert_eq!(
            parse_roi("1,2,3,4").unwrap(),
            Roi {
                x_px: 1,
                y_px: 2,
                width_px: 3,
                height_px: 4
            }
        );
        for bad in ["1,2,3", "1,2,3,4,5", "-1,2,3,4", "1.5,2,3,4"] {
            assert!(parse_roi(bad).is_err(), "{bad}");
        }
    }
}
