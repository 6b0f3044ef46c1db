//! Water, lamps and surfaces by their names.

use rodsight_geometry::Vec3;
use rodsight_scene::{
    DaylightEntry, FoulingEntry, GlossEntry, GrainEntry, LampEntry, StripesEntry, SurfaceEntry,
    WaterEntry,
};

use super::draft::Draft;
use crate::asked::dice::Dice;

/// From clear to turbid, as the table of waters has them.
pub(crate) const WATERS: &[&str] = &["I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"];
pub(crate) const LAMPS: &[&str] = &["between", "outboard", "aside", "above", "daylight"];
pub(crate) const SURFACES: &[&str] = &["plain", "striped", "grained", "glossy", "overgrown"];

pub(crate) fn water(draft: &mut Draft, name: &str) {
    draft.file.water = Some(WaterEntry {
        name: Some(name.to_owned()),
        ..WaterEntry::default()
    });
}

/// Where the light comes from. Cameras are half a metre to either side of (0, 0, −1), z is down.
pub(crate) fn lamps(draft: &mut Draft, name: &str) {
    let mut dice = draft.dice(1);
    let side = dice.one_of(&[-1.0, 1.0]);
    let positions: Vec<Vec3> = match name {
        "between" => vec![Vec3::new(
            0.1,
            dice.within(-0.2, 0.2),
            dice.within(-1.35, -0.9),
        )],
        "outboard" => {
            let (aside_m, up_m) = (dice.within(0.8, 1.3), dice.within(0.0, 0.5));
            [-aside_m, aside_m]
                .map(|y_m| Vec3::new(0.1, y_m, -1.0 - up_m))
                .into()
        }
        "aside" => vec![Vec3::new(
            dice.within(0.0, 0.5),
            side * dice.within(1.2, 2.5),
            dice.within(-1.6, -0.8),
        )],
        "above" => vec![Vec3::new(
            dice.within(0.0, 0.6),
            dice.within(-0.3, 0.3),
            dice.within(-3.2, -2.2),
        )],
        _ => Vec::new(),
    };
    if positions.is_empty() {
        draft.file.white_balance = [4.0, 1.0, 1.6];
        draft.file.daylight = Some(DaylightEntry {
            irradiance_w_per_m2: [14.0, 16.0, 15.0],
            depth_m: dice.within(3.0, 12.0),
            diffuse_attenuation_per_m: None,
        });
    }
    let grasp_m = draft.grasp_m();
    draft.file.lamp = positions
        .into_iter()
        .map(|position_m| lamp(position_m, grasp_m, &mut dice))
        .collect();
}

/// A white LED, aimed at about the grasp.
fn lamp(position_m: Vec3, grasp_m: Vec3, dice: &mut Dice) -> LampEntry {
    let mut off = || dice.within(-0.2, 0.2);
    let aim_at_m = grasp_m + Vec3::new(off(), off(), off());
    let power = dice.within(0.7, 1.3);
    LampEntry {
        position_m: position_m.into(),
        direction: None,
        aim_at_m: Some(aim_at_m.into()),
        radiant_intensity_w_per_sr: [1.8, 2.0, 0.9].map(|v| v * power),
        inner_half_angle_deg: 35.0,
        outer_half_angle_deg: 65.0,
    }
}

pub(crate) fn surface(draft: &mut Draft, name: &str) {
    let mut dice = draft.dice(2);
    let mut surface = SurfaceEntry::default();
    match name {
        "striped" => {
            surface.stripes = Some(StripesEntry {
                period_m: dice.log_within(0.05, 0.3),
                albedo: dice.colour(),
                share: 0.5,
                starts: dice.one_of(&[0, 1, 2]),
            });
        }
        "grained" => {
            surface.texture = Some(GrainEntry {
                contrast: dice.within(0.3, 0.9),
                scale_m: dice.log_within(0.02, 0.1),
            });
        }
        "glossy" => {
            let reflectance = dice.log_within(0.003, 0.3);
            surface.gloss = Some(GlossEntry {
                roughness: dice.within(0.15, 0.5),
                reflectance: [reflectance; 3],
            });
        }
        "overgrown" => {
            surface.fouling = Some(FoulingEntry {
                cover: dice.within(0.1, 0.6),
                height_m: dice.log_within(0.003, 0.015),
                albedo: [0.22, 0.26, 0.12],
            });
        }
        _ => {}
    }
    draft.file.rod[0].surface = Some(surface);
}
