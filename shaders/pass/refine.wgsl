// Pixels at edges: the mean over all samples of the lattice. Light from surfaces is taken at every sample; light from the
// water, smooth but for the length of the ray, once for each thing seen in the pixel, at its mean distance.
// One workgroup a pixel: each lane casts some of the samples, the first sums them in order, so that who casts which changes nothing.
// (One invocation a pixel would walk so far in a rich scene that Mesa's software driver cuts its loops short, without a word.)

struct Indirect {
    x: u32,
    y: u32,
    z: u32,
    count: u32,
}

struct Cast {
    direct: vec3<f32>,
    instance: u32,
    clean: vec3<f32>,
    range_m: f32,
    transmission: vec3<f32>,
    wet: vec3<f32>,
}

const LANES: u32 = 64u;
/// Ranges are counted up to here, so that the sum of all samples is finite, m.
const FAR_M: f32 = 1e30;

@group(2) @binding(0) var<storage, read> indirect: Indirect;
var<workgroup> casts: array<Cast, LANES>;
/// Whether the pixel takes all samples.
var<workgroup> takes_all: u32;

/// Sums of the first lane, and what they bring of each thing.
var<private> direct: vec3<f32>;
var<private> clean: vec3<f32>;
var<private> transmission: vec3<f32>;
var<private> things: array<u32, THINGS>;
var<private> counts: array<f32, THINGS>;
var<private> ranges: array<f32, THINGS>;
var<private> wets: array<vec3<f32>, THINGS>;
var<private> seen: u32;

fn refine_gather(corner: vec2<f32>, shift: vec2<f32>, first: u32, samples: u32, lane: u32) {
    direct = vec3<f32>(0.0);
    clean = vec3<f32>(0.0);
    transmission = vec3<f32>(0.0);
    seen = 0u;
    for (var done = 0u; done < samples; done += LANES) {
        if done + lane < samples {
            let ray = eye_ray(corner, lattice_place(offsets[first + done + lane], shift));
            let hit = scene_hit(ray.origin_m, ray.direction);
            let sample = scene_light(ray, hit);
            let range_m = min(hit.t_m, FAR_M);
            casts[lane] =
                Cast(sample.direct, hit.instance, sample.clean, range_m, sample.transmission, sample.wet);
        }
        workgroupBarrier();
        for (var i = 0u; lane == 0u && i < min(LANES, samples - done); i++) {
            refine_add(casts[i]);
        }
        workgroupBarrier();
    }
}

fn refine_add(one: Cast) {
    direct += one.direct;
    clean += one.clean;
    transmission += one.transmission;
    var place = 0u;
    while place < seen && things[place] != one.instance && place + 1u < THINGS {
        place++;
    }
    if place == seen {
        things[place] = one.instance;
        counts[place] = 0.0;
        ranges[place] = 0.0;
        wets[place] = vec3<f32>(0.0);
        seen++;
    }
    counts[place] += 1.0;
    ranges[place] += one.range_m;
    wets[place] += one.wet;
}

@compute @workgroup_size(LANES)
fn refine(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = group.y * REFINE_ACROSS + group.x;
    if slot >= indirect.count {
        return;
    }
    let pixel = edges[slot];
    let column = pixel % tile.width;
    let row = tile.first_row + pixel / tile.width;
    let corner = vec2<f32>(vec2<u32>(column, row));
    var shift = vec2<f32>(0.0);
    if frame.shifts != 0u {
        shift = lattice_pixel_shift(column, row);
    }
    if lane == 0u {
        takes_all = keys[pixel] & KEY_WITHIN;
    }
    var samples = frame.samples;
    if workgroupUniformLoad(&takes_all) == 0u {
        samples = frame.inner_samples;
        refine_gather(corner, shift, frame.samples, samples, lane);
        // An outline, if there is one, is worth all samples.
        if lane == 0u {
            takes_all = select(1u, 0u, seen == 1u);
        }
    }
    if workgroupUniformLoad(&takes_all) != 0u {
        samples = frame.samples;
        refine_gather(corner, shift, 0u, samples, lane);
    }
    if lane != 0u {
        tile_check_loops();
        return;
    }
    let share = 1.0 / f32(samples);
    let middle = eye_ray(corner, vec2<f32>(0.5));
    var scattered = vec3<f32>(0.0);
    for (var place = 0u; place < seen; place++) {
        let mean = ranges[place] / counts[place];
        let range = select(mean, SOLID_NONE_M, things[place] == NOTHING);
        scattered += water_backscatter(middle, corner + 0.5, range) * (counts[place] * share);
        if MODE == MODE_FULL {
            sources[slot * THINGS + place] = vec4<f32>(scene_scattered(wets[place] * share, mean), mean);
        }
    }
    if MODE == MODE_FULL && seen < THINGS {
        sources[slot * THINGS + seen] = vec4<f32>(0.0, 0.0, 0.0, -1.0);
    }
    tile_store(0u, pixel, direct * share);
    tile_store(3u, pixel, scattered);
    tile_store(6u, pixel, clean * share);
    tile_store_surface(0u, pixel, transmission * share);
    tile_check_loops();
}
