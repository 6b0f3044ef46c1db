// The light of a tile's pixels by widths: planes of the fine ones, sums over stretches of a row for the cells of the others.

const RUN_PX: u32 = 16u;

/// By width: of the fine ones the pixel's light, of the others the run's so far.
var<private> weighed: array<vec3<f32>, LEVELS>;

/// Light between two knots that is still to be weighed: of the nearer one and of the farther one. Snow comes in the order of its range,
/// so that a storm of it takes few more steps than a flake.
var<private> between: u32;
var<private> nearer: vec3<f32>;
var<private> farther: vec3<f32>;

fn weigh_add(scattered: vec4<f32>) {
    let place = halo_place(scattered.w, halo.longest_m, halo.knots - 1u);
    let knot = min(u32(place), halo.knots - 2u);
    if knot != between {
        weigh_all();
        between = knot;
    }
    let along = place - f32(knot);
    nearer += (1.0 - along) * scattered.xyz;
    farther += along * scattered.xyz;
}

fn weigh_all() {
    for (var at = 0u; at < halo.count; at++) {
        weighed[at] += nearer * halo_share(at, between, 0.0) + farther * halo_share(at, between, 1.0);
    }
    nearer = vec3<f32>(0.0);
    farther = vec3<f32>(0.0);
}

fn weigh_pixel(column: u32, row: u32) {
    let pixels = tile.width * tile.rows;
    let pixel = row * tile.width + column;
    let place = keys[3u * pixels + pixel];
    if place == 0u {
        weigh_add(vec4<f32>(tile_light(9u, pixel), surface[7u * pixels + pixel]));
    } else {
        for (var i = (place - 1u) * THINGS; i < place * THINGS && sources[i].w >= 0.0; i++) {
            weigh_add(sources[i]);
        }
    }
    let pairs = snow_of(column, tile.first_row + row);
    for (var i = pairs.x; i < pairs.y; i++) {
        let pair = snow_pairs[i];
        if pair.lit > 0.0 {
            let flake = flakes[pair.flake];
            weigh_add(vec4<f32>(pair.lit * flake.scattered, flake.range_m));
        }
    }
    weigh_all();
}

@compute @workgroup_size(8, 8)
fn weigh(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = id.x * RUN_PX;
    let row = tile.kept_from + id.y;
    if first >= tile.width || row >= tile.kept_to {
        return;
    }
    let image_row = tile.first_row + row;
    for (var column = first; column < min(first + RUN_PX, tile.width); column++) {
        weigh_pixel(column, row);
        for (var at = 0u; at < halo.count; at++) {
            let its = halo.levels[at];
            if at < FINE {
                halo_store_fine(at, vec2<i32>(vec2<u32>(column, image_row)), weighed[at]);
                weighed[at] = vec3<f32>(0.0);
            } else if (column + 1u) % its.run_px == 0u || column + 1u == tile.width {
                let run = 3u * (image_row * halo.runs + its.first_run + column / its.run_px);
                runs[run] = weighed[at].x;
                runs[run + 1u] = weighed[at].y;
                runs[run + 2u] = weighed[at].z;
                weighed[at] = vec3<f32>(0.0);
            }
        }
    }
    tile_check_loops();
}
