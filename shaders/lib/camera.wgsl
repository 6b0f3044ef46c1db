// Pixel ↔ ray: see geometry/src/camera.rs.

// A lens is a parameter of its own and not in the structure: the passes compile it in.
const CAMERA_PINHOLE: u32 = 0u;
const CAMERA_BROWN_CONRADY: u32 = 1u;
const CAMERA_KANNALA_BRANDT: u32 = 2u;

/// A camera; vectors in the axes of the rig, points from the centre of the eye that is rendered.
struct Camera {
    right: vec3<f32>,
    fx_px: f32,
    down: vec3<f32>,
    fy_px: f32,
    forward: vec3<f32>,
    cx_px: f32,
    origin_m: vec3<f32>,
    cy_px: f32,
    /// k1, k2, k3 (and k4) of the lens.
    k: vec4<f32>,
    /// p1, p2 of the lens.
    p: vec2<f32>,
    /// Beyond this the lens draws ghosts: r² of Brown and Conrady, θ of Kannala and Brandt.
    fold: f32,
    size_px: vec2<f32>,
    /// How much less the tangents of rays, x/z and y/z, are than those of the lens's centre; zero without a distortion.
    shift: vec2<f32>,
}

fn camera_distort_brown_conrady(camera: Camera, at: vec2<f32>) -> vec2<f32> {
    let r2 = dot(at, at);
    let radial = 1.0 + r2 * (camera.k.x + r2 * (camera.k.y + r2 * camera.k.z));
    return at * radial + 2.0 * at.x * at.y * camera.p + camera.p.yx * (r2 + 2.0 * at * at);
}

/// Newton's method; a step that leaves the fold-free disc or does not come nearer is halved. The camera was checked to have an
/// answer on all of its image: what is reached when no step helps is right to rounding.
fn camera_undistort_brown_conrady(camera: Camera, wanted: vec2<f32>) -> vec2<f32> {
    let outside = dot(wanted, wanted) / camera.fold;
    var at = wanted * select(0.9 * inverseSqrt(outside), 1.0, outside < 1.0);
    var error = camera_distort_brown_conrady(camera, at) - wanted;
    for (var step = 0; step < 30; step++) {
        let r2 = dot(at, at);
        let radial = 1.0 + r2 * (camera.k.x + r2 * (camera.k.y + r2 * camera.k.z));
        let slope = 2.0 * (camera.k.x + r2 * (2.0 * camera.k.y + r2 * 3.0 * camera.k.z));
        let diagonal = radial + slope * at * at + 2.0 * camera.p * at.yx + 6.0 * camera.p.yx * at;
        let across = slope * at.x * at.y + 2.0 * dot(camera.p, at);
        let det = diagonal.x * diagonal.y - across * across;
        var change = (diagonal.yx * error - across * error.yx) / det;
        var nearer = false;
        for (var halving = 0; halving < 12 && !nearer; halving++) {
            let there = at - change;
            let left = camera_distort_brown_conrady(camera, there) - wanted;
            if dot(there, there) < camera.fold && dot(left, left) < dot(error, error) {
                at = there;
                error = left;
                nearer = true;
            }
            // At the root no halving helps either.
            if dot(error, error) < 1e-15 {
                break;
            }
            change = 0.5 * change;
        }
        if !nearer {
            break;
        }
    }
    return at;
}

fn camera_distorted_angle(camera: Camera, theta: f32) -> f32 {
    let t = theta * theta;
    return theta * (1.0 + t * (camera.k.x + t * (camera.k.y + t * (camera.k.z + t * camera.k.w))));
}

/// θ whose distorted angle is `wanted`: Newton's method inside a bracket, since the polynomial is monotone up to the fold.
fn camera_undistort_kannala_brandt(camera: Camera, wanted: f32) -> f32 {
    var low = 0.0;
    var high = camera.fold;
    var theta = min(wanted, 0.5 * high);
    for (var step = 0; step < 40; step++) {
        let error = camera_distorted_angle(camera, theta) - wanted;
        if error > 0.0 {
            high = theta;
        } else {
            low = theta;
        }
        let t = theta * theta;
        let slope = 1.0 + t * (3.0 * camera.k.x + t * (5.0 * camera.k.y + t * (7.0 * camera.k.z + t * 9.0 * camera.k.w)));
        let change = error / slope;
        if abs(change) <= 6e-8 * theta {
            break;
        }
        let newton = theta - change;
        theta = select(0.5 * (low + high), newton, newton > low && newton < high);
    }
    return theta;
}

/// The unit direction, in the camera's frame, seen at a place inside the pixel of a corner. In two parts, so that the place
/// keeps its digits far from the principal point.
fn camera_ray(lens: u32, camera: Camera, corner_px: vec2<f32>, inside_px: vec2<f32>) -> vec3<f32> {
    let focal = vec2<f32>(camera.fx_px, camera.fy_px);
    let seen = ((corner_px - vec2<f32>(camera.cx_px, camera.cy_px)) + inside_px) / focal;
    if lens == CAMERA_BROWN_CONRADY {
        return normalize(vec3<f32>(camera_undistort_brown_conrady(camera, seen) - camera.shift, 1.0));
    }
    if lens == CAMERA_KANNALA_BRANDT {
        let wanted = length(seen);
        if wanted == 0.0 {
            return normalize(vec3<f32>(-camera.shift, 1.0));
        }
        let turn = maths_sincos(camera_undistort_kannala_brandt(camera, wanted));
        let ray = vec3<f32>(seen / wanted * turn.x, turn.y);
        if any(camera.shift != vec2<f32>(0.0)) {
            return normalize(vec3<f32>(ray.xy / ray.z - camera.shift, 1.0));
        }
        return ray;
    }
    return normalize(vec3<f32>(seen, 1.0));
}

/// The pixel (xy) at which a point of the camera's frame is seen, and whether it is (z = 1) or not (z = 0).
fn camera_project(lens: u32, camera: Camera, from_aperture_m: vec3<f32>) -> vec3<f32> {
    var seen = vec2<f32>(0.0);
    var point_m = from_aperture_m;
    if any(camera.shift != vec2<f32>(0.0)) {
        if point_m.z <= 0.0 {
            return vec3<f32>(0.0);
        }
        point_m = vec3<f32>(point_m.xy / point_m.z + camera.shift, 1.0);
    }
    if lens == CAMERA_KANNALA_BRANDT {
        let r = length(point_m.xy);
        if r == 0.0 && point_m.z <= 0.0 {
            return vec3<f32>(0.0);
        }
        let theta = maths_atan2(r, point_m.z);
        if theta >= camera.fold {
            return vec3<f32>(0.0);
        }
        if r > 0.0 {
            seen = point_m.xy * (camera_distorted_angle(camera, theta) / r);
        }
    } else {
        if point_m.z <= 0.0 {
            return vec3<f32>(0.0);
        }
        seen = point_m.xy / point_m.z;
        if lens == CAMERA_BROWN_CONRADY {
            if dot(seen, seen) >= camera.fold {
                return vec3<f32>(0.0);
            }
            seen = camera_distort_brown_conrady(camera, seen);
        }
    }
    let focal = vec2<f32>(camera.fx_px, camera.fy_px);
    return vec3<f32>(focal * seen + vec2<f32>(camera.cx_px, camera.cy_px), 1.0);
}

/// A direction of the camera's frame in the axes of the rig.
fn camera_to_rig(camera: Camera, direction: vec3<f32>) -> vec3<f32> {
    return camera.right * direction.x + camera.down * direction.y + camera.forward * direction.z;
}

/// A direction of the axes of the rig in the camera's frame.
fn camera_from_rig(camera: Camera, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(camera.right, direction), dot(camera.down, direction), dot(camera.forward, direction));
}

/// Whether a pixel lies in the image.
fn camera_contains(camera: Camera, pixel: vec2<f32>) -> bool {
    return all(pixel >= vec2<f32>(0.0)) && all(pixel <= camera.size_px);
}
