//! What is in `scenes/props/`. Every model stands on z = 0 and looks forward (x); z is down.

use rodsight_geometry::Vec3;
use rodsight_scene::{Mesh, MeshMaterial, Texture, Wrap};

use crate::shapes::Solids;

/// Every prop and the name of its file.
pub(crate) fn all() -> Vec<(&'static str, Mesh)> {
    vec![
        ("panel.glb", panel()),
        ("frame.glb", frame()),
        ("boulder.glb", rock(1, [0.45, 0.38, 0.30])),
        ("slab.glb", rock(2, [0.50, 0.35, 0.14])),
    ]
}

fn paint(name: &str, base: [f32; 3], metallic: f32, roughness: f32) -> MeshMaterial {
    MeshMaterial {
        name: name.to_owned(),
        base,
        metallic,
        roughness,
        texture: None,
    }
}

/// An intervention panel, 1.2 m wide and 0.8 m high on two posts: a yellow board with two rows of D-shaped handles, a bar's four
/// brackets, and a receptacle. The brackets at the left (seen from in front) are for a rod of 34 mm that a scene puts there:
/// upright, 0.11 m before the board's middle plane, 0.28 m to starboard of the panel's.
fn panel() -> Mesh {
    let (mut board, mut steel, mut grips) =
        (Solids::default(), Solids::default(), Solids::default());
    board.block([0.0, 0.0, -0.9], [0.03, 1.2, 0.8], true);
    for y in [-0.5, 0.5] {
        steel.block([-0.06, y, -0.6], [0.08, 0.08, 1.2], false);
        steel.block([-0.06, y, -0.01], [0.5, 0.16, 0.02], false);
    }
    // Brackets of the bar: from the board to where the bar's back is.
    for z in [-1.1, -0.7] {
        steel.block([0.0525, 0.28, z], [0.085, 0.03, 0.03], false);
    }
    // A hot stab's receptacle.
    steel.bar(&[[0.015, -0.05, -0.72], [0.16, -0.05, -0.72]], 0.06, 40);
    for (y, z) in [(-0.38, -1.12), (-0.08, -1.12), (-0.38, -0.82)] {
        let (near, far) = (0.015, 0.105);
        grips.bar(
            &[
                [near, y - 0.07, z],
                [far, y - 0.07, z],
                [far, y + 0.07, z],
                [near, y + 0.07, z],
            ],
            0.011,
            24,
        );
    }
    let mut yellow = paint("paint", [1.0; 3], 0.0, 0.55);
    yellow.texture = Some(0);
    Mesh {
        parts: vec![board.part(0), steel.part(1), grips.part(2)],
        materials: vec![
            yellow,
            paint("steel", [0.55, 0.56, 0.57], 0.6, 0.5),
            paint("orange", [0.85, 0.22, 0.03], 0.0, 0.5),
        ],
        textures: vec![markings()],
        notes: Vec::new(),
    }
}

/// Yellow with a black border, fields divided by white lines, and a scale of black bars along the bottom.
fn markings() -> Texture {
    let (width_px, height_px) = (384, 256);
    let colour = |(u, v): (u32, u32)| {
        let edge = u.min(v).min(width_px - 1 - u).min(height_px - 1 - v);
        let is_line = (u % 96).min(95 - u % 96) < 2 || (v % 128).min(127 - v % 128) < 2;
        let is_bar = (226..240).contains(&v) && (u / 16).is_multiple_of(2);
        match () {
            () if edge < 8 || is_bar => [28, 28, 30],
            () if is_line => [228, 228, 222],
            () => [231, 178, 22],
        }
    };
    let pixels = (0..height_px).flat_map(|v| (0..width_px).map(move |u| (u, v)));
    Texture {
        width_px,
        height_px,
        srgb: pixels.map(colour).collect(),
        wrap: [Wrap::Clamp; 2],
    }
}

/// A frame of square steel tube, 1.6 m wide, 1 m deep, 1.2 m high, with one diagonal on each side.
fn frame() -> Mesh {
    let (x, y, h) = (0.5, 0.8, 1.2);
    let mut tube = Solids::default();
    for sx in [-x, x] {
        for sy in [-y, y] {
            tube.block([sx, sy, -0.5 * h], [0.06, 0.06, h], false);
        }
        for z in [-0.05, -0.6, 0.03 - h] {
            tube.block([sx, 0.0, z], [0.05, 2.0 * y - 0.06, 0.05], false);
        }
    }
    for sy in [-y, y] {
        for z in [-0.05, 0.03 - h] {
            tube.block([0.0, sy, z], [2.0 * x - 0.06, 0.05, 0.05], false);
        }
        tube.bar(&[[0.03 - x, sy, -0.08], [x - 0.03, sy, 0.06 - h]], 0.02, 20);
    }
    Mesh {
        parts: vec![tube.part(0)],
        materials: vec![paint("primer", [0.42, 0.45, 0.44], 0.0, 0.7)],
        ..Mesh::default()
    }
}

/// A rock that lies on z = 0 with its lowest fifth below: an ellipsoid with ever finer bumps.
fn rock(seed: u32, half_m: [f64; 3]) -> Mesh {
    let mut stone = Solids::default();
    let half = Vec3::from(half_m);
    stone.boulder(4, |direction| {
        // The ellipsoid's radius in that direction, and four octaves of bumps.
        let ellipsoid = 1.0 / direction.component_div(&half).norm();
        let bumps = (0..4).map(|octave| {
            let frequency = f64::from(1_u32 << octave) * 1.7;
            bump(&(direction * frequency), seed * 16 + octave) / f64::from(1_u32 << octave)
        });
        ellipsoid * (1.0 + 0.22 * bumps.sum::<f64>())
    });
    let mut part = stone.part(0);
    for position in &mut part.positions_m {
        position[2] -= 0.8 * half_m[2] as f32;
    }
    Mesh {
        parts: vec![part],
        materials: vec![paint("stone", [0.24, 0.23, 0.20], 0.0, 0.95)],
        ..Mesh::default()
    }
}

/// Smooth noise in [−1, 1] in space.
fn bump(at: &Vec3, seed: u32) -> f64 {
    let cell = at.map(libm::floor);
    let s = (at - cell).map(|v| v * v * (3.0 - 2.0 * v));
    let node = |i: u32, j: u32, k: u32| {
        let words: [u32; 3] =
            core::array::from_fn(|n| (cell[n] as i32 as u32).wrapping_add([i, j, k][n]));
        let mut hash = seed;
        for word in words {
            hash = (hash ^ word).wrapping_mul(0x9e37_79b1);
            hash ^= hash >> 15;
        }
        f64::from(hash >> 8) / f64::from(1_u32 << 23) - 1.0
    };
    let mix = |a: f64, b: f64, s: f64| a + s * (b - a);
    let row = |j, k| mix(node(0, j, k), node(1, j, k), s.x);
    mix(
        mix(row(0, 0), row(1, 0), s.y),
        mix(row(0, 1), row(1, 1), s.y),
        s.z,
    )
}
