//! glTF files: what comes in, what is refused and how it is named.

#![allow(
    clippy::unwrap_used,
    clippy::semicolon_if_nothing_returned,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and one change a line is easier to read"
)]

use std::path::Path;

use base64::Engine as _;
use rodsight_scene::{Mesh, MeshMaterial, MeshPart, Texture, Wrap};
use serde_json::{Value, json};

/// A textured square and a plain triangle.
fn mesh() -> Mesh {
    let material = |name: &str, texture| MeshMaterial {
        name: name.to_owned(),
        base: [0.8, 0.4, 0.1],
        metallic: 0.25,
        roughness: 0.7,
        texture,
    };
    Mesh {
        parts: vec![
            MeshPart {
                positions_m: vec![
                    [1.0, -1.0, 0.0],
                    [1.0, 1.0, 0.0],
                    [1.0, 1.0, 2.0],
                    [1.0, -1.0, 2.0],
                ],
                normals: vec![[1.0, 0.0, 0.0]; 4],
                uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material: 0,
            },
            MeshPart {
                positions_m: vec![[0.1, 0.2, 0.3], [1.4, 0.5, 0.6], [0.7, 1.8, 0.9]],
                normals: vec![[0.6, 0.0, 0.8]; 3],
                uvs: Vec::new(),
                triangles: vec![[0, 1, 2]],
                material: 1,
            },
        ],
        materials: vec![material("board", Some(0)), material("edge", None)],
        textures: vec![Texture {
            width_px: 2,
            height_px: 1,
            srgb: vec![[250, 10, 20], [30, 40, 50]],
            wrap: [Wrap::Mirror, Wrap::Clamp],
        }],
        notes: vec!["something was looked past".to_owned()],
    }
}

/// The two chunks of a GLB file.
fn chunks(glb: &[u8]) -> (Value, Vec<u8>) {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    (json, glb[28 + length..].to_vec())
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + text.len() + binary.len()).to_le_bytes()[..4].iter());
    for (bytes, name) in [(text.as_slice(), b"JSON"), (binary, b"BIN\0")] {
        out.extend(bytes.len().to_le_bytes()[..4].iter());
        out.extend(name);
        out.extend(bytes);
    }
    out
}

fn load(bytes: &[u8]) -> Result<Mesh, String> {
    Mesh::from_gltf(bytes, Path::new("shelf/thing.glb")).map_err(|error| error.to_string())
}

/// The file with its JSON changed.
fn changed(change: impl Fn(&mut Value)) -> Result<Mesh, String> {
    let (mut json, binary) = chunks(&mesh().to_glb());
    change(&mut json);
    load(&glb(&json, &binary))
}

#[test]
fn written_mesh_reads_back_to_the_last_bit() {
    let mesh = mesh();
    let bytes = mesh.to_glb();
    assert_eq!(load(&bytes).unwrap(), mesh);
    assert_eq!(bytes, mesh.to_glb());
    // The comparison can fail.
    let mut other = mesh.clone();
    other.parts[0].positions_m[0][1] += 1e-6;
    assert_ne!(load(&other.to_glb()).unwrap(), mesh);
}

#[test]
fn broken_files_are_named_with_the_place_and_what_was_found() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str); 17] = [
        (
            |j| j["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired: expected no extension that the file cannot do without, found \"KHR_draco_mesh_compression\"",
        ),
        (
            |j| j["buffers"][0]["byteLength"] = json!(1_000_000),
            "buffers[0]: expected 1000000 bytes, found ",
        ),
        (
            |j| j["buffers"][0]["uri"] = json!("nowhere.bin"),
            "buffers[0]: expected shelf/nowhere.bin, found No such file",
        ),
        (
            |j| j["buffers"][0]["uri"] = json!("http://x/y.bin"),
            "buffers[0]: expected a file beside this one, or a data URI, found \"http://x/y.bin\"",
        ),
        (
            |j| j["buffers"][0]["uri"] = json!("data:;base64,?"),
            "buffers[0]: expected base64 in a data URI",
        ),
        (
            |j| j["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
            "bufferViews[0]: expected within the ",
        ),
        (
            |j| j["accessors"][0]["count"] = json!(400),
            "accessors[0]: expected within the 48 bytes of its view, found 400 elements of 12 bytes",
        ),
        (
            |j| j["accessors"][0]["count"] = json!(0),
            "accessors[0]: expected at least one element of 12 bytes, found 0",
        ),
        (
            |j| j["accessors"][0]["byteOffset"] = json!(u64::MAX),
            "accessors[0]: expected within the 48 bytes",
        ),
        (
            |j| j["accessors"][0]["type"] = json!("VEC2"),
            "accessors[0]: expected Vec3, found Vec2",
        ),
        (
            |j| j["accessors"][1]["componentType"] = json!(5120),
            "accessors[1]: expected floats, found I8",
        ),
        (
            |j| j["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": 3, "componentType": 5125}, "values": {"bufferView": 0}}),
            "accessors[0]: expected plain values, found a sparse accessor",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["mode"] = json!(5),
            "meshes[0].primitives[0].mode: expected Triangles, found TriangleStrip",
        ),
        (
            |j| {
                j["meshes"][0]["primitives"][0]["attributes"] = json!({"NORMAL": 1, "POSITION": 99})
            },
            "primitive 0.attributes: expected one of 7 accessors, found 99",
        ),
        (|j| j["scenes"] = json!([]), "found Index out of bounds"),
        (
            |j| j["nodes"][0]["scale"] = json!([1, 0, 1]),
            "nodes[0]: expected a transform that flattens nothing, found one of determinant 0",
        ),
        (
            |j| j["nodes"][0]["children"] = json!([0]),
            "nodes[0]: expected a child of one node only, found a second parent",
        ),
    ];
    for (change, expected) in cases {
        let message = changed(change).unwrap_err();
        assert!(message.starts_with("shelf/thing.glb: "), "{message}");
        assert!(
            message.contains(expected),
            "{message}\n  without: {expected}"
        );
    }
    assert!(changed(|_| ()).is_ok(), "unchanged it loads");
}

#[test]
fn broken_numbers_in_the_binary_are_found() {
    let cases: [(usize, [u8; 4], &str); 3] = [
        (
            0,
            f32::NAN.to_le_bytes(),
            "accessors[0], element 0: expected finite numbers, found [NaN",
        ),
        (
            48,
            f32::INFINITY.to_le_bytes(),
            "accessors[1], element 0: expected finite numbers, found [inf",
        ),
        (
            128,
            7_u32.to_le_bytes(),
            "meshes[0].primitives[0].indices: expected < 4, the number of vertices, found 7",
        ),
    ];
    for (at, bytes, expected) in cases {
        let (json, mut binary) = chunks(&mesh().to_glb());
        binary[at..at + 4].copy_from_slice(&bytes);
        let message = load(&glb(&json, &binary)).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
    let huge = Mesh {
        parts: vec![MeshPart {
            positions_m: vec![[0.0; 3], [2e6, 0.0, 0.0], [0.0, 1.0, 0.0]],
            ..mesh().parts[1].clone()
        }],
        ..mesh()
    };
    let message = load(&huge.to_glb()).unwrap_err();
    assert!(
        message.contains("within -1e6 to 1e6 m, found 2000000"),
        "{message}"
    );
}

#[test]
fn files_cut_short_and_files_of_another_kind_are_refused() {
    let whole = mesh().to_glb();
    for length in (0..whole.len()).step_by(7) {
        let message = load(&whole[..length]).unwrap_err();
        assert!(
            message.starts_with("shelf/thing.glb: "),
            "{length}: {message}"
        );
    }
    let message = load(&whole[..100]).unwrap_err();
    let expected = format!(
        "glb: expected a whole file, found 100 of {} bytes",
        whole.len()
    );
    assert!(message.contains(&expected), "{message}");
    assert!(load(b"solid stl").is_err());
    assert!(
        load(b"{\"asset\": {\"version\": \"2.0\"}}")
            .unwrap_err()
            .contains("scenes: expected a scene")
    );
    let missing = Mesh::load(Path::new("no/such.glb"))
        .unwrap_err()
        .to_string();
    assert!(missing.starts_with("no/such.glb: "), "{missing}");
}

/// Every single byte turned: an error or a mesh, never a panic.
#[test]
fn no_flipped_byte_makes_it_panic() {
    let whole = mesh().to_glb();
    let mut refused = 0;
    for at in 0..whole.len() {
        for flip in [0xFF, 0x01, 0x20] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            refused += usize::from(load(&bytes).is_err());
        }
    }
    assert!(refused > whole.len() / 2, "{refused}");
}

#[test]
fn what_is_looked_past_is_said() {
    let mesh = changed(|j| {
        j["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
        j["animations"] = json!([]);
        j["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
        j["scenes"] = json!([{"nodes": [0]}, {"nodes": []}, {"nodes": []}]);
        j["materials"][0]["doubleSided"] = json!(false);
        j["materials"][0]["alphaMode"] = json!("BLEND");
        j["materials"][0]["emissiveFactor"] = json!([1, 0, 0]);
        j["materials"][0]["normalTexture"] = json!({"index": 0});
    })
    .unwrap();
    for note in [
        "extension \"KHR_materials_clearcoat\" is looked past",
        "cameras are looked past: 1",
        "scenes but one are looked past: 2",
        "single-sided materials are drawn from both sides",
        "material \"board\": its transparency is looked past",
        "material \"board\": its emission is looked past",
        "material \"board\": its normal texture is looked past",
    ] {
        assert!(
            mesh.notes.iter().any(|n| n == note),
            "{note}: {:?}",
            mesh.notes
        );
    }
}

/// glTF's axes become ours, nodes are gone through, mirrors keep normals outward.
#[test]
fn nodes_turn_and_mirror_what_they_hold() {
    let turned = changed(|j| {
        j["nodes"] = json!([
            {"children": [1], "translation": [0, 10, 0]},
            {"mesh": 0, "scale": [1, 1, -2]},
        ]);
    })
    .unwrap();
    let (was, is) = (&mesh().parts[1], &turned.parts[1]);
    for (a, b) in was.positions_m.iter().zip(&is.positions_m) {
        // z_gltf is our x: mirrored and doubled. y_gltf is our −z: ten metres up.
        let expected = [-2.0 * a[0], a[1], a[2] - 10.0];
        assert!(
            (0..3).all(|k| (b[k] - expected[k]).abs() < 1e-6),
            "{b:?} for {expected:?}"
        );
    }
    let [a, b, c] = is.triangles[0].map(|i| is.positions_m[i as usize]);
    let edge = |p: [f32; 3]| -> [f32; 3] { core::array::from_fn(|k| p[k] - a[k]) };
    let (u, v) = (edge(b), edge(c));
    let face = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let [p, q, r] = was.triangles[0].map(|i| was.positions_m[i as usize]);
    let before: Vec<f32> = (0..3)
        .map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])
        })
        .collect();
    let side =
        |face: &[f32], normal: [f32; 3]| (0..3).map(|k| face[k] * normal[k]).sum::<f32>().signum();
    assert_eq!(
        side(&face, is.normals[0]),
        side(&before, was.normals[0]),
        "normals stay on their side of the face"
    );
    let length: f32 = is.normals[0].iter().map(|v| v * v).sum();
    assert!((length - 1.0).abs() < 1e-6);
}

/// Without normals facets are flat; without area triangles are left out and counted.
#[test]
fn facets_and_triangles_without_area() {
    let flat = changed(|j| {
        j["meshes"][0]["primitives"][1]["attributes"]
            .as_object_mut()
            .unwrap()
            .remove("NORMAL");
    })
    .unwrap();
    let part = &flat.parts[1];
    let [a, b, c] = [0, 1, 2].map(|i| part.positions_m[i]);
    for p in [b, c] {
        let along: f32 = (0..3).map(|k| (p[k] - a[k]) * part.normals[0][k]).sum();
        assert!(along.abs() < 1e-6);
    }
    let mut thin = mesh();
    thin.parts[0].triangles.push([0, 0, 1]);
    let read = load(&thin.to_glb()).unwrap();
    assert_eq!(read.triangle_count(), 3);
    assert!(
        read.notes
            .iter()
            .any(|n| n.contains("1 triangles without area")),
        "{:?}",
        read.notes
    );
    thin.parts.truncate(1);
    thin.parts[0].triangles = vec![[0, 0, 1]];
    let message = load(&thin.to_glb()).unwrap_err();
    assert!(
        message.contains("scene: expected at least one triangle with an area, found none"),
        "{message}"
    );
}

/// A `.gltf` with its buffer beside it, under a name that needs escaping, and one with it inside.
#[test]
fn buffers_beside_the_file_and_in_data_uris_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let (mut json, binary) = chunks(&mesh().to_glb());
    std::fs::write(folder.path().join("a b.bin"), &binary).unwrap();
    json["buffers"][0]["uri"] = json!("a%20b.bin");
    let path = folder.path().join("thing.gltf");
    std::fs::write(&path, json.to_string()).unwrap();
    assert_eq!(Mesh::load(&path).unwrap(), mesh());
    let text = base64::engine::general_purpose::STANDARD.encode(&binary);
    json["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{text}").into();
    assert_eq!(load(json.to_string().as_bytes()).unwrap(), mesh());
}
