//! The sweeps: what changes, over which values, and how a value changes the scene.

use crate::chart::scale::Spread;
use crate::painted::draft::{Draft, Trial};
use crate::swept::variable::{Values, Variable};
use crate::targets as to;

/// One variable. What a value does to the place of things is done before regions and pick are put on the rod, what it does to their
/// looks after.
#[derive(Clone, Copy)]
pub(crate) struct Sweep {
    pub(crate) variable: Variable,
    pub(crate) place: fn(&mut Draft, f64),
    pub(crate) dress: fn(&mut Trial, f64),
}

const fn placed(
    name: &'static str,
    words: [&'static str; 2],
    values: Values,
    place: fn(&mut Draft, f64),
) -> Sweep {
    Sweep {
        variable: Variable::new(name, words, values),
        place,
        dress: to::same_looks,
    }
}

const fn dressed(
    name: &'static str,
    words: [&'static str; 2],
    values: Values,
    dress: fn(&mut Trial, f64),
) -> Sweep {
    Sweep {
        variable: Variable::new(name, words, values),
        place: to::same_place,
        dress,
    }
}

use Spread::{Even, Linear, Log};
use Values::{Named, Of};

/// Every sweep.
pub(crate) const SWEEPS: &[Sweep] = &[
    dressed(
        "contrast",
        ["Contrast over noise", "contrast over noise of the limbs"],
        Of(Log, &[0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0]),
        to::contrast,
    ),
    dressed(
        "turbidity",
        ["Turbidity", "attenuation by haze, 1/m"],
        Of(Log, &[0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4, 2.0, 3.0]),
        to::haze,
    ),
    placed(
        "baseline-angle",
        ["Angle to the baseline", "angle of rod and baseline, °"],
        Of(
            Even,
            &[
                0.0, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 40.0, 60.0, 90.0,
            ],
        ),
        to::baseline_angle,
    ),
    placed(
        "baseline",
        ["Baseline", "baseline, m"],
        Of(Log, &[0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5]),
        to::baseline,
    ),
    placed(
        "distance",
        ["Distance", "distance ahead of the cameras, m"],
        Of(Log, &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0]),
        to::distance,
    ),
    placed(
        "radius",
        ["Radius", "radius of the rod, mm"],
        Of(Log, &[5.0, 10.0, 20.0, 30.0, 50.0, 100.0, 200.0, 300.0]),
        |draft, value| draft.scene.rods[0].radius_m = 1e-3 * value,
    ),
    placed(
        "obliquity",
        ["Obliquity", "tilt of the rod along the view, °"],
        Of(Linear, &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0]),
        to::obliquity,
    ),
    dressed(
        "lamp",
        ["Lamps", "where the light comes from"],
        Named(&["between", "outboard", "far aside", "above", "ambient"]),
        to::lamp,
    ),
    dressed(
        "colour",
        ["Colour of the rod", "colour of the rod"],
        Named(&["white", "grey", "black", "water's hue", "orange"]),
        to::colour,
    ),
    dressed(
        "bands",
        [
            "Bands around the rod",
            "how much darker every other band is, %",
        ],
        Of(Linear, &[0.0, 10.0, 25.0, 50.0, 75.0, 90.0]),
        to::bands,
    ),
    dressed(
        "patches",
        ["Patches on the rod", "how much darker patches may be, %"],
        Of(Linear, &[0.0, 10.0, 25.0, 50.0, 75.0, 95.0]),
        to::patches,
    ),
    dressed(
        "occlusion",
        ["Occlusion", "share of the limbs that is hidden, %"],
        Of(Linear, &[0.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]),
        to::occlusion,
    ),
    placed(
        "cut-width",
        [
            "Cut by the left region's border",
            "share of the rod's width in the left region, %",
        ],
        Of(Linear, &[20.0, 40.0, 60.0, 80.0, 90.0, 100.0, 110.0, 130.0]),
        to::cut_width,
    ),
    placed(
        "cut-length",
        [
            "Little of the rod's length in the regions",
            "height of the regions, px",
        ],
        Of(Log, &[20.0, 30.0, 50.0, 70.0, 100.0, 200.0, 400.0, 700.0]),
        to::cut_length,
    ),
    dressed(
        "bend",
        ["Bend", "sagitta, % of a metre of rod"],
        Of(Linear, &[0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]),
        to::bend,
    ),
    dressed(
        "snow",
        ["Marine snow", "flakes within 3 m, count"],
        Of(Even, &[0.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0]),
        to::snow,
    ),
    dressed(
        "distractors",
        [
            "Other rods, parallel to it",
            "parallel rods behind it, count",
        ],
        Of(Even, &[0.0, 1.0, 2.0, 3.0, 4.0, 6.0]),
        to::distractors,
    ),
    placed(
        "calibration-declared",
        [
            "Calibration error that is declared",
            "calibration error of an eye, px (standard deviation)",
        ],
        Of(Even, &[0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]),
        |draft, value| to::calibration(draft, value, true),
    ),
    placed(
        "calibration-undeclared",
        [
            "Calibration error that is not declared",
            "calibration error of an eye, px (standard deviation)",
        ],
        Of(Even, &[0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]),
        |draft, value| to::calibration(draft, value, false),
    ),
    dressed(
        "blur",
        ["Blur of the lens", "blur (standard deviation), px"],
        Of(Log, &[0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0]),
        |trial, value| trial.scene.blur_px = value,
    ),
];
