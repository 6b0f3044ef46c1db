// Light that the water scatters into a ray: see cpu/light.rs, cpu/shadow.rs and optics/src/airlight.rs.

fn water_phase_per_sr(one_minus_cos: f32) -> f32 {
    if PHASE_TABLE {
        let last = frame.phase_nodes - 1u;
        let at = phase_table_place(one_minus_cos) * f32(last);
        let node = min(u32(at), last - 1u);
        return exp(mix(phase[node], phase[node + 1u], at - f32(node)));
    }
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        sum += phase_lobe_per_sr(frame.lobes[i].xyz, one_minus_cos);
    }
    return sum;
}

/// Midpoints of a stretch: as dense in the angle about the lamp as the scene's are on half a turn, and four at least.
fn water_points_on(lamp: Lamp, ray: EyeRay, from_m: f32, to_m: f32) -> u32 {
    let points = frame.airlight_points;
    let origin_m = ray.origin_m - lamp.position_m;
    let start_m = origin_m + ray.direction * from_m;
    let end_m = origin_m + ray.direction * to_m;
    let angle_rad = atan2(length(cross(start_m, end_m)), dot(start_m, end_m));
    return clamp(u32(ceil(f32(points) * angle_rad / 3.14159265)), min(points, 4u), points);
}

/// What one lamp's light adds to a stretch of a ray: (b/h) I Σ p(μ) cone e^(-K(r+t)) dθ.
fn water_scattered(lamp: Lamp, ray: EyeRay, from_m: f32, to_m: f32, points: u32) -> vec3<f32> {
    let direction = ray.direction;
    let nodes = airlight_nodes(lamp.position_m - (ray.origin_m + direction * from_m), direction, to_m - from_m, points);
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < points; i++) {
        let node = airlight_node(nodes, i);
        let light = light_cone(lamp, nodes.across * node.y + direction * node.x);
        if light > 0.0 {
            let r = nodes.distance_to_ray_m / node.y;
            let path = r + nodes.nearest_t_m + r * node.x + from_m;
            let source = light * water_phase_per_sr(airlight_one_minus_cos(node));
            sum += source * medium_transmittance(frame.lamp_attenuation_per_m, path);
        }
    }
    return frame.scattering_per_m * lamp.radiant_intensity_w_per_sr * sum * nodes.weight_per_m;
}

/// The first stretch of a ray, of those that end beyond `after_m`, that a lamp does not reach; (distance, distance) if none.
fn water_next_dark(lamp: u32, ray: EyeRay, distance_m: f32, after_m: f32) -> vec2<f32> {
    var next = vec2<f32>(distance_m);
    let lamp_m = lamps[lamp].position_m - ray.origin_m;
    let direction = ray.direction;
    let nearest_t = dot(lamp_m, direction);
    let foot = direction * nearest_t - lamp_m;
    let to_ray = length(foot);
    // All points of a ray through the lamp are in its light: the ray ends at what could stand between.
    if to_ray < 1e-6 {
        return next;
    }
    let across = foot / to_ray;
    let begin = normalize(vec2<f32>(to_ray, after_m - nearest_t));
    let end = normalize(vec2<f32>(to_ray, distance_m - nearest_t));
    let section = ShadowSection(cross(across, direction), to_ray, across, direction, begin, end);
    for (var i = lamp * frame.casters; i < (lamp + 1u) * frame.casters; i++) {
        let span = shadow_span(casters[i], section);
        let dark = vec2<f32>(max(nearest_t + span.x, 0.0), min(nearest_t + span.y, distance_m));
        if dark.y - dark.x <= MIN_STRETCH_M || dark.y <= after_m + MIN_STRETCH_M || dark.x >= next.x {
            continue;
        }
        let to_middle = direction * (0.5 * (dark.x + dark.y)) - lamp_m;
        let middle = length(to_middle);
        let probe = span.z == 0.0;
        if !probe || solid_hit(casters[i].solid, vec3<f32>(0.0), to_middle / middle).t_m < middle * (1.0 - GAP) {
            next = dark;
        }
    }
    return next;
}

/// What all lamps' light would add to a ray if nothing stood in it.
fn water_unshadowed(ray: EyeRay, pixel: vec2<f32>, distance_m: f32) -> vec3<f32> {
    if !AIRLIGHT_TABLE {
        var sum = vec3<f32>(0.0);
        for (var i = 0u; i < frame.lamps; i++) {
            sum += water_scattered(lamps[i], ray, 0.0, min(distance_m, frame.horizon_m), frame.airlight_points);
        }
        return sum;
    }
    let column = airlight_grid_cell(pixel.x * frame.grid_scale.x, frame.grid_columns);
    let row = airlight_grid_cell(pixel.y * frame.grid_scale.y, frame.grid_rows);
    let steps = airlight_grid_steps(distance_m, frame.grid_half_way_m, frame.grid_steps);
    let step = airlight_grid_cell(steps, frame.grid_steps + 1u);
    let weights = airlight_grid_hermite(step.y);
    let first = u32(row.x) * frame.grid_columns + u32(column.x);
    let above = mix(water_knots(first, step.x, weights), water_knots(first + 1u, step.x, weights), column.y);
    let next = first + frame.grid_columns;
    let below = mix(water_knots(next, step.x, weights), water_knots(next + 1u, step.x, weights), column.y);
    return mix(above, below, row.y);
}

fn water_knots(corner: u32, step: f32, weights: vec4<f32>) -> vec3<f32> {
    let knot = 2u * (corner * (frame.grid_steps + 1u) + u32(step));
    return weights.x * airlight[knot].xyz + weights.y * airlight[knot + 1u].xyz
        + weights.z * airlight[knot + 2u].xyz + weights.w * airlight[knot + 3u].xyz;
}

/// The veil of the ambient light, B∞ (1 - e^(-K z)) with B∞ = b L / K, and of daylight.
fn water_veil(ray: EyeRay, distance_m: f32) -> vec3<f32> {
    let k = frame.lamp_attenuation_per_m;
    let share = frame.veil_scattering_per_m / max(k, vec3<f32>(1e-30));
    let veil = share * frame.ambient_radiance * maths_rise(k * min(distance_m, 1e30));
    let depth_m = ray.origin_m.z + frame.rig_from_eye_m.z;
    let here = daylight_downwelling(frame.daylight_w_per_m2, frame.daylight_attenuation_per_m, depth_m);
    let sky = daylight_veil(here, k, frame.veil_scattering_per_m, frame.daylight_attenuation_per_m, ray.direction.z, distance_m);
    return select(vec3<f32>(0.0), veil + sky, k > vec3<f32>(0.0));
}

/// Light the water scatters into the first `distance_m` of the ray through a pixel (`SOLID_NONE_M` where there is no surface), at the
/// lens.
fn water_backscatter(ray: EyeRay, pixel: vec2<f32>, distance_m: f32) -> vec3<f32> {
    if MODE == MODE_AIR {
        return vec3<f32>(0.0);
    }
    let veil = water_veil(ray, distance_m);
    if MODE == MODE_KOSCHMIEDER {
        return ray.gain * veil;
    }
    var light = water_unshadowed(ray, pixel, distance_m);
    let end = min(distance_m, frame.horizon_m);
    for (var i = 0u; i < frame.lamps; i++) {
        var lit_from = 0.0;
        while end - lit_from > MIN_STRETCH_M {
            let dark = water_next_dark(i, ray, end, lit_from);
            let from_m = max(dark.x, lit_from);
            if dark.y - from_m > MIN_STRETCH_M {
                light -= water_scattered(lamps[i], ray, from_m, dark.y, water_points_on(lamps[i], ray, from_m, dark.y));
            }
            lit_from = max(lit_from, dark.y);
        }
    }
    // Where all of it is in the dark, the two sums differ by their quadratures.
    return ray.gain * (veil + max(light, vec3<f32>(0.0)));
}
