//! The bytes behind a glTF document, and numbers out of them. Nothing here trusts an offset, a stride or a count.

use std::path::Path;

use base64::Engine as _;
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, buffer};

use crate::SceneError;
use crate::error::Complaints;

/// The buffers of a document.
pub(super) struct Buffers<'a> {
    no: Complaints<'a>,
    data: Vec<Vec<u8>>,
}

impl<'a> Buffers<'a> {
    /// All buffers, from the file itself, from data URIs and from files beside it.
    pub(super) fn new(
        document: &Document,
        mut blob: Option<Vec<u8>>,
        path: &'a Path,
    ) -> Result<Self, SceneError> {
        let no = Complaints { path };
        let mut data = Vec::new();
        for buffer in document.buffers() {
            let key = format!("buffers[{}]", buffer.index());
            let bytes = match buffer.source() {
                buffer::Source::Uri(uri) => resolve(uri, path)
                    .map_err(|(expected, found)| no.value(&key, expected, found))?,
                buffer::Source::Bin => blob.take().ok_or_else(|| {
                    no.value(&key, "a uri, or the binary chunk of a .glb", "neither")
                })?,
            };
            if bytes.len() < buffer.length() {
                let expected = format!("{} bytes", buffer.length());
                return Err(no.value(key, expected, bytes.len()));
            }
            data.push(bytes);
        }
        Ok(Self { no, data })
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], SceneError> {
        let buffer = &self.data[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer.get(view.offset()..end))
            .ok_or_else(|| {
                self.no.value(
                    format!("bufferViews[{}]", view.index()),
                    format!("within the {} bytes of its buffer", buffer.len()),
                    format!("{} bytes from {}", view.length(), view.offset()),
                )
            })
    }

    /// The elements of an accessor as they lie in memory.
    fn elements(&self, accessor: &Accessor<'_>) -> Result<Vec<&[u8]>, SceneError> {
        let key = format!("accessors[{}]", accessor.index());
        if accessor.sparse().is_some() {
            return Err(self.no.value(key, "plain values", "a sparse accessor"));
        }
        let Some(view) = accessor.view() else {
            return Err(self.no.value(key, "a bufferView", "none"));
        };
        let bytes = self.view(&view)?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if stride < size || accessor.count() == 0 {
            let expected = format!("at least one element of {size} bytes");
            let found = format!("{} of {stride} bytes", accessor.count());
            return Err(self.no.value(key, expected, found));
        }
        let end = (accessor.count() - 1)
            .checked_mul(stride)
            .and_then(|last| last.checked_add(accessor.offset()))
            .and_then(|last| last.checked_add(size));
        if end.is_none_or(|end| end > bytes.len()) {
            return Err(self.no.value(
                key,
                format!("within the {} bytes of its view", bytes.len()),
                format!(
                    "{} elements of {size} bytes, {stride} apart, from {}",
                    accessor.count(),
                    accessor.offset()
                ),
            ));
        }
        Ok((0..accessor.count())
            .map(|i| &bytes[accessor.offset() + i * stride..][..size])
            .collect())
    }

    /// Vectors of N numbers: floats, or whole numbers that stand for [0, 1].
    pub(super) fn vectors<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let wanted = if N == 2 {
            Dimensions::Vec2
        } else {
            Dimensions::Vec3
        };
        let number: fn(&[u8]) -> f32 = match (accessor.data_type(), accessor.normalized()) {
            (DataType::F32, _) => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            (DataType::U8, true) => |b| f32::from(b[0]) / 255.0,
            (DataType::U16, true) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
            (other, _) => return Err(self.mistyped(accessor, "floats", &format!("{other:?}"))),
        };
        if accessor.dimensions() != wanted {
            let found = format!("{:?}", accessor.dimensions());
            return Err(self.mistyped(accessor, &format!("{wanted:?}"), &found));
        }
        let elements = self.elements(accessor)?.into_iter();
        let values = elements.map(|bytes| {
            let size = bytes.len() / N;
            core::array::from_fn(|k| number(&bytes[k * size..]))
        });
        let values: Vec<[f32; N]> = values.collect();
        let is_finite = |value: &[f32; N]| value.iter().all(|v| v.is_finite());
        match values.iter().position(|value| !is_finite(value)) {
            None => Ok(values),
            Some(at) => Err(self.no.value(
                format!("accessors[{}], element {at}", accessor.index()),
                "finite numbers",
                format!("{:?}", values[at]),
            )),
        }
    }

    /// Indices of vertices.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, SceneError> {
        let number: fn(&[u8]) -> u32 = match accessor.data_type() {
            DataType::U8 => |b| u32::from(b[0]),
            DataType::U16 => |b| u32::from(u16::from_le_bytes([b[0], b[1]])),
            DataType::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            other => return Err(self.mistyped(accessor, "U8, U16 or U32", &format!("{other:?}"))),
        };
        if accessor.dimensions() != Dimensions::Scalar {
            let found = format!("{:?}", accessor.dimensions());
            return Err(self.mistyped(accessor, "Scalar", &found));
        }
        Ok(self.elements(accessor)?.into_iter().map(number).collect())
    }

    fn mistyped(&self, accessor: &Accessor<'_>, expected: &str, found: &str) -> SceneError {
        let key = format!("accessors[{}]", accessor.index());
        self.no.value(key, expected, found)
    }
}

/// What a URI stands for; or what was expected and what was found.
pub(super) fn resolve(uri: &str, path: &Path) -> Result<Vec<u8>, (String, String)> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err((
                "base64 in a data URI".to_owned(),
                "something else".to_owned(),
            ));
        };
        let engine = base64::engine::general_purpose::STANDARD;
        return engine
            .decode(text)
            .map_err(|error| ("base64 in a data URI".to_owned(), error.to_string()));
    }
    if uri.contains(':') {
        let expected = "a file beside this one, or a data URI";
        return Err((expected.to_owned(), format!("\"{uri}\"")));
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let file = path.parent().unwrap_or(Path::new("")).join(&*name);
    std::fs::read(&file).map_err(|error| (file.display().to_string(), error.to_string()))
}
