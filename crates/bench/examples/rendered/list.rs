//! The sweeps: what changes, over which values, and how a value changes a scene.

use rodsight_scene::{Mode, PlainSensorEntry, SensorEntry, WaterEntry};

use crate::chart::scale::Spread::{Linear, Log};
use crate::scenes::draft::Draft;
use crate::scenes::looks::{self, LAMPS, SURFACES, WATERS};
use crate::scenes::ports::{self, PORTS};
use crate::swept::variable::Values::{Named, Of};
use crate::swept::variable::{Values, Variable};

/// One variable, and what a value of it does to a scene.
pub(crate) struct Sweep {
    pub(crate) variable: Variable,
    pub(crate) change: fn(&mut Draft, f64),
}

const fn sweep(
    name: &'static str,
    words: [&'static str; 2],
    values: Values,
    change: fn(&mut Draft, f64),
) -> Sweep {
    Sweep {
        variable: Variable::new(name, words, values),
        change,
    }
}

impl Sweep {
    pub(crate) fn draft(&self, value: f64, seed: u64) -> Draft {
        let mut draft = Draft::new(seed);
        (self.change)(&mut draft, value);
        draft
    }
}

/// Every sweep.
pub(crate) const SWEEPS: &[Sweep] = &[
    sweep(
        "water",
        ["Water", "Jerlov's type"],
        Named(WATERS),
        |draft, value| looks::water(draft, WATERS[value as usize]),
    ),
    sweep(
        "turbidity",
        [
            "Turbidity, with the halo (mode full)",
            "attenuation lengths from the cameras to the rod",
        ],
        Of(
            Linear,
            &[0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0],
        ),
        turbidity,
    ),
    sweep(
        "port",
        ["Flat ports", "what the solver takes them for"],
        Named(PORTS),
        |draft, value| ports::port(draft, PORTS[value as usize]),
    ),
    sweep(
        "texture",
        ["Surface of the rod", "surface"],
        Named(SURFACES),
        |draft, value| looks::surface(draft, SURFACES[value as usize]),
    ),
    sweep(
        "lamp",
        ["Lamps", "where the light comes from"],
        Named(LAMPS),
        |draft, value| looks::lamps(draft, LAMPS[value as usize]),
    ),
    sweep(
        "noise",
        [
            "Noise of the images",
            "noise (standard deviation), of 255 codes",
        ],
        Of(Log, &[0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0]),
        |draft, value| {
            draft.file.sensor = SensorEntry::Plain(PlainSensorEntry {
                noise_sigma_dn: value,
            });
        },
    ),
];

/// Coastal water of type 3C, thinned or thickened until the green band loses so many attenuation lengths on its way from the rod.
fn turbidity(draft: &mut Draft, lengths: f64) {
    const ABSORPTION_PER_M: [f64; 3] = [0.268, 0.132, 0.166];
    const SCATTERING_PER_M: [f64; 3] = [0.627, 0.654, 0.675];
    let attenuation_per_m = ABSORPTION_PER_M[1] + SCATTERING_PER_M[1];
    let thicker = lengths / (attenuation_per_m * draft.grasp_m().x);
    draft.file.mode = Mode::Full;
    draft.file.water = Some(WaterEntry {
        absorption_per_m: Some(ABSORPTION_PER_M.map(|a| thicker * a)),
        scattering_per_m: Some(SCATTERING_PER_M.map(|b| thicker * b)),
        ..WaterEntry::default()
    });
}
