//! Ports in rig files: read, written back, refused with file, key, expected and found.

use std::path::Path;

use rodsight_geometry::port::{Port, PortShape, sea_water_index};
use rodsight_geometry::{Rig, RigFile, Vec3};

use super::{dome, flat};

const FLAT: &str = r#"kind = "flat"
distance_m = 0.02
thickness_m = 0.01
salinity_psu = 35.0
temperature_c = 10.0
"#;
const DOME: &str = r#"kind = "dome"
inner_radius_m = 0.06
thickness_m = 0.006
centre_offset_m = [0.0, 0.001, 0.002]
glass_index = 1.517
water_index = [1.3399, 1.3427, 1.3452]
"#;

fn eye(name: &str, y_m: f64, port: &str) -> String {
    let size = "width_px = 1920\nheight_px = 1080\nfx_px = 979.0\nfy_px = 979.0\ncx_px = 960.0\ncy_px = 540.0";
    let port = if port.is_empty() {
        String::new()
    } else {
        format!("[{name}.port]\n{port}")
    };
    format!(
        "[{name}]\n{size}\n{port}[{name}.rig_from_camera]\nrpy_deg = [90, 0, 90]\ntranslation_m = [0.0, {y_m:?}, -1.0]\n"
    )
}

fn read(left: &str, right: &str) -> Result<Rig, String> {
    let text = format!(
        "schema = 1\n{}{}",
        eye("left", -0.5, left),
        eye("right", 0.5, right)
    );
    Rig::from_toml(&text, Path::new("rig.toml")).map_err(|error| error.to_string())
}

#[test]
fn ports_are_read_and_written_back() {
    let rig = read(FLAT, DOME).unwrap();
    let acrylic = Port::new(
        flat(0.02, 0.01, Vec3::z()),
        1.49,
        sea_water_index(35.0, 10.0),
    )
    .unwrap();
    assert_eq!(rig.left.port, Some(acrylic));
    let crown = Port::new(
        dome(Vec3::new(0.0, 0.001, 0.002), 0.06, 0.006),
        1.517,
        [1.3399, 1.3427, 1.3452],
    );
    assert_eq!(rig.right.port, Some(crown.unwrap()));
    assert!(!rig.left.is_pinhole() && rig.left.camera.is_pinhole());

    let tilted = read(&format!("{FLAT}normal = [0.2, 0.0, 2.0]\n"), "").unwrap();
    let Some(PortShape::Flat(plate)) = tilted.left.port.map(|port| *port.shape()) else {
        panic!("{tilted:?}");
    };
    assert!((plate.normal - Vec3::new(0.2, 0.0, 2.0).normalize()).norm() < 1e-15);
    for rig in [rig, tilted] {
        let written = RigFile::from_rig(&rig).to_toml();
        assert_eq!(
            Rig::from_toml(&written, Path::new("w.toml")),
            Ok(rig),
            "{written}"
        );
    }
    // A rig without ports is written as ever.
    let bare = RigFile::from_rig(&read("", "").unwrap()).to_toml();
    assert!(!bare.contains("port"), "{bare}");
}

#[test]
fn ports_that_are_none_are_refused_by_key() {
    for (port, from, to, parts) in [
        (
            FLAT,
            "distance_m = 0.02",
            "distance_m = 20",
            "left.port.distance_m: expected 0 to 2 m, found 20",
        ),
        (
            FLAT,
            "distance_m = 0.02",
            "distance_m = -0.02",
            "left.port.distance_m",
        ),
        (
            FLAT,
            "thickness_m = 0.01",
            "thickness_m = nan",
            "left.port.thickness_m: expected 0 to 2 m, found NaN",
        ),
        (
            FLAT,
            "thickness_m = 0.01",
            "thicknes_m = 0.01",
            "unknown field `thicknes_m`",
        ),
        (FLAT, "distance_m = 0.02", "", "missing field `distance_m`"),
        (
            FLAT,
            "salinity_psu = 35.0",
            "",
            "left.port: expected water_index, or salinity_psu and temperature_c, found temperature_c",
        ),
        (
            FLAT,
            "salinity_psu = 35.0",
            "water_index = [1.3, 1.3, 1.3]",
            "found water_index, temperature_c",
        ),
        (
            FLAT,
            "salinity_psu = 35.0",
            "salinity_psu = 350.0",
            "left.port.salinity_psu: expected 0 to 40, found 350",
        ),
        (
            FLAT,
            "temperature_c = 10.0",
            "temperature_c = 283.0",
            "left.port.temperature_c: expected 0 to 30, found 283",
        ),
        (
            FLAT,
            "kind = \"flat\"",
            "kind = \"flat\"\nnormal = [0, 0, 0]",
            "left.port.normal: expected a direction",
        ),
        (
            FLAT,
            "kind = \"flat\"",
            "kind = \"flat\"\nnormal = [0, 0, -1]",
            "left.port.normal[2]: expected a direction ahead",
        ),
        (
            FLAT,
            "kind = \"flat\"",
            "kind = \"flat\"\nnormal = [2, 0, 1]",
            "left.port: the pixel",
        ),
        (
            FLAT,
            "kind = \"flat\"",
            "kind = \"flat\"\nglass_index = 0.9",
            "left.port.glass_index: expected 1 to 3, found 0.9",
        ),
        (
            FLAT,
            "kind = \"flat\"",
            "kind = \"flatt\"",
            "unknown variant `flatt`",
        ),
        (
            DOME,
            "inner_radius_m = 0.06",
            "inner_radius_m = 0",
            "left.port.inner_radius_m: expected more than 0",
        ),
        (
            DOME,
            "[0.0, 0.001, 0.002]",
            "[0.0, 0.06, 0.0]",
            "left.port.centre_offset_m: expected a vector shorter than 0.95 inner radii",
        ),
        (
            DOME,
            "1.3427",
            "0.13427",
            "left.port.water_index: expected 1 to 2, found 0.13427",
        ),
    ] {
        assert!(port.contains(from), "no `{from}`");
        let message = read(&port.replacen(from, to, 1), "").unwrap_err();
        assert!(
            message.starts_with("rig.toml") && message.contains(parts),
            "no `{parts}` in: {message}"
        );
    }
}
