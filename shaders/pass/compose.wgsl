// Snow between the surfaces and the lens: its light, what it hides, and what of it is to be spread.

/// Less of a pixel is rounding.
const LEAST_COVER: f32 = 1e-9;

/// From units of pixels to those of a disc.
fn compose_in_disc(flake: Flake, px: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(dot(flake.disc_per_px.xy, px), dot(flake.disc_per_px.zw, px));
}

/// Share of a pixel that a particle covers.
fn compose_cover(flake: Flake, pixel: vec2<i32>) -> f32 {
    let corner = compose_in_disc(flake, vec2<f32>(pixel - flake.pixel) - flake.inside_px);
    let right = flake.disc_per_px.xz;
    let down = flake.disc_per_px.yw;
    return flake.opacity * clamp(disc_area(corner, right, down) / disc_cross(right, down), 0.0, 1.0);
}

/// A particle's radiance in a pixel over its mean: a ball lit from one side, n·l over the mean of that.
fn compose_shade(flake: Flake, pixel: vec2<i32>) -> f32 {
    if flake.shading == 0.0 {
        return 1.0;
    }
    let at = compose_in_disc(flake, vec2<f32>(pixel - flake.pixel) + (0.5 - flake.inside_px));
    // A pixel that the limb crosses may have its middle outside.
    let inside = at / max(length(at), 1.0);
    let normal = vec3<f32>(inside, sqrt(max(1.0 - dot(inside, inside), 0.0)));
    let lit = max(dot(normal, flake.lit_from), 0.0) / max(sphere_share(flake.lit_from.z), 1e-3);
    return 1.0 + flake.shading * (lit - 1.0);
}

/// What the water sends up to a distance, as if no rod threw a shadow.
fn compose_water(ray: EyeRay, pixel: vec2<f32>, distance_m: f32) -> vec3<f32> {
    if MODE == MODE_KOSCHMIEDER {
        return water_veil(ray, distance_m);
    }
    return water_veil(ray, distance_m) + water_unshadowed(ray, pixel, distance_m);
}

@compute @workgroup_size(8, 8)
fn compose(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = tile.kept_from + id.y;
    if id.x >= tile.width || row >= tile.kept_to {
        return;
    }
    let pixels = tile.width * tile.rows;
    let at = row * tile.width + id.x;
    let pairs = snow_of(id.x, tile.first_row + row);
    var snow = vec3<f32>(0.0);
    var passed = 1.0;
    if pairs.x < pairs.y {
        let pixel = vec2<u32>(id.x, tile.first_row + row);
        let range = surface[7u * pixels + at];
        let middle = vec2<f32>(pixel) + 0.5;
        let ray = eye_ray(vec2<f32>(pixel), vec2<f32>(0.5));
        let all = compose_water(ray, middle, range);
        let backscatter = tile_light(3u, at);
        var before = vec3<f32>(0.0);
        for (var i = pairs.x; i < pairs.y; i++) {
            let flake = flakes[snow_pairs[i].flake];
            let cover = compose_cover(flake, vec2<i32>(pixel));
            snow_pairs[i].lit = 0.0;
            if cover < LEAST_COVER || (range < flake.range_m && flake.is_small == 0u) {
                continue;
            }
            let seen = passed * cover;
            let lit = seen * compose_shade(flake, vec2<i32>(pixel));
            snow_pairs[i].lit = lit;
            snow += lit * flake.direct;
            let near = compose_water(ray, middle, flake.range_m);
            before += seen * backscatter * select(vec3<f32>(1.0), near / all, near < all);
            passed *= 1.0 - cover;
        }
        tile_store(0u, at, passed * tile_light(0u, at));
        tile_store(3u, at, passed * backscatter + before);
        if MODE == MODE_FULL {
            compose_hide_sources(at, passed);
        }
    }
    tile_store(12u, at, snow);
    light[15u * pixels + at] = 1.0 - passed;
    tile_check_loops();
}

/// Takes from what is to be spread of a pixel's surfaces what snow hides.
fn compose_hide_sources(pixel: u32, passed: f32) {
    let place = keys[3u * tile.width * tile.rows + pixel];
    if place == 0u {
        tile_store(9u, pixel, passed * tile_light(9u, pixel));
        return;
    }
    for (var i = (place - 1u) * THINGS; i < place * THINGS; i++) {
        if sources[i].w < 0.0 {
            break;
        }
        sources[i] = vec4<f32>(passed * sources[i].xyz, sources[i].w);
    }
}
