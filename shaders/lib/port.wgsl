// The glass between a camera and the water: see geometry/src/port.rs.

// A kind is a parameter of its own and not in the structure: the passes compile it in.
const PORT_NONE: u32 = 0u;
const PORT_FLAT: u32 = 1u;
const PORT_DOME: u32 = 2u;

/// A port in its camera's frame, as one band of light meets it.
struct Port {
    /// Normal of a plate, centre of a dome, m.
    axis: vec3<f32>,
    /// To the inner face: distance of a plate, radius of a dome.
    inner_m: f32,
    thickness_m: f32,
    glass_index: f32,
    water_index: f32,
}

/// A ray where it enters the water, and the share of its radiance that arrives at the lens.
struct PortRay {
    origin_m: vec3<f32>,
    direction: vec3<f32>,
    gain: f32,
}

/// A direction behind an interface (xyz) and what passes (w); nothing passes where there is none.
fn port_refract(direction: vec3<f32>, outward: vec3<f32>, before: f32, behind: f32) -> vec4<f32> {
    let cos_i = dot(direction, outward);
    let ratio = before / behind;
    let cos2_t = 1.0 - ratio * ratio * (1.0 - cos_i * cos_i);
    if cos_i <= 0.0 || cos2_t <= 0.0 {
        return vec4<f32>(0.0);
    }
    let cos_t = sqrt(cos2_t);
    let across = (before * cos_i - behind * cos_t) / (before * cos_i + behind * cos_t);
    let within = (behind * cos_i - before * cos_t) / (behind * cos_i + before * cos_t);
    return vec4<f32>(
        normalize(direction * ratio + outward * (cos_t - ratio * cos_i)),
        1.0 - 0.5 * (across * across + within * within),
    );
}

/// The ray in the water of a direction in air.
fn port_flat_ray(port: Port, air: vec3<f32>) -> PortRay {
    let glass = port_refract(air, port.axis, 1.0, port.glass_index);
    let water = port_refract(glass.xyz, port.axis, port.glass_index, port.water_index);
    let origin = air * (port.inner_m / dot(air, port.axis)) + glass.xyz * (port.thickness_m / dot(glass.xyz, port.axis));
    return PortRay(origin, water.xyz, glass.w * water.w / (port.water_index * port.water_index));
}

/// Where a ray from inside leaves a sphere about the dome's centre; from there.
fn port_leave(start_m: vec3<f32>, direction: vec3<f32>, radius_m: f32) -> vec3<f32> {
    let along = dot(start_m, direction);
    let off = start_m - direction * along;
    return start_m + direction * (sqrt(radius_m * radius_m - dot(off, off)) - along);
}

/// The ray in the water of a direction in air.
fn port_dome_ray(port: Port, air: vec3<f32>) -> PortRay {
    let outer_m = port.inner_m + port.thickness_m;
    let inner = port_leave(-port.axis, air, port.inner_m);
    let glass = port_refract(air, inner / port.inner_m, 1.0, port.glass_index);
    let outer = port_leave(inner, glass.xyz, outer_m);
    let water = port_refract(glass.xyz, outer / outer_m, port.glass_index, port.water_index);
    return PortRay(outer + port.axis, water.xyz, glass.w * water.w / (port.water_index * port.water_index));
}

/// The direction in air in which a point in the water is seen; zero where it is not. Newton's method for the tangent of its angle, which
/// climbs to the root until rounding turns it back.
fn port_flat_seen(port: Port, point_m: vec3<f32>) -> vec3<f32> {
    let height = dot(point_m, port.axis);
    let depth_m = height - port.inner_m - port.thickness_m;
    let across = point_m - port.axis * height;
    let wanted_m = length(across);
    if depth_m <= 0.0 {
        return vec3<f32>(0.0);
    }
    if wanted_m == 0.0 {
        return port.axis;
    }
    let heights = vec3<f32>(port.inner_m, port.thickness_m, depth_m);
    let indices2 = vec3<f32>(1.0, port.glass_index * port.glass_index, port.water_index * port.water_index);
    var w = 0.0;
    for (var step = 0; step < 60; step++) {
        let root2 = indices2 + (indices2 - 1.0) * (w * w);
        let root = sqrt(root2);
        let reached_m = dot(heights / root, vec3<f32>(w));
        let slope_m = dot(heights, indices2 / (root2 * root));
        let next = w + (wanted_m - reached_m) / slope_m;
        // With the pupil on the glass, what lies beyond the critical angle is seen nowhere: w runs away.
        if !(next < 1e6) {
            return vec3<f32>(0.0);
        }
        if next <= w {
            break;
        }
        w = next;
    }
    return normalize(port.axis + across * (w / wanted_m));
}

/// A turn as (cosine, sine), turned on by the arc sine of x.
fn port_turned(turn: vec2<f32>, x: f32) -> vec2<f32> {
    let cos = sqrt((1.0 - x) * (1.0 + x));
    return vec2<f32>(turn.x * cos - turn.y * x, turn.y * cos + turn.x * x);
}

/// The direction in air in which a point in the water is seen; zero where it is not. Newton's method for the angle α at the pupil, in the
/// plane of dome centre, pupil and point, where the ray sweeps about the centre
///
///   Φ(α) = α - asin(b/Rᵢ) + asin(b/(n Rᵢ)) - asin(b/(n Rₒ)) + asin(b/(m Rₒ)) - asin(b/(m ρ)),  b = e sin α
///
/// Angles are pairs of cosine and sine that are turned: no arc sine is exact enough.
fn port_dome_seen(port: Port, point_m: vec3<f32>) -> vec3<f32> {
    let outer_m = port.inner_m + port.thickness_m;
    let to_point = point_m - port.axis;
    let range_m = length(to_point);
    if range_m <= outer_m {
        return vec3<f32>(0.0);
    }
    let pupil_m = length(port.axis);
    let out = -port.axis / max(pupil_m, 1e-30);
    let aside = to_point - out * dot(out, to_point);
    let aside_m = length(aside);
    if pupil_m == 0.0 || aside_m == 0.0 {
        return normalize(point_m);
    }
    let glass = 1.0 / port.glass_index;
    let water = 1.0 / port.water_index;
    let inner = 1.0 / port.inner_m;
    let outer = 1.0 / outer_m;
    let wanted = vec2<f32>(dot(out, to_point), aside_m) / range_m;
    var low = vec2<f32>(1.0, 0.0);
    var high = vec2<f32>(-1.0, 0.0);
    var alpha = wanted;
    for (var step = 0; step < 40; step++) {
        let b = pupil_m * alpha.y;
        var bent = port_turned(vec2<f32>(1.0, 0.0), -b * inner);
        bent = port_turned(bent, b * glass * inner);
        bent = port_turned(bent, -b * glass * outer);
        bent = port_turned(bent, b * water * outer);
        bent = port_turned(bent, -b * water / range_m);
        let off = vec2<f32>(dot(alpha, wanted), alpha.y * wanted.x - alpha.x * wanted.y);
        let error = off.y * bent.x + off.x * bent.y;
        let reaches = vec4<f32>(port.inner_m, port.inner_m / glass, outer_m / glass, outer_m / water);
        let slopes = pupil_m * alpha.x / sqrt(reaches * reaches - b * b);
        let last = pupil_m * alpha.x / sqrt(range_m * range_m / (water * water) - b * b);
        let slope = 1.0 - slopes.x + slopes.y - slopes.z + slopes.w - last;
        if error > 0.0 {
            high = alpha;
        } else {
            low = alpha;
        }
        let change = -error / slope;
        let newton = normalize(alpha + change * vec2<f32>(-alpha.y, alpha.x));
        let within = low.x * newton.y - low.y * newton.x > 0.0 && newton.x * high.y - newton.y * high.x > 0.0;
        if abs(change) <= 6e-8 {
            break;
        }
        let middle = low + high;
        let halved = select(vec2<f32>(0.0, 1.0), normalize(middle), dot(middle, middle) > 1e-12);
        alpha = select(halved, newton, within && abs(change) < 1.0);
    }
    return normalize(out * alpha.x + aside * (alpha.y / aside_m));
}
