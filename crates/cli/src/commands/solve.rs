//! `rodsight solve`.

use std::path::Path;

use anyhow::Context as _;
use rodsight_geometry::{Rig, config, degrees};
use rodsight_solver::{Estimate, Method, MovedPair, PaperParams, Request, Status, solve_traced};

use crate::also::{Also, stereo_pair};
use crate::args::SolveArgs;
use crate::commands::{print_json, print_text};
use crate::failure::{Failure, claim_output};
use crate::picture;
use crate::progress::Progress;
use crate::table::Table;

pub(crate) fn run(args: &SolveArgs) -> Result<(), Failure> {
    if args.method == Method::Joint {
        for (option, is_given) in [
            ("--trace", args.trace.is_some()),
            ("--params", args.params.is_some()),
        ] {
            if is_given {
                return Err(Failure::Input(anyhow::anyhow!(
                    "{option}: joint has no stages to draw and no parameters; expected --method paper or paper-bisector"
                )));
            }
        }
    } else if let Some(file) = args.also.first() {
        return Err(Failure::Input(anyhow::anyhow!(
            "--also {}: {} knows one pair only; expected --method joint",
            file.display(),
            args.method
        )));
    }
    let rig = Rig::load(&args.rig).map_err(Failure::input)?;
    let rig = (&rig, args.rig.as_path());
    let pair = stereo_pair(rig, &args.left, &args.right)?;
    let also: Vec<Also> = args
        .also
        .iter()
        .map(|file| Also::load(file, rig))
        .collect::<Result<_, _>>()?;
    let more: Vec<MovedPair<'_>> = also.iter().map(Also::moved).collect();
    let params = match &args.params {
        Some(path) => load_params(path)?,
        None => PaperParams::default(),
    };
    if let Some(folder) = &args.trace {
        claim_output(folder)?;
    }
    let request = Request {
        pair: &pair,
        roi_left: args.roi_left,
        roi_right: args.roi_right,
        pick: args.pick,
        radius: args.radius_m,
        calibration: args.calibration_sigma,
        more: &more,
    };
    let progress = Progress::busy("locating");
    let (estimate, trace) = solve_traced(&request, args.method, &params).map_err(Failure::input)?;
    if let (Some(folder), Some(trace)) = (&args.trace, &trace) {
        picture::write_trace(folder, trace)?;
    }
    drop(progress);
    if args.json {
        print_json(&estimate)?;
    } else {
        print_text(&in_words(&estimate))?;
    }
    if estimate.status == Status::Refused {
        Err(Failure::Refused)
    } else {
        Ok(())
    }
}

fn load_params(path: &Path) -> Result<PaperParams, Failure> {
    let params: PaperParams = config::read_text(path)
        .and_then(|text| config::parse_toml(&text, path))
        .map_err(Failure::input)?;
    params
        .validate()
        .with_context(|| path.display().to_string())
        .map_err(Failure::Input)?;
    Ok(params)
}

fn in_words(estimate: &Estimate) -> String {
    let mut table = Table::new(
        ["", "x forward", "y starboard", "z down", "σ"]
            .map(str::to_owned)
            .to_vec(),
    );
    let row = |table: &mut Table, name: &str, values: [f64; 3], digits: usize, sigma: String| {
        let [x, y, z] = values.map(|v| format!("{v:.digits$}"));
        table.row(vec![name.to_owned(), x, y, z, sigma]);
    };
    if let Some(axis) = &estimate.axis {
        if let Some(point) = axis.point_m {
            row(
                &mut table,
                "axis point, m",
                point,
                4,
                sigma_m(axis.covariance.map(|c| [c[0][0], c[1][1], c[2][2]])),
            );
        }
        if let Some(direction) = axis.direction {
            let sigma = axis
                .covariance
                .map(|c| libm::sqrt(c[3][3] + c[4][4] + c[5][5]));
            let sigma = sigma.map_or_else(String::new, |rad| format!("{:.3}°", degrees(rad)));
            row(&mut table, "axis direction", direction, 5, sigma);
        }
    }
    if let Some(grasp) = &estimate.grasp
        && let Some(point) = grasp.point_m
    {
        row(
            &mut table,
            "grasp, m",
            point,
            4,
            sigma_m(grasp.covariance_m2.map(|c| [c[0][0], c[1][1], c[2][2]])),
        );
    }
    let mut lines = vec![format!(
        "{}: {}",
        estimate.method,
        status_name(estimate.status)
    )];
    lines.extend(estimate.reason.iter().map(|reason| format!("  {reason}")));
    lines.extend(table.to_string().lines().map(str::to_owned));
    if let (Some(radius_m), Some(sigma_m)) = (estimate.radius_m, estimate.radius_sigma_m) {
        let [radius_mm, sigma_mm] = [radius_m, sigma_m].map(|v| v * 1e3);
        lines.push(format!("radius {radius_mm:.1} mm, σ {sigma_mm:.1} mm"));
    }
    lines.push(format!("{:.1} ms\n", estimate.timing_ms.total));
    lines.join("\n")
}

fn sigma_m(variances: Option<[f64; 3]>) -> String {
    variances.map_or_else(String::new, |v| {
        format!("{:.1} mm", libm::sqrt(v.iter().sum::<f64>()) * 1e3)
    })
}

pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Degraded => "degraded",
        Status::Refused => "refused",
    }
}
