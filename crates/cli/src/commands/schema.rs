//! `rodsight schema`.

use rodsight_render::Truth;
use rodsight_scene::{rig_json_schema, scene_json_schema};
use rodsight_solver::{Estimate, PaperParams};
use schemars::schema_for;

use crate::also::AlsoFile;
use crate::args::{Format, SchemaArgs};
use crate::commands::print_json;
use crate::failure::Failure;

pub(crate) fn run(args: &SchemaArgs) -> Result<(), Failure> {
    print_json(&match args.format {
        Format::Scene => scene_json_schema(),
        Format::Rig => rig_json_schema(),
        Format::Result => schema_for!(Estimate),
        Format::Truth => schema_for!(Truth),
        Format::Params => schema_for!(PaperParams),
        Format::Also => schema_for!(AlsoFile),
    })
}
