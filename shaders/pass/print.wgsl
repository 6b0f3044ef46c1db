// From codes, or the light of the plain sensor, to the image, of four pixels: mosaic, white balance, colour matrix, sRGB, quantisation.

const CROSS: u32 = 0u;
const ROW: u32 = 1u;
const DIAGONAL: u32 = 2u;

fn print_code(at: u32) -> i32 {
    return i32((codes[at / 2u] >> (16u * (at & 1u))) & 0xffffu);
}

/// A band guessed from a pixel's neighbours.
fn print_sum(kernel: u32, pixel: vec2<i32>, is_upright: bool) -> i32 {
    var sum = 0;
    for (var i = 0u; i < TAPS; i++) {
        let tap = chip.taps[kernel][i];
        let there = pixel + select(tap.xy, tap.yx, is_upright);
        let column = bayer_mirrored(there.x, i32(film.width));
        let row = bayer_mirrored(there.y, i32(film.height));
        sum += tap.z * print_code(u32(row) * film.width + u32(column));
    }
    return sum;
}

/// All three bands under colour filters, parts of a code.
fn print_demosaic(index: u32) -> vec3<i32> {
    let pixel = vec2<u32>(index % film.width, index / film.width);
    let at = vec2<i32>(pixel);
    let own = 16 * print_code(index);
    let band = bayer_filter(vec2<u32>(chip.red_column, chip.red_row), pixel);
    if band == 1u {
        // Red lies left and right of this green in the rows that have red.
        let is_red_beside = (pixel.y & 1u) == chip.red_row;
        return vec3<i32>(print_sum(ROW, at, !is_red_beside), own, print_sum(ROW, at, is_red_beside));
    }
    let cross = print_sum(CROSS, at, false);
    let diagonal = print_sum(DIAGONAL, at, false);
    return select(vec3<i32>(diagonal, cross, own), vec3<i32>(own, cross, diagonal), band == 0u);
}

fn print_encode(linear: vec3<f32>) -> vec3<f32> {
    let balanced = chip.balance * linear;
    return vec3<f32>(
        srgb_encode(dot(chip.matrix[0].xyz, balanced)),
        srgb_encode(dot(chip.matrix[1].xyz, balanced)),
        srgb_encode(dot(chip.matrix[2].xyz, balanced)),
    );
}

fn print_pixel(pixel: u32) -> vec3<u32> {
    if pixel >= film.width * film.height {
        return vec3<u32>(0u);
    }
    var encoded: vec3<f32>;
    if chip.kind == CHIP_PLAIN {
        encoded = print_encode(chip.gain * film_light(pixel));
        if chip.sigma > 0.0 {
            let key = vec2<u32>(chip.exposure_low, chip.exposure_high);
            encoded += chip.sigma * chip_normals(key, vec4<u32>(pixel, 0u, chip.stream, 0u)).xyz;
        }
    } else {
        var code: vec3<i32>;
        if chip.kind == CHIP_MOSAIC {
            code = print_demosaic(pixel);
        } else {
            code = vec3<i32>(print_code(3u * pixel), print_code(3u * pixel + 1u), print_code(3u * pixel + 2u));
        }
        encoded = print_encode(vec3<f32>(code) / chip.highest - chip.dark);
    }
    return vec3<u32>(floor(clamp(encoded, vec3<f32>(0.0), vec3<f32>(1.0)) * chip.full_scale + 0.5));
}

@compute @workgroup_size(64)
fn print(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = film_index(id);
    if 4u * index >= film.width * film.height {
        return;
    }
    var p: array<vec3<u32>, 4>;
    for (var i = 0u; i < 4u; i++) {
        p[i] = print_pixel(4u * index + i);
    }
    if chip.full_scale < 256.0 {
        packed[3u * index] = p[0].x | (p[0].y << 8u) | (p[0].z << 16u) | (p[1].x << 24u);
        packed[3u * index + 1u] = p[1].y | (p[1].z << 8u) | (p[2].x << 16u) | (p[2].y << 24u);
        packed[3u * index + 2u] = p[2].z | (p[3].x << 8u) | (p[3].y << 16u) | (p[3].z << 24u);
        return;
    }
    for (var i = 0u; i < 2u; i++) {
        let a = p[2u * i];
        let b = p[2u * i + 1u];
        let word = 6u * index + 3u * i;
        packed[word] = a.x | (a.y << 16u);
        packed[word + 1u] = a.z | (b.x << 16u);
        packed[word + 2u] = b.y | (b.z << 16u);
    }
}
