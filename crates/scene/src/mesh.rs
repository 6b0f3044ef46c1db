//! Triangle meshes from glTF 2.0 files (`.glb`, `.gltf`), read as far as a matt and glossy surface needs them.
//!
//! glTF is y up, z towards the viewer, x to the left of what looks that way; a mesh here is in the frame of its prop: x forward,
//! y starboard, z down, the front of the model looking forward: `x = z_gltf`, `y = −x_gltf`, `z = −y_gltf`. Metres in both.
//!
//! What a file asks for and is not done is either an error (it could not be looked past) or one of [`Mesh::notes`].

mod buffers;
mod image;
mod read;
mod write;

use std::path::Path;

use crate::SceneError;
use crate::error::Complaints;

/// A mesh in the frame of its prop: x forward, y starboard, z down; metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Runs of triangles with one material each; at least one, none of them empty.
    pub parts: Vec<MeshPart>,
    /// What the parts are made of.
    pub materials: Vec<MeshMaterial>,
    /// Images that materials refer to.
    pub textures: Vec<Texture>,
    /// What the file asks for and is looked past, one line each.
    pub notes: Vec<String>,
}

/// Triangles of one material. The arrays over vertices are of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshPart {
    /// Vertices, m.
    pub positions_m: Vec<[f32; 3]>,
    /// Unit normals of the vertices.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices; empty if the material has no texture.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices each; no triangle is without area.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Mesh::materials`].
    pub material: usize,
}

/// The metallic-roughness model of glTF: matt albedo `base (1 − metallic)`, reflectance at normal incidence between that of a
/// dielectric and `base`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshMaterial {
    /// Its name in the file.
    pub name: String,
    /// Linear base colour, [0, 1]; times the texture where there is one.
    pub base: [f32; 3],
    /// How much of it is bare metal, [0, 1].
    pub metallic: f32,
    /// glTF's perceptual roughness, [0, 1].
    pub roughness: f32,
    /// Index into [`Mesh::textures`] of the base colour.
    pub texture: Option<usize>,
}

/// A colour image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Width, px.
    pub width_px: u32,
    /// Height, px.
    pub height_px: u32,
    /// sRGB, row-major from the top-left corner, which has the coordinates (0, 0).
    pub srgb: Vec<[u8; 3]>,
    /// How coordinates beyond [0, 1] are meant, along the width and the height.
    pub wrap: [Wrap; 2],
}

/// How a texture goes on beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

impl Mesh {
    /// The most triangles a mesh may have, and all props of a scene together: with their tree they take two gigabytes.
    pub const MOST_TRIANGLES: usize = 10_000_000;

    /// Reads a `.glb` or `.gltf` file and whatever it refers to.
    ///
    /// # Errors
    /// A file that is no mesh, or asks for what cannot be looked past: the message names the file and the place in it.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let bytes = std::fs::read(path).map_err(|error| Complaints { path }.unreadable(&error))?;
        Self::from_gltf(&bytes, path)
    }

    /// Reads the bytes of a `.glb` or `.gltf` file; `path` is named in messages, and what the file refers to is looked for beside
    /// it.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_gltf(bytes: &[u8], path: &Path) -> Result<Self, SceneError> {
        read::read(bytes, path)
    }

    /// The bytes of a GLB file that reads back as this mesh to the last bit.
    pub fn to_glb(&self) -> Vec<u8> {
        write::write(self)
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }
}

/// Where a file that we write keeps the notes of the one it was read from, in `asset.extras`.
const NOTES: &str = "rodsight_notes";

/// From glTF's axes to ours; exact, as it only swaps and turns signs.
fn from_gltf_axes([x, y, z]: [f32; 3]) -> [f32; 3] {
    [z, -x, -y]
}

/// And back.
fn to_gltf_axes([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-y, -z, x]
}
