//! From a mesh to a GLB file.

use image::ImageEncoder as _;
use image::codecs::png::PngEncoder;
use serde_json::{Value, json};

use super::{Mesh, MeshPart, NOTES, Texture, Wrap, to_gltf_axes};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Written in this order whatever the machine: the same mesh gives the same bytes.
pub(super) fn write(mesh: &Mesh) -> Vec<u8> {
    let mut file = File::default();
    let primitives: Vec<Value> = mesh.parts.iter().map(|part| file.primitive(part)).collect();
    let images: Vec<Value> = mesh
        .textures
        .iter()
        .map(|texture| file.image(texture))
        .collect();
    let materials = mesh.materials.iter().map(|material| {
        let [r, g, b] = material.base;
        let mut pbr = json!({
            "baseColorFactor": [r, g, b, 1.0],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        });
        if let Some(index) = material.texture {
            pbr["baseColorTexture"] = json!({ "index": index });
        }
        json!({ "name": material.name, "pbrMetallicRoughness": pbr, "doubleSided": true })
    });
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "rodsight" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "materials": materials.collect::<Vec<_>>(),
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    if !mesh.notes.is_empty() {
        root["asset"]["extras"] = json!({ NOTES: mesh.notes });
    }
    if !images.is_empty() {
        let samplers = mesh.textures.iter().map(|t| {
            let [s, t] = t.wrap.map(gl_wrap);
            json!({ "wrapS": s, "wrapT": t })
        });
        root["samplers"] = samplers.collect();
        root["textures"] = (0..images.len())
            .map(|i| json!({ "source": i, "sampler": i }))
            .collect();
        root["images"] = images.into();
    }
    glb(root.to_string().into_bytes(), file.bytes)
}

fn gl_wrap(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    }
}

/// The binary chunk as it grows.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        // Every view begins at a multiple of four, as its numbers must.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(),
            "type": format!("VEC{N}"),
        }));
        self.accessors.len() - 1
    }

    fn primitive(&mut self, part: &MeshPart) -> Value {
        let turned = |vectors: &[[f32; 3]]| -> Vec<[f32; 3]> {
            vectors.iter().map(|v| to_gltf_axes(*v)).collect()
        };
        let positions = turned(&part.positions_m);
        let position = self.floats(&positions);
        let reach = |pick: fn(f32, f32) -> f32| -> [f32; 3] {
            let first = positions[0];
            positions
                .iter()
                .fold(first, |a, b| core::array::from_fn(|k| pick(a[k], b[k])))
        };
        self.accessors[position]["min"] = json!(reach(f32::min));
        self.accessors[position]["max"] = json!(reach(f32::max));
        let normal = self.floats(&turned(&part.normals));
        let mut attributes = json!({ "POSITION": position, "NORMAL": normal });
        if !part.uvs.is_empty() {
            attributes["TEXCOORD_0"] = self.floats(&part.uvs).into();
        }
        let corners: Vec<u8> = part
            .triangles
            .iter()
            .flatten()
            .flat_map(|corner| corner.to_le_bytes())
            .collect();
        let view = self.view(&corners, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT,
            "count": 3 * part.triangles.len(), "type": "SCALAR",
        }));
        json!({
            "attributes": attributes, "indices": self.accessors.len() - 1,
            "material": part.material,
        })
    }

    fn image(&mut self, texture: &Texture) -> Value {
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(
                texture.srgb.as_flattened(),
                texture.width_px,
                texture.height_px,
                image::ExtendedColorType::Rgb8,
            )
            .expect("as many pixels as the size says, into memory");
        json!({ "bufferView": self.view(&png, None), "mimeType": "image/png" })
    }
}

/// Header and two chunks, each filled up to a multiple of four bytes.
fn glb(mut json: Vec<u8>, mut binary: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut out = Vec::with_capacity(length);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&(length as u32).to_le_bytes());
    for (chunk, name) in [(&json, b"JSON"), (&binary, b"BIN\0")] {
        out.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        out.extend_from_slice(name);
        out.extend_from_slice(chunk);
    }
    out
}
