// From light to the converter's codes, of two pixels.

// What random numbers are for; see develop/emva.rs.
const ELECTRONS: u32 = 1u;
const PATTERN: u32 = 2u;
const FEW_PHOTONS: u32 = 3u;

fn sense_code(pixel: u32, part: u32, light: f32, noise: vec2<f32>, pattern: vec2<f32>) -> u32 {
    let key = vec2<u32>(chip.exposure_low, chip.exposure_high);
    let few_photons = vec4<u32>(pixel, part, chip.stream | FEW_PHOTONS, 0u);
    return emva_expose(chip.emva, key, chip.gain * light, noise, pattern, few_photons);
}

/// Normals of a pixel: three pairs, of which a mosaic takes one.
fn sense_normals(key: vec2<u32>, pixel: u32, purpose: u32) -> array<vec2<f32>, 3> {
    let stream = chip.stream | purpose;
    let first = chip_normals(key, vec4<u32>(pixel, 0u, stream, 0u));
    if chip.kind == CHIP_MOSAIC {
        return array(first.xy, vec2<f32>(0.0), vec2<f32>(0.0));
    }
    let next = chip_normals(key, vec4<u32>(pixel, 1u, stream, 0u));
    return array(first.xw, vec2<f32>(first.y, next.x), vec2<f32>(first.z, next.y));
}

/// Three codes of a pixel, or the one of its filter first.
fn sense_pixel(pixel: u32) -> vec3<u32> {
    if pixel >= film.width * film.height {
        return vec3<u32>(0u);
    }
    let light = film_light(pixel);
    let noise = sense_normals(vec2<u32>(chip.exposure_low, chip.exposure_high), pixel, ELECTRONS);
    var pattern = array<vec2<f32>, 3>();
    if chip.has_pattern != 0u {
        pattern = sense_normals(vec2<u32>(chip.specimen_low, chip.specimen_high), pixel, PATTERN);
    }
    if chip.kind == CHIP_MOSAIC {
        let at = vec2<u32>(pixel % film.width, pixel / film.width);
        let band = bayer_filter(vec2<u32>(chip.red_column, chip.red_row), at);
        return vec3<u32>(sense_code(pixel, 0u, light[band], noise[0], pattern[0]), 0u, 0u);
    }
    return vec3<u32>(
        sense_code(pixel, 0u, light.x, noise[0], pattern[0]),
        sense_code(pixel, 1u, light.y, noise[1], pattern[1]),
        sense_code(pixel, 2u, light.z, noise[2], pattern[2]),
    );
}

@compute @workgroup_size(64)
fn sense(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = film_index(id);
    if 2u * index >= film.width * film.height {
        return;
    }
    let a = sense_pixel(2u * index);
    let b = sense_pixel(2u * index + 1u);
    if chip.kind == CHIP_MOSAIC {
        codes[index] = a.x | (b.x << 16u);
    } else {
        codes[3u * index] = a.x | (a.y << 16u);
        codes[3u * index + 1u] = a.z | (b.x << 16u);
        codes[3u * index + 2u] = b.y | (b.z << 16u);
    }
}
