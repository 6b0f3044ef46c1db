// The halo, and the lens's darker corners.

@compute @workgroup_size(8, 8)
fn lens(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= film.width || id.y >= film.height {
        return;
    }
    let pixel = id.y * film.width + id.x;
    var light = film_light(pixel);
    if film.has_halo != 0u {
        light += film_source(pixel);
    }
    if film.has_vignetting != 0u {
        light *= lens_vignetting(film.lens, film.camera, film.vignetting, vec2<f32>(id.xy));
    }
    film_store(pixel, light);
}
