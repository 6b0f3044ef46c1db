//! The truth channels as `OpenEXR`.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    ReadChannels, ReadLayers, WritableImage,
};

use crate::RenderError;
use crate::frame::{EyeFrame, PixelTruth};
use crate::whole_file::{io, write_whole};

/// Suffixes of the channels of a triple.
const BANDS: [&str; 3] = ["R", "G", "B"];
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// A triple of channels: prefix, suffixes, where it lies in a pixel.
type Triple = (
    &'static str,
    [&'static str; 3],
    fn(&mut PixelTruth) -> &mut [f32; 3],
);
/// A channel of its own.
type Scalar = (&'static str, fn(&mut PixelTruth) -> &mut f32);

/// The one list of floating-point channels: writer and reader both go by it. Radiance is plain R, G, B, as viewers expect.
const TRIPLES: [Triple; 8] = [
    ("", BANDS, |p| &mut p.radiance),
    ("direct.", BANDS, |p| &mut p.direct),
    ("forward.", BANDS, |p| &mut p.forward),
    ("backscatter.", BANDS, |p| &mut p.backscatter),
    ("snow.", BANDS, |p| &mut p.snow),
    ("clean.", BANDS, |p| &mut p.clean),
    ("transmission.", BANDS, |p| &mut p.transmission),
    ("normal.", AXES, |p| &mut p.normal),
];
const SCALARS: [Scalar; 4] = [
    ("snow_cover", |p| &mut p.snow_cover),
    ("depth_m", |p| &mut p.depth_m),
    ("range_m", |p| &mut p.range_m),
    ("disparity_px", |p| &mut p.disparity_px),
];

/// The triples that are light, and not geometry: means over the pixel.
pub(crate) fn light_fields() -> impl Iterator<Item = fn(&mut PixelTruth) -> &mut [f32; 3]> {
    let light = TRIPLES.iter().filter(|(_, suffixes, _)| *suffixes == BANDS);
    light.map(|(.., field)| *field)
}

/// Writes every channel of an eye as one layer.
pub(crate) fn write_exr(path: &Path, frame: &EyeFrame) -> Result<(), RenderError> {
    let whole = |name: &str, value: fn(&PixelTruth) -> u32| {
        AnyChannel::new(
            name,
            FlatSamples::U32(frame.pixels.iter().map(value).collect()),
        )
    };
    let mut channels = vec![
        whole("instance", |p| u32::from(p.instance)),
        whole("material", |p| u32::from(p.material)),
        whole("occluded", |p| u32::from(p.occluded)),
        whole("beyond_model", |p| u32::from(p.beyond_model)),
    ];
    // One pass over the pixels for all channels: they are a hundred bytes each.
    let names = SCALARS.iter().map(|(name, _)| (*name).to_owned());
    let names = names.chain(
        TRIPLES
            .iter()
            .flat_map(|(prefix, suffixes, _)| suffixes.map(|suffix| format!("{prefix}{suffix}"))),
    );
    let mut floats: Vec<(String, Vec<f32>)> = names
        .map(|name| (name, Vec::with_capacity(frame.pixels.len())))
        .collect();
    for pixel in &frame.pixels {
        let mut pixel = *pixel;
        let (scalars, triples) = floats.split_at_mut(SCALARS.len());
        for ((_, values), (_, field)) in scalars.iter_mut().zip(SCALARS) {
            values.push(*field(&mut pixel));
        }
        for (channels, (.., field)) in triples.chunks_exact_mut(3).zip(TRIPLES) {
            for ((_, values), value) in channels.iter_mut().zip(*field(&mut pixel)) {
                values.push(value);
            }
        }
    }
    channels.extend(
        floats
            .into_iter()
            .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values))),
    );
    let layer = Layer::new(
        (frame.width_px as usize, frame.height_px as usize),
        LayerAttributes::named("rodsight"),
        Encoding {
            compression: exr::prelude::Compression::ZIP16,
            // In any other order the blocks land as the threads finish them.
            line_order: LineOrder::Increasing,
            ..Encoding::FAST_LOSSLESS
        },
        AnyChannels::sort(channels.into()),
    );
    // Through memory: the writer seeks, and a file must appear whole or not at all.
    let mut bytes = Vec::new();
    Image::from_layer(layer)
        .write()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .map_err(|error| io(path, error))?;
    write_whole(path, |file| std::io::Write::write_all(file, &bytes))
}

/// Reads an eye's channels back.
///
/// # Errors
/// Not a file of ours: unreadable, no `OpenEXR`, or a channel missing.
pub fn read_exr(path: &Path) -> Result<EyeFrame, RenderError> {
    let image: Image<Layer<AnyChannels<FlatSamples>>> = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|error| io(path, error))?;
    let layer = image.layer_data;
    let mut pixels = vec![PixelTruth::default(); layer.size.area()];
    let mut fill = |name: &str, set: &dyn Fn(&mut PixelTruth, f32)| {
        let channel = layer
            .channel_data
            .list
            .iter()
            .find(|channel| channel.name == *name);
        let channel = channel
            .ok_or_else(|| io(path, format!("expected a channel \"{name}\", found none")))?;
        for (pixel, value) in pixels.iter_mut().zip(channel.sample_data.values_as_f32()) {
            set(pixel, value);
        }
        Ok::<(), RenderError>(())
    };
    // Instances and materials are small whole numbers: f32 holds them exactly.
    fill("instance", &|p, v| p.instance = v as u16)?;
    fill("material", &|p, v| p.material = v as u16)?;
    fill("occluded", &|p, v| p.occluded = v != 0.0)?;
    fill("beyond_model", &|p, v| p.beyond_model = v != 0.0)?;
    for (name, field) in SCALARS {
        fill(name, &|p, v| *field(p) = v)?;
    }
    for (prefix, suffixes, field) in TRIPLES {
        for (k, suffix) in suffixes.into_iter().enumerate() {
            fill(&format!("{prefix}{suffix}"), &|p, v| field(p)[k] = v)?;
        }
    }
    Ok(EyeFrame {
        width_px: layer.size.width() as u32,
        height_px: layer.size.height() as u32,
        pixels,
    })
}
