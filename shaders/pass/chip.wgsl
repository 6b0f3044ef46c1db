// An eye's sensor and what becomes of its samples: see develop/mod.rs.

const CHIP_PLAIN: u32 = 0u;
const CHIP_THREE: u32 = 1u;
const CHIP_MOSAIC: u32 = 2u;

/// Taps of a kernel at most.
const TAPS: u32 = 11u;

struct Chip {
    kind: u32,
    emva: Emva,
    /// Electrons per W m⁻² sr⁻¹; of the plain sensor fractions of full scale.
    gain: f32,
    /// Random numbers of an exposure, and of the specimen.
    exposure_low: u32,
    exposure_high: u32,
    specimen_low: u32,
    specimen_high: u32,
    /// What no other eye's counter has.
    stream: u32,
    has_pattern: u32,
    /// Column and row, modulo 2, of red.
    red_column: u32,
    red_row: u32,
    /// Noise of the plain sensor, fraction of full scale.
    sigma: f32,
    /// What a full well reads, codes times their parts, and of that fraction darkness.
    highest: f32,
    dark: f32,
    /// White balance, then the rows of the colour matrix.
    balance: vec3<f32>,
    matrix: array<vec4<f32>, 3>,
    /// Of the image: 255 or 65535.
    full_scale: f32,
    /// Kernels of the demosaicing, cross, row and diagonal: columns, rows, weight.
    taps: array<array<vec4<i32>, TAPS>, 3>,
}

@group(1) @binding(0) var<storage, read> chip: Chip;
/// Cells of the normal distribution's quantile.
@group(1) @binding(1) var<storage, read> cubics: array<vec4<f32>>;
/// The converter's codes, two a word.
@group(1) @binding(2) var<storage, read_write> codes: array<u32>;
/// The image, two or four samples a word.
@group(1) @binding(3) var<storage, read_write> packed: array<u32>;

fn chip_normals(key: vec2<u32>, counter: vec4<u32>) -> vec4<f32> {
    let words = noise_words(key, counter);
    return vec4<f32>(
        noise_normal(cubics[words.x >> 23u], words.x),
        noise_normal(cubics[words.y >> 23u], words.y),
        noise_normal(cubics[words.z >> 23u], words.z),
        noise_normal(cubics[words.w >> 23u], words.w),
    );
}
