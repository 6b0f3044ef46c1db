//! From a glTF document to a mesh.

use std::path::Path;

use gltf::json::validation::Validate;
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use rodsight_geometry::{Mat3, Vec3};
use serde_json::Value;

use super::buffers::Buffers;
use super::{Mesh, MeshMaterial, MeshPart, NOTES, from_gltf_axes, image};
use crate::SceneError;
use crate::error::Complaints;

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Mesh, SceneError> {
    let no = Complaints { path };
    let Gltf { document, blob } = parse(bytes, &no)?;
    let buffers = Buffers::new(&document, blob, path)?;
    let mut reader = Reader {
        document: &document,
        buffers,
        path,
        mesh: Mesh {
            notes: notes_about(&document),
            ..Mesh::default()
        },
        material_of: Vec::new(),
        texture_of: Vec::new(),
    };
    reader.scene()?;
    let mesh = reader.mesh;
    if mesh.parts.is_empty() {
        return Err(no.value("scene", "at least one triangle with an area", "none"));
    }
    Ok(mesh)
}

/// A document whose every index points at something.
fn parse(bytes: &[u8], no: &Complaints<'_>) -> Result<Gltf, SceneError> {
    let expected = "a glTF 2.0 file";
    if bytes.starts_with(b"glTF") {
        // The parser takes the header's length at its word.
        let length = bytes
            .get(8..12)
            .map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
        if length < 20 || length > bytes.len() {
            let found = format!("{} of {length} bytes", bytes.len());
            return Err(no.value("glb", "a whole file", found));
        }
    }
    let gltf = Gltf::from_slice_without_validation(bytes)
        .map_err(|error| no.value("gltf", expected, error))?;
    let root = gltf.document.as_json();
    if let Some(extension) = root.extensions_required.first() {
        let expected = "no extension that the file cannot do without";
        return Err(no.value("extensionsRequired", expected, format!("\"{extension}\"")));
    }
    // The parser's own validation trusts this one index.
    for (k, primitive) in root
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.primitives)
        .enumerate()
    {
        for accessor in primitive.attributes.values() {
            if accessor.value() >= root.accessors.len() {
                let expected = format!("one of {} accessors", root.accessors.len());
                return Err(no.value(
                    format!("primitive {k}.attributes"),
                    expected,
                    accessor.value(),
                ));
            }
        }
    }
    let mut first = None;
    root.validate(root, gltf::json::Path::new, &mut |at, error| {
        first.get_or_insert_with(|| no.value(at().to_string(), expected, error));
    });
    match first {
        Some(error) => Err(error),
        None => Ok(gltf),
    }
}

/// What a document holds that plays no part here.
fn notes_about(document: &Document) -> Vec<String> {
    let root = document.as_json();
    let mut notes: Vec<String> = root
        .extensions_used
        .iter()
        .map(|extension| format!("extension \"{extension}\" is looked past"))
        .collect();
    // Those of the file that this one was written from.
    let extras = root.asset.extras.as_ref();
    if let Some(Value::Array(earlier)) = extras
        .and_then(|extras| serde_json::from_str::<Value>(extras.get()).ok())
        .and_then(|mut extras| extras.get_mut(NOTES).map(Value::take))
    {
        notes.extend(earlier.iter().filter_map(Value::as_str).map(str::to_owned));
    }
    // glTF leaves their backs out.
    if root.materials.iter().any(|material| !material.double_sided) {
        notes.push("single-sided materials are drawn from both sides".to_owned());
    }
    let counts = [
        ("scenes but one", root.scenes.len().saturating_sub(1)),
        ("animations", root.animations.len()),
        ("skins", root.skins.len()),
        ("cameras", root.cameras.len()),
    ];
    for (what, count) in counts {
        if count > 0 {
            notes.push(format!("{what} are looked past: {count}"));
        }
    }
    notes
}

struct Reader<'a> {
    document: &'a Document,
    buffers: Buffers<'a>,
    path: &'a Path,
    mesh: Mesh,
    /// What became of the document's materials, by index; the default material is `None`.
    material_of: Vec<(Option<usize>, usize)>,
    /// What became of its textures.
    texture_of: Vec<(usize, usize)>,
}

/// A node's axes and origin in the scene.
#[derive(Clone, Copy)]
struct Placed {
    axes: Mat3,
    origin_m: Vec3,
}

impl Reader<'_> {
    fn no(&self) -> Complaints<'_> {
        Complaints { path: self.path }
    }

    /// Every node of the scene that the file shows.
    fn scene(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let scene = document
            .default_scene()
            .or_else(|| document.scenes().next());
        let Some(scene) = scene else {
            return Err(self.no().value("scenes", "a scene", "none"));
        };
        let top = Placed {
            axes: Mat3::identity(),
            origin_m: Vec3::zeros(),
        };
        let mut seen = vec![false; document.nodes().len()];
        let mut stack: Vec<(Node<'_>, Placed)> = scene.nodes().map(|node| (node, top)).collect();
        stack.reverse();
        while let Some((node, parent)) = stack.pop() {
            let key = format!("nodes[{}]", node.index());
            if core::mem::replace(&mut seen[node.index()], true) {
                let expected = "a child of one node only";
                return Err(self.no().value(key, expected, "a second parent"));
            }
            let placed = self.place(&node, parent)?;
            if let Some(mesh) = node.mesh() {
                for primitive in mesh.primitives() {
                    let key = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
                    self.primitive(&primitive, placed, &key)?;
                }
            }
            let below = stack.len();
            stack.extend(node.children().map(|child| (child, placed)));
            stack[below..].reverse();
        }
        Ok(())
    }

    fn place(&self, node: &Node<'_>, parent: Placed) -> Result<Placed, SceneError> {
        let columns = node.transform().matrix();
        let axes = Mat3::from_fn(|i, j| f64::from(columns[j][i]));
        let origin_m = Vec3::from_fn(|i, _| f64::from(columns[3][i]));
        let placed = Placed {
            axes: parent.axes * axes,
            origin_m: parent.axes * origin_m + parent.origin_m,
        };
        let determinant = placed.axes.determinant();
        if !(determinant.is_finite() && determinant != 0.0 && placed.origin_m.norm().is_finite()) {
            let key = format!("nodes[{}]", node.index());
            let expected = "a transform that flattens nothing";
            let found = format!("one of determinant {determinant}");
            return Err(self.no().value(key, expected, found));
        }
        Ok(placed)
    }

    fn primitive(
        &mut self,
        primitive: &Primitive<'_>,
        placed: Placed,
        key: &str,
    ) -> Result<(), SceneError> {
        if primitive.mode() != Mode::Triangles {
            let found = format!("{:?}", primitive.mode());
            return Err(self.no().value(format!("{key}.mode"), "Triangles", found));
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Err(self.no().value(key, "POSITION", "none"));
        };
        if primitive.morph_targets().len() > 0 {
            self.note(format!("{key}: morph targets are looked past"));
        }
        if primitive.get(&Semantic::Colors(0)).is_some() {
            self.note(format!("{key}: colours of vertices are looked past"));
        }
        let positions = self.buffers.vectors::<3>(&positions)?;
        let corners = match primitive.indices() {
            Some(accessor) => self.buffers.indices(&accessor)?,
            None => (0..positions.len() as u32).collect(),
        };
        let ragged = corners.len() % 3 != 0;
        if ragged || self.mesh.triangle_count() + corners.len() / 3 > Mesh::MOST_TRIANGLES {
            let expected = format!(
                "three per triangle, and at most {} triangles",
                Mesh::MOST_TRIANGLES
            );
            return Err(self
                .no()
                .value(format!("{key}.indices"), expected, corners.len()));
        }
        if let Some(bad) = corners
            .iter()
            .find(|&&corner| corner as usize >= positions.len())
        {
            let expected = format!("< {}, the number of vertices", positions.len());
            return Err(self.no().value(format!("{key}.indices"), expected, bad));
        }
        let material = self.material(&primitive.material())?;
        let (triangles, _) = corners.as_chunks::<3>();
        let mut part = MeshPart {
            normals: self.normals(primitive, positions.len(), key)?,
            uvs: self.uvs(primitive, material, positions.len(), key)?,
            positions_m: positions,
            triangles: triangles.to_vec(),
            material,
        };
        part.transform(placed);
        let largest = part
            .positions_m
            .iter()
            .flatten()
            .fold(0.0, |a: f32, v| a.max(v.abs()));
        if !(largest <= 1e6) {
            let expected = "within -1e6 to 1e6 m";
            return Err(self
                .no()
                .value(format!("{key}.POSITION"), expected, largest));
        }
        let flat = part.drop_flat();
        if flat > 0 {
            self.note(format!("{key}: {flat} triangles without area are left out"));
        }
        if part.normals.is_empty() {
            part.facet();
        }
        if !part.triangles.is_empty() {
            self.mesh.parts.push(part);
        }
        Ok(())
    }

    /// The normals of the vertices; none where the file has none that can be used.
    fn normals(
        &mut self,
        primitive: &Primitive<'_>,
        count: usize,
        key: &str,
    ) -> Result<Vec<[f32; 3]>, SceneError> {
        let Some(accessor) = primitive.get(&Semantic::Normals) else {
            return Ok(Vec::new());
        };
        let normals = self.buffers.vectors::<3>(&accessor)?;
        self.same_count(key, "NORMAL", normals.len(), count)?;
        if normals.contains(&[0.0; 3]) {
            self.note(format!(
                "{key}: normals of no length; facets are shaded flat"
            ));
            return Ok(Vec::new());
        }
        Ok(normals)
    }

    /// The texture coordinates of the vertices, where the material has a use for them.
    fn uvs(
        &self,
        primitive: &Primitive<'_>,
        material: usize,
        count: usize,
        key: &str,
    ) -> Result<Vec<[f32; 2]>, SceneError> {
        if self.mesh.materials[material].texture.is_none() {
            return Ok(Vec::new());
        }
        let pbr = primitive.material().pbr_metallic_roughness();
        let set = pbr.base_color_texture().map_or(0, |info| info.tex_coord());
        let name = format!("TEXCOORD_{set}");
        let Some(accessor) = primitive.get(&Semantic::TexCoords(set)) else {
            return Err(self
                .no()
                .value(key, format!("{name} for its texture"), "none"));
        };
        let uvs = self.buffers.vectors::<2>(&accessor)?;
        self.same_count(key, &name, uvs.len(), count)?;
        Ok(uvs)
    }

    fn same_count(
        &self,
        key: &str,
        name: &str,
        found: usize,
        expected: usize,
    ) -> Result<(), SceneError> {
        if found == expected {
            return Ok(());
        }
        let expected = format!("one for each of the {expected} vertices");
        Err(self.no().value(format!("{key}.{name}"), expected, found))
    }

    fn material(&mut self, material: &gltf::Material<'_>) -> Result<usize, SceneError> {
        let known = self
            .material_of
            .iter()
            .find(|(from, _)| *from == material.index());
        if let Some(&(_, to)) = known {
            return Ok(to);
        }
        let pbr = material.pbr_metallic_roughness();
        let name = material.name().unwrap_or("").to_owned();
        let mut past = |what: &str, is_there: bool| {
            if is_there {
                self.note(format!("material \"{name}\": its {what} is looked past"));
            }
        };
        past(
            "transparency",
            material.alpha_mode() != gltf::material::AlphaMode::Opaque,
        );
        past(
            "metallic-roughness texture",
            pbr.metallic_roughness_texture().is_some(),
        );
        past("normal texture", material.normal_texture().is_some());
        past("occlusion texture", material.occlusion_texture().is_some());
        past("emission", material.emissive_factor() != [0.0; 3]);
        let texture = pbr
            .base_color_texture()
            .map(|info| self.texture(&info))
            .transpose()?;
        let unit = |v: f32| v.clamp(0.0, 1.0);
        let [r, g, b, _] = pbr.base_color_factor();
        let to = self.mesh.materials.len();
        self.mesh.materials.push(MeshMaterial {
            name,
            base: [r, g, b].map(unit),
            metallic: unit(pbr.metallic_factor()),
            roughness: unit(pbr.roughness_factor()),
            texture,
        });
        self.material_of.push((material.index(), to));
        Ok(to)
    }

    fn texture(&mut self, info: &gltf::texture::Info<'_>) -> Result<usize, SceneError> {
        let index = info.texture().index();
        if let Some(&(_, to)) = self.texture_of.iter().find(|(from, _)| *from == index) {
            return Ok(to);
        }
        let notes = &mut self.mesh.notes;
        let texture = image::read(self.document, &self.buffers, info, self.path, notes)?;
        let to = self.mesh.textures.len();
        self.mesh.textures.push(texture);
        self.texture_of.push((index, to));
        Ok(to)
    }

    fn note(&mut self, note: String) {
        if !self.mesh.notes.contains(&note) {
            self.mesh.notes.push(note);
        }
    }
}

impl MeshPart {
    /// From the axes of a glTF node to those of the prop.
    fn transform(&mut self, placed: Placed) {
        let moved = placed.axes != Mat3::identity() || placed.origin_m != Vec3::zeros();
        let wide = |v: [f32; 3]| Vec3::from(v.map(f64::from));
        let narrow = |v: Vec3| -> [f32; 3] { v.map(|v| v as f32).into() };
        for position in &mut self.positions_m {
            if moved {
                *position = narrow(placed.axes * wide(*position) + placed.origin_m);
            }
            *position = from_gltf_axes(*position);
        }
        let to_normals = placed
            .axes
            .try_inverse()
            .map_or(placed.axes, |m| m.transpose());
        for normal in &mut self.normals {
            let turned = to_normals * wide(*normal);
            // What is a unit vector already stays as it is to the last bit.
            if moved || (turned.norm() - 1.0).abs() > 1e-6 {
                *normal = narrow(turned.normalize());
            }
            *normal = from_gltf_axes(*normal);
        }
        if placed.axes.determinant() < 0.0 {
            for [_, b, c] in &mut self.triangles {
                core::mem::swap(b, c);
            }
        }
    }

    /// The normal of a triangle, as long as twice its area.
    fn face(&self, triangle: [u32; 3]) -> Vec3 {
        let [a, b, c] = triangle.map(|i| Vec3::from(self.positions_m[i as usize].map(f64::from)));
        (b - a).cross(&(c - a))
    }

    /// Leaves out triangles without area, and says how many.
    fn drop_flat(&mut self) -> usize {
        let before = self.triangles.len();
        let mut triangles = core::mem::take(&mut self.triangles);
        triangles.retain(|&triangle| self.face(triangle).norm_squared() > 0.0);
        self.triangles = triangles;
        before - self.triangles.len()
    }

    /// Gives every triangle corners of its own, with its own normal.
    fn facet(&mut self) {
        let mut faceted = Self {
            material: self.material,
            ..Self::default()
        };
        for &triangle in &self.triangles {
            let normal = self.face(triangle).normalize().map(|v| v as f32).into();
            let first = faceted.positions_m.len() as u32;
            faceted.triangles.push([first, first + 1, first + 2]);
            for corner in triangle.map(|i| i as usize) {
                faceted.positions_m.push(self.positions_m[corner]);
                faceted.normals.push(normal);
                faceted.uvs.extend(self.uvs.get(corner));
            }
        }
        *self = faceted;
    }
}
