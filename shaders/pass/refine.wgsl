// Pixels at edges: the mean over all samples of the lattice. Light from surfaces is taken at every sample; light from the
// water, smooth but for the length of the ray, once for each thing seen in the pixel, at its mean distance.
// One invocation a pixel sums its samples in order: which pixels share a workgroup changes nothing.

struct Indirect {
    x: u32,
    y: u32,
    z: u32,
    count: u32,
}

@group(2) @binding(0) var<storage, read> indirect: Indirect;

@compute @workgroup_size(64)
fn refine(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= indirect.count {
        return;
    }
    let pixel = edges[id.x];
    let column = pixel % tile.width;
    let row = tile.first_row + pixel / tile.width;
    let corner = vec2<f32>(vec2<u32>(column, row));
    var shift = vec2<f32>(0.0);
    if frame.shifts != 0u {
        shift = lattice_pixel_shift(column, row);
    }
    var direct = vec3<f32>(0.0);
    var clean = vec3<f32>(0.0);
    var transmission = vec3<f32>(0.0);
    var things: array<u32, THINGS>;
    var counts: array<f32, THINGS>;
    var ranges: array<f32, THINGS>;
    var wets: array<vec3<f32>, THINGS>;
    var seen = 0u;
    for (var i = 0u; i < frame.samples; i++) {
        let inside = lattice_place(offsets[i], shift);
        let ray = eye_ray(corner, inside);
        let hit = scene_hit(ray.origin_m, ray.direction);
        let sample = scene_light(ray, hit);
        direct += sample.direct;
        clean += sample.clean;
        transmission += sample.transmission;
        var place = 0u;
        while place < seen && things[place] != hit.instance && place + 1u < THINGS {
            place++;
        }
        if place == seen {
            things[place] = hit.instance;
            counts[place] = 0.0;
            ranges[place] = 0.0;
            wets[place] = vec3<f32>(0.0);
            seen++;
        }
        counts[place] += 1.0;
        ranges[place] += min(hit.t_m, frame.horizon_m);
        wets[place] += sample.wet;
    }
    let share = 1.0 / f32(frame.samples);
    let middle = eye_ray(corner, vec2<f32>(0.5));
    var scattered = vec3<f32>(0.0);
    for (var place = 0u; place < seen; place++) {
        let mean = ranges[place] / counts[place];
        let range = select(mean, SOLID_NONE_M, things[place] == NOTHING);
        scattered += water_backscatter(middle, corner + 0.5, range) * (counts[place] * share);
        if MODE == MODE_FULL {
            sources[id.x * THINGS + place] = vec4<f32>(scene_scattered(wets[place] * share, mean), mean);
        }
    }
    if MODE == MODE_FULL && seen < THINGS {
        sources[id.x * THINGS + seen] = vec4<f32>(0.0, 0.0, 0.0, -1.0);
    }
    tile_store(0u, pixel, direct * share);
    tile_store(3u, pixel, scattered);
    tile_store(6u, pixel, clean * share);
    tile_store_surface(0u, pixel, transmission * share);
}
