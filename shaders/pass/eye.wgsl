// What the eyes see: rays of pixels, and pixels of points, through a lens and a port. See geometry/src/rig/mounted.rs.

override EYE_PORT: u32 = 0u;
override OTHER_PORT: u32 = 0u;

/// A ray in the water, and the share of its radiance that arrives at the lens.
struct EyeRay {
    origin_m: vec3<f32>,
    direction: vec3<f32>,
    gain: f32,
}

/// The ray of a place inside the pixel of a corner.
fn eye_ray(corner: vec2<f32>, inside: vec2<f32>) -> EyeRay {
    let air = camera_ray(EYE_LENS, frame.eye, corner, inside);
    if EYE_PORT == PORT_NONE {
        return EyeRay(vec3<f32>(0.0), camera_to_rig(frame.eye, air), 1.0);
    }
    var seen: PortRay;
    if EYE_PORT == PORT_FLAT {
        seen = port_flat_ray(frame.eye_port, air);
    } else {
        seen = port_dome_ray(frame.eye_port, air);
    }
    return EyeRay(camera_to_rig(frame.eye, seen.origin_m), camera_to_rig(frame.eye, seen.direction), seen.gain);
}

/// How the other eye sees a point.
struct EyeSight {
    /// Possibly outside the image.
    pixel: vec2<f32>,
    is_seen: bool,
    /// Where its straight line of sight begins.
    from_m: vec3<f32>,
}

fn eye_sight(point_m: vec3<f32>) -> EyeSight {
    let camera = frame.other;
    var air = camera_from_rig(camera, point_m - camera.origin_m);
    var face = vec3<f32>(0.0);
    if OTHER_PORT == PORT_FLAT {
        air = port_flat_seen(frame.other_port, air);
        face = port_flat_ray(frame.other_port, air).origin_m;
    } else if OTHER_PORT == PORT_DOME {
        air = port_dome_seen(frame.other_port, air);
        face = port_dome_ray(frame.other_port, air).origin_m;
    }
    // What no ray reaches has no direction, which no lens sees.
    let there = camera_project(OTHER_LENS, camera, air);
    return EyeSight(there.xy, there.z > 0.0, camera.origin_m + camera_to_rig(camera, face));
}
