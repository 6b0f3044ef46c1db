// A Gaussian along one direction; beyond its border the image goes on as its outermost pixels are: see lens/blur.rs.

override ALONG_COLUMNS: bool = false;

fn smear_source(at: vec2<i32>) -> vec3<f32> {
    let there = clamp(at, vec2<i32>(0), vec2<i32>(i32(film.width), i32(film.height)) - 1);
    return film_source(u32(there.y) * film.width + u32(there.x));
}

@compute @workgroup_size(8, 8)
fn smear(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= film.width || id.y >= film.height {
        return;
    }
    let at = vec2<i32>(id.xy);
    let along = select(vec2<i32>(1, 0), vec2<i32>(0, 1), ALONG_COLUMNS);
    // From the small weights to the large, where fewer digits are lost.
    var sum = vec3<f32>(0.0);
    for (var step = i32(film.reach); step > 0; step--) {
        sum += weights[step] * (smear_source(at - step * along) + smear_source(at + step * along));
    }
    film_store(id.y * film.width + id.x, sum + weights[0] * smear_source(at));
}
