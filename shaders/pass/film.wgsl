// The light that falls on an eye's sensor: its whole image.

struct Film {
    camera: Camera,
    lens: u32,
    has_halo: u32,
    has_vignetting: u32,
    /// Bits of the bands that are written.
    bands: u32,
    vignetting: vec2<f32>,
    width: u32,
    height: u32,
    /// Gains of automatic exposure's eye.
    balance: vec3<f32>,
    /// Of the blur, px.
    reach: u32,
}

@group(0) @binding(0) var<uniform> film: Film;
@group(0) @binding(1) var<storage, read_write> image: array<f32>;
/// The halo, or the image before it is blurred.
@group(0) @binding(2) var<storage, read> source: array<f32>;
/// Weights of the blur, from its middle outwards.
@group(0) @binding(3) var<storage, read> weights: array<f32>;

fn film_light(pixel: u32) -> vec3<f32> {
    return vec3<f32>(image[3u * pixel], image[3u * pixel + 1u], image[3u * pixel + 2u]);
}

fn film_source(pixel: u32) -> vec3<f32> {
    return vec3<f32>(source[3u * pixel], source[3u * pixel + 1u], source[3u * pixel + 2u]);
}

fn film_store(pixel: u32, value: vec3<f32>) {
    for (var band = 0u; band < 3u; band++) {
        if ((film.bands >> band) & 1u) != 0u {
            image[3u * pixel + band] = value[band];
        }
    }
}

/// A dispatch has at most 65535 workgroups a dimension; more than 32768 of them make another row.
fn film_index(id: vec3<u32>) -> u32 {
    return id.y * 32768u * 64u + id.x;
}
