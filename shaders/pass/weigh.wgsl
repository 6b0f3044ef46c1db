// The light of a tile's pixels by widths: planes of the fine ones, sums over stretches of a row for the cells of the others.

const RUN_PX: u32 = 16u;

/// The part of the light of a pixel's surfaces that a width has.
fn weigh_surfaces(at: u32, pixel: u32) -> vec3<f32> {
    let pixels = tile.width * tile.rows;
    let place = keys[3u * pixels + pixel];
    if place == 0u {
        return halo_shared(at, vec4<f32>(tile_light(9u, pixel), surface[7u * pixels + pixel]));
    }
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < THINGS; i++) {
        let source = sources[(place - 1u) * THINGS + i];
        if source.w < 0.0 {
            break;
        }
        sum += halo_shared(at, source);
    }
    return sum;
}

/// And of its snow's.
fn weigh_snow(at: u32, column: u32, image_row: u32) -> vec3<f32> {
    let pairs = snow_of(column, image_row);
    var sum = vec3<f32>(0.0);
    for (var i = pairs.x; i < pairs.y; i++) {
        let pair = snow_pairs[i];
        if pair.lit > 0.0 {
            let flake = flakes[pair.flake];
            sum += halo_shared(at, vec4<f32>(pair.lit * flake.scattered, flake.range_m));
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn weigh(@builtin(global_invocation_id) id: vec3<u32>) {
    let start = id.x * RUN_PX;
    let row = tile.kept_from + id.y;
    if start >= tile.width || row >= tile.kept_to {
        return;
    }
    let image_row = tile.first_row + row;
    let its = halo.levels[id.z];
    var sum = vec3<f32>(0.0);
    for (var column = start; column < min(start + RUN_PX, tile.width); column++) {
        let value = weigh_surfaces(id.z, row * tile.width + column) + weigh_snow(id.z, column, image_row);
        if id.z < FINE {
            halo_store_fine(id.z, vec2<i32>(vec2<u32>(column, image_row)), value);
            continue;
        }
        sum += value;
        if (column + 1u) % its.run_px == 0u || column + 1u == tile.width {
            let run = 3u * (image_row * halo.runs + its.first_run + column / its.run_px);
            runs[run] = sum.x;
            runs[run + 1u] = sum.y;
            runs[run + 2u] = sum.z;
            sum = vec3<f32>(0.0);
        }
    }
}
