//! Writes the props of `scenes/props/`: `cargo run -p rodsight-scene --example make_props`.

mod props;
mod shapes;

use std::path::Path;
use std::process::ExitCode;

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]
fn main() -> ExitCode {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/props");
    for (name, mesh) in props::all() {
        let (path, bytes) = (dir.join(name), mesh.to_glb());
        if let Err(error) = std::fs::write(&path, &bytes) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
        println!(
            "{name}: {} triangles, {} bytes",
            mesh.triangle_count(),
            bytes.len()
        );
    }
    ExitCode::SUCCESS
}
