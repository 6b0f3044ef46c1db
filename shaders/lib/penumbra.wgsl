// What rods take of light scattered forwards: see cpu/penumbra.rs.

/// Stands for the tangent of a right angle.
const PENUMBRA_BEYOND: f32 = 1e4;
/// Nearer parts of a rod stand beside the point, not before the lamp.
const PENUMBRA_NEAR_M: f32 = 1e-4;

/// Tangents of angles from the lamp's direction, from and to; empty if `across` does not rise.
struct PenumbraRectangle {
    across: vec2<f32>,
    along: vec2<f32>,
}

fn penumbra_end_on(radius_m: f32, to_lamp: vec3<f32>, cap_m: vec3<f32>, depth_m: f32) -> PenumbraRectangle {
    let size = abs(to_lamp);
    var least = vec3<f32>(0.0, 0.0, 1.0);
    if size.x <= size.y && size.x <= size.z {
        least = vec3<f32>(1.0, 0.0, 0.0);
    } else if size.y <= size.z {
        least = vec3<f32>(0.0, 1.0, 0.0);
    }
    let aside = normalize(cross(to_lamp, least));
    let half = 0.886226925 * radius_m / depth_m;
    let at = vec2<f32>(dot(cap_m, aside), dot(cap_m, cross(to_lamp, aside))) / depth_m;
    let low = clamp(at - half, vec2<f32>(-PENUMBRA_BEYOND), vec2<f32>(PENUMBRA_BEYOND));
    let high = clamp(at + half, vec2<f32>(-PENUMBRA_BEYOND), vec2<f32>(PENUMBRA_BEYOND));
    return PenumbraRectangle(vec2<f32>(low.x, high.x), vec2<f32>(low.y, high.y));
}

/// A piece before a lamp as a point sees it; places from the lamp.
fn penumbra_rectangle(piece: Solid, point_m: vec3<f32>) -> PenumbraRectangle {
    let none = PenumbraRectangle(vec2<f32>(0.0), vec2<f32>(0.0));
    let r = length(point_m);
    let to_lamp = -point_m / r;
    let d = piece.direction;
    let centre = piece.centre_m - point_m;
    let ahead = dot(centre, to_lamp);
    let tilt = dot(d, to_lamp);
    var part = vec2<f32>(-piece.half_length_m, piece.half_length_m);
    if abs(tilt) > 1e-9 {
        let limits = (vec2<f32>(PENUMBRA_NEAR_M, r) - ahead) / tilt;
        part = vec2<f32>(max(part.x, min(limits.x, limits.y)), min(part.y, max(limits.x, limits.y)));
    } else if ahead < PENUMBRA_NEAR_M || ahead > r {
        return none;
    }
    if part.x >= part.y {
        return none;
    }
    let depths = ahead + tilt * part;
    let crossed = cross(centre, d);
    let distance = length(crossed);
    if distance <= piece.radius_m {
        let nearer = select(part.y, part.x, depths.x < depths.y);
        return penumbra_end_on(piece.radius_m, to_lamp, centre + d * nearer, min(depths.x, depths.y));
    }
    let normal = crossed / distance;
    let aside = dot(normal, to_lamp);
    let front = dot(cross(d, normal), to_lamp);
    let sin = piece.radius_m / distance;
    let cos = sqrt(max(1.0 - sin * sin, 0.0));
    var limbs = vec2<f32>(0.0);
    for (var i = 0; i < 2; i++) {
        let side = f32(2 * i - 1);
        let tangent = aside * cos + side * front * sin;
        limbs[i] = select(-PENUMBRA_BEYOND, PENUMBRA_BEYOND, aside >= 0.0);
        if front * cos - side * aside * sin > 0.0 {
            let slope = tangent * inverseSqrt(max(1.0 - tangent * tangent, 1e-12));
            limbs[i] = clamp(slope, -PENUMBRA_BEYOND, PENUMBRA_BEYOND);
        }
    }
    let up = normalize(cross(normal, to_lamp));
    let lean = dot(d, up);
    let rims = piece.radius_m * sqrt(max(1.0 - lean * lean, 0.0)) / depths;
    let ends = (dot(centre, up) + lean * part) / depths;
    let low = min(ends.x - rims.x, ends.y - rims.y);
    let high = max(ends.x + rims.x, ends.y + rims.y);
    return PenumbraRectangle(limbs, vec2<f32>(min(low, PENUMBRA_BEYOND), max(high, -PENUMBRA_BEYOND)));
}

/// Share of a lobe's light, of half its width, from within.
fn penumbra_share(rectangle: PenumbraRectangle, width: f32) -> f32 {
    var turned = 0.0;
    for (var i = 0; i < 2; i++) {
        let y = rectangle.along[i];
        let x = rectangle.across;
        let root = width * sqrt(width * width + x * x + y * y);
        let high = x * y;
        let turn = atan2(root.x * high.y - high.x * root.y, root.x * root.y + high.x * high.y);
        turned += f32(2 * i - 1) * turn;
    }
    return clamp(turned / 6.28318530718, 0.0, 1.0);
}
