//! The props that are shipped are what their generator writes.

#[path = "../examples/make_props/props.rs"]
mod props;
#[path = "../examples/make_props/shapes.rs"]
mod shapes;

use core::f64::consts::TAU;
use std::path::PathBuf;

use rodsight_geometry::Vec3;
use rodsight_scene::{Mesh, MeshPart};

fn shelf() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/props")
}

#[test]
fn shipped_props_are_those_of_the_generator() {
    let mut names = Vec::new();
    for (name, mesh) in props::all() {
        let path = shelf().join(name);
        let bytes =
            std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let message = "run `cargo run -p rodsight-scene --example make_props`";
        assert!(bytes == mesh.to_glb(), "{name} differs: {message}");
        assert_eq!(Mesh::load(&path).unwrap(), mesh, "{name}");
        assert!(bytes.len() < 200_000, "{name}: {}", bytes.len());
        names.push(name.to_owned());
    }
    let mut shipped: Vec<String> = std::fs::read_dir(shelf())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    shipped.sort();
    names.sort();
    assert_eq!(shipped, names);
}

/// Volume by the divergence theorem: positive when closed surfaces are wound outwards; and how far triangle and vertex normals
/// agree at worst.
fn volume_and_agreement(part: &MeshPart) -> (f64, f64) {
    let at = |v: [f32; 3]| Vec3::from(v.map(f64::from));
    let (mut volume_m3, mut least) = (0.0, f64::INFINITY);
    for corners in &part.triangles {
        let [a, b, c] = corners.map(|k| at(part.positions_m[k as usize]));
        let normal = (b - a).cross(&(c - a)).normalize();
        volume_m3 += a.dot(&b.cross(&c)) / 6.0;
        for &k in corners {
            least = f64::min(least, normal.dot(&at(part.normals[k as usize])));
        }
    }
    (volume_m3, least)
}

#[test]
fn surfaces_are_closed_and_face_outwards() {
    let expected_m3 = |name: &str, material: usize| match (name, material) {
        // Board; posts, feet, brackets and the receptacle (a 40-gon); three handles of 24 sides.
        ("panel.glb", 0) => 0.03 * 1.2 * 0.8,
        ("panel.glb", 1) => {
            let polygon = 20.0 * libm::sin(TAU / 40.0) * 0.06 * 0.06;
            2.0 * (0.08 * 0.08 * 1.2 + 0.5 * 0.16 * 0.02)
                + 2.0 * 0.085 * 0.03 * 0.03
                + polygon * 0.145
        }
        ("panel.glb", 2) => {
            let polygon = 12.0 * libm::sin(TAU / 24.0) * 0.011 * 0.011;
            3.0 * polygon * (0.09 + 0.14 + 0.09)
        }
        _ => f64::NAN,
    };
    for (name, mesh) in props::all() {
        for part in &mesh.parts {
            let (volume_m3, agreement) = volume_and_agreement(part);
            assert!(volume_m3 > 0.0, "{name} {}: {volume_m3}", part.material);
            // Facets of a bar of 20 sides lean by 9°, those of a rock's finest bumps by up to 51°.
            assert!(agreement > 0.6, "{name} {}: {agreement}", part.material);
            let expected_m3 = expected_m3(name, part.material);
            if expected_m3.is_finite() {
                // f32 vertices
                let relative = (volume_m3 / expected_m3 - 1.0).abs();
                assert!(
                    relative < 1e-4,
                    "{name} {}: {volume_m3} of {expected_m3}",
                    part.material
                );
            }
        }
    }
    // One triangle the wrong way round is seen.
    let mut turned = props::all().remove(0).1.parts.remove(0);
    turned.triangles[0].swap(0, 1);
    assert!(volume_and_agreement(&turned).1 < 0.0);
}
