// The light of every particle of snow.

@compute @workgroup_size(64)
fn light_flakes(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    if index >= arrayLength(&flakes) {
        return;
    }
    let flake = flakes[index];
    let way = flake.centre_m - flake.from_m;
    let sight = normalize(way);
    if flake.is_small != 0u && (scene_seabed_hit(flake.from_m, sight) < flake.range_m * (1.0 - GAP) - GAP
        || scene_is_blocked(flake.from_m, sight, flake.range_m, Hit())) {
        flakes[index].opacity = 0.0;
        tile_check_loops();
        return;
    }
    var lamps_light = vec3<f32>(0.0);
    var source = vec3<f32>(0.0);
    for (var i = 0u; i < frame.lamps && MODE != MODE_KOSCHMIEDER; i++) {
        let lamp = lamps[i];
        let away = flake.centre_m - lamp.position_m;
        let r = length(away);
        let towards = away / r;
        let beam = light_cone(lamp, towards);
        if beam == 0.0 || scene_is_blocked(lamp.position_m, towards, r, Hit()) {
            continue;
        }
        let share = beam * sphere_share(dot(towards, sight)) / (3.14159265358979 * r * r);
        let radiance = lamp.radiant_intensity_w_per_sr * share * medium_transmittance(frame.lamp_attenuation_per_m, r);
        lamps_light += frame.snow_albedo * radiance;
        source -= towards * dot(radiance, vec3<f32>(1.0));
    }
    // The mean normal of a ball's disc is two thirds of the way to the eye.
    let ambient = scene_ambient_on(flake.centre_m, 2.0 / 3.0 * sight.z).wet;
    let wet = flake.gain * (lamps_light + frame.snow_albedo * ambient);
    flakes[index].direct = wet * medium_transmittance(frame.attenuation_per_m, flake.range_m);
    if MODE == MODE_FULL {
        flakes[index].scattered = scene_scattered(wet, flake.range_m);
    }
    let all = dot(wet, vec3<f32>(1.0));
    if flake.is_round != 0u && all > 0.0 && any(source != vec3<f32>(0.0)) {
        let lit = normalize(source);
        flakes[index].lit_from = vec3<f32>(dot(lit, flake.aside), dot(lit, cross(-sight, flake.aside)), -dot(lit, sight));
        flakes[index].shading = flake.gain * dot(lamps_light, vec3<f32>(1.0)) / all;
    }
    tile_check_loops();
}
