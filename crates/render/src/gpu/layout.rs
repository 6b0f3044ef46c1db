//! Structures shared with WGSL: same names, same fields, same order. A test compares them with the shaders.

mod content;
mod shoot;

use encase::ShaderType;
use rodsight_geometry::Vec3;
use rodsight_optics::Bands;

pub(super) use content::{Arc, Body, Finish, Lump, Paint, SeabedRipples, Triangle, Vertex};
pub(super) use shoot::{Chip, Emva, Film, Meter};

/// `vec3<f32>`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vec3f([f32; 3]);

/// `vec2<f32>`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vec2f([f32; 2]);

/// `vec4<f32>`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vec4f([f32; 4]);

/// `vec2<i32>`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vec2i([i32; 2]);

/// `vec4<i32>`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vec4i([i32; 4]);

macro_rules! vector {
    ($name:ident, $n:literal, $kind:ty) => {
        impl AsRef<[$kind; $n]> for $name {
            fn as_ref(&self) -> &[$kind; $n] {
                &self.0
            }
        }
        impl From<[f64; $n]> for $name {
            fn from(values: [f64; $n]) -> Self {
                Self(values.map(|v| v as $kind))
            }
        }
        impl AsMut<[$kind; $n]> for $name {
            fn as_mut(&mut self) -> &mut [$kind; $n] {
                &mut self.0
            }
        }
        impl From<[$kind; $n]> for $name {
            fn from(values: [$kind; $n]) -> Self {
                Self(values)
            }
        }
        encase::impl_vector!($n, $name, $kind; using AsRef AsMut From);
    };
}
vector!(Vec2f, 2, f32);
vector!(Vec3f, 3, f32);
vector!(Vec4f, 4, f32);
vector!(Vec2i, 2, i32);
vector!(Vec4i, 4, i32);

#[cfg(test)]
impl From<Vec2i> for [i32; 2] {
    fn from(v: Vec2i) -> Self {
        v.0
    }
}

impl From<Vec3> for Vec3f {
    fn from(v: Vec3) -> Self {
        Bands::from(v).into()
    }
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Camera {
    pub(super) right: Vec3f,
    pub(super) fx_px: f32,
    pub(super) down: Vec3f,
    pub(super) fy_px: f32,
    pub(super) forward: Vec3f,
    pub(super) cx_px: f32,
    pub(super) origin_m: Vec3f,
    pub(super) cy_px: f32,
    pub(super) k: Vec4f,
    pub(super) p: Vec2f,
    pub(super) fold: f32,
    pub(super) size_px: Vec2f,
    pub(super) shift: Vec2f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Port {
    pub(super) axis: Vec3f,
    pub(super) inner_m: f32,
    pub(super) thickness_m: f32,
    pub(super) glass_index: f32,
    pub(super) water_index: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Frame {
    pub(super) eye: Camera,
    pub(super) other: Camera,
    pub(super) eye_port: Port,
    pub(super) other_port: Port,
    pub(super) ripples: SeabedRipples,
    pub(super) attenuation_per_m: Vec3f,
    pub(super) horizon_m: f32,
    pub(super) lamp_attenuation_per_m: Vec3f,
    pub(super) veil_scattering_per_m: Vec3f,
    pub(super) scattering_per_m: Vec3f,
    pub(super) graze_rad: f32,
    pub(super) ambient_radiance: Vec3f,
    pub(super) footprint_rad: f32,
    pub(super) background_radiance: Vec3f,
    pub(super) airlight_points: u32,
    pub(super) seabed_albedo: Vec3f,
    pub(super) seabed_z_m: f32,
    pub(super) rig_from_eye_m: Vec3f,
    pub(super) seabed_contrast: f32,
    pub(super) seabed_scale_m: f32,
    pub(super) seabed_seed: u32,
    pub(super) nodes: u32,
    pub(super) body_nodes: u32,
    pub(super) mesh_nodes: u32,
    pub(super) lamps: u32,
    pub(super) casters: u32,
    pub(super) samples: u32,
    pub(super) inner_samples: u32,
    pub(super) shifts: u32,
    pub(super) phase_nodes: u32,
    pub(super) grid_columns: u32,
    pub(super) grid_rows: u32,
    pub(super) grid_steps: u32,
    pub(super) grid_half_way_m: f32,
    pub(super) grid_scale: Vec2f,
    pub(super) lobes: [Vec4f; 4],
    /// Two lobes each: share and half the width.
    pub(super) soft_lobes: [Vec4f; 7],
    pub(super) regained_per_m: Vec3f,
    pub(super) snow_albedo: Vec3f,
    pub(super) daylight_w_per_m2: Vec3f,
    pub(super) daylight_attenuation_per_m: Vec3f,
    pub(super) disparity_sign: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Solid {
    pub(super) centre_m: Vec3f,
    pub(super) half_length_m: f32,
    pub(super) direction: Vec3f,
    pub(super) radius_m: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Segment {
    pub(super) solid: Solid,
    pub(super) arc_m: Vec3f,
    pub(super) curvature_per_m: f32,
    pub(super) inward: Vec3f,
    pub(super) instance: u32,
    pub(super) ends: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct BvhNode {
    pub(super) min_m: Vec3f,
    pub(super) first: u32,
    pub(super) max_m: Vec3f,
    pub(super) count: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Rod {
    pub(super) value: Vec3f,
    pub(super) is_flat: u32,
    pub(super) arc: Arc,
    pub(super) finish: Finish,
    pub(super) reflectance: Vec3f,
    pub(super) roughness: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Lamp {
    pub(super) position_m: Vec3f,
    pub(super) cos_inner: f32,
    pub(super) direction: Vec3f,
    pub(super) cos_outer: f32,
    pub(super) radiant_intensity_w_per_sr: Vec3f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Caster {
    pub(super) solid: Solid,
    pub(super) touching_plus_m: Vec3f,
    pub(super) touching_minus_m: Vec3f,
    pub(super) touches: u32,
    pub(super) instance: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Tile {
    pub(super) width: u32,
    pub(super) first_row: u32,
    pub(super) rows: u32,
    pub(super) kept_from: u32,
    pub(super) kept_to: u32,
    pub(super) has_snow: u32,
}

/// What `mark` counts and `refine` is dispatched by.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Indirect {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) z: u32,
    pub(super) count: u32,
}

/// Whether the driver cut loops short; see `loops.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Loops {
    pub(super) steps: u32,
    pub(super) are_cut: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct HaloStrip {
    pub(super) at: Vec2i,
    pub(super) size: Vec2i,
    pub(super) side: i32,
    pub(super) columns: u32,
    pub(super) first: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct HaloLevel {
    pub(super) columns: u32,
    pub(super) rows: u32,
    pub(super) side: u32,
    pub(super) coarser_columns: u32,
    pub(super) run_px: u32,
    pub(super) first_run: u32,
    pub(super) border: u32,
    pub(super) kernel: [Vec4f; 2],
    pub(super) farthest: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Halo {
    pub(super) size: Vec2i,
    pub(super) overscan: u32,
    pub(super) patches: u32,
    pub(super) longest_m: f32,
    pub(super) knots: u32,
    pub(super) count: u32,
    pub(super) runs: u32,
    pub(super) strips: [HaloStrip; 8],
    pub(super) levels: [HaloLevel; rodsight_optics::Halo::LEVELS],
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct Flake {
    pub(super) centre_m: Vec3f,
    pub(super) range_m: f32,
    pub(super) from_m: Vec3f,
    pub(super) opacity: f32,
    pub(super) aside: Vec3f,
    pub(super) gain: f32,
    pub(super) disc_per_px: Vec4f,
    pub(super) pixel: Vec2i,
    pub(super) inside_px: Vec2f,
    pub(super) is_small: u32,
    pub(super) is_round: u32,
    pub(super) shading: f32,
    pub(super) lit_from: Vec3f,
    pub(super) direct: Vec3f,
    pub(super) scattered: Vec3f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct SnowPair {
    pub(super) flake: u32,
    pub(super) lit: f32,
}

#[cfg(test)]
pub(super) mod tests {
    use rodsight_shaders::{CENTRE, MARK, Pass, WEIGH};

    use super::*;

    /// Name, offset and size of the fields of a WGSL structure, and its size.
    pub(super) fn of_shader(pass: &Pass, name: &str) -> (Vec<(String, u64)>, u64) {
        let module = naga::front::wgsl::parse_str(&pass.source()).unwrap();
        let found = module
            .types
            .iter()
            .find(|(_, kind)| kind.name.as_deref() == Some(name));
        let (_, kind) = found.unwrap_or_else(|| panic!("no {name} in {}", pass.name));
        let naga::TypeInner::Struct { members, span } = &kind.inner else {
            panic!("{name} is no structure");
        };
        let fields = members
            .iter()
            .map(|m| (m.name.clone().unwrap(), u64::from(m.offset)))
            .collect();
        (fields, u64::from(*span))
    }

    macro_rules! same {
        ($pass:expr, $name:ident { $($field:ident),+ }) => {{
            let value = $name::default();
            // Every field, or this does not compile.
            let $name { $($field: _),+ } = value;
            let names = [$(stringify!($field)),+];
            let ours: Vec<(String, u64)> = names
                .iter()
                .enumerate()
                .map(|(i, name)| ((*name).to_owned(), <$name as ShaderType>::METADATA.offset(i)))
                .collect();
            let size = <$name as encase::ShaderSize>::SHADER_SIZE.get();
            assert_eq!((ours, size), of_shader($pass, stringify!($name)), "{}", stringify!($name));
        }};
    }
    pub(super) use same;

    #[test]
    fn structures_lie_in_memory_as_the_shaders_read_them() {
        same!(
            &CENTRE,
            Camera {
                right,
                fx_px,
                down,
                fy_px,
                forward,
                cx_px,
                origin_m,
                cy_px,
                k,
                p,
                fold,
                size_px,
                shift
            }
        );
        same!(
            &CENTRE,
            Port {
                axis,
                inner_m,
                thickness_m,
                glass_index,
                water_index
            }
        );
        same!(
            &CENTRE,
            Frame {
                eye,
                other,
                eye_port,
                other_port,
                ripples,
                attenuation_per_m,
                horizon_m,
                lamp_attenuation_per_m,
                veil_scattering_per_m,
                scattering_per_m,
                graze_rad,
                ambient_radiance,
                footprint_rad,
                background_radiance,
                airlight_points,
                seabed_albedo,
                seabed_z_m,
                rig_from_eye_m,
                seabed_contrast,
                seabed_scale_m,
                seabed_seed,
                nodes,
                body_nodes,
                mesh_nodes,
                lamps,
                casters,
                samples,
                inner_samples,
                shifts,
                phase_nodes,
                grid_columns,
                grid_rows,
                grid_steps,
                grid_half_way_m,
                grid_scale,
                lobes,
                soft_lobes,
                regained_per_m,
                snow_albedo,
                daylight_w_per_m2,
                daylight_attenuation_per_m,
                disparity_sign
            }
        );
        same!(
            &CENTRE,
            Solid {
                centre_m,
                half_length_m,
                direction,
                radius_m
            }
        );
        same!(
            &CENTRE,
            Segment {
                solid,
                arc_m,
                curvature_per_m,
                inward,
                instance,
                ends
            }
        );
        same!(
            &CENTRE,
            BvhNode {
                min_m,
                first,
                max_m,
                count
            }
        );
        same!(
            &CENTRE,
            Rod {
                value,
                is_flat,
                arc,
                finish,
                reflectance,
                roughness
            }
        );
        same!(
            &CENTRE,
            Lamp {
                position_m,
                cos_inner,
                direction,
                cos_outer,
                radiant_intensity_w_per_sr
            }
        );
        same!(
            &CENTRE,
            Caster {
                solid,
                touching_plus_m,
                touching_minus_m,
                touches,
                instance
            }
        );
        same!(
            &CENTRE,
            Tile {
                width,
                first_row,
                rows,
                kept_from,
                kept_to,
                has_snow
            }
        );
        same!(&MARK, Indirect { x, y, z, count });
        same!(&MARK, Loops { steps, are_cut });
        same!(
            &WEIGH,
            Flake {
                centre_m,
                range_m,
                from_m,
                opacity,
                aside,
                gain,
                disc_per_px,
                pixel,
                inside_px,
                is_small,
                is_round,
                shading,
                lit_from,
                direct,
                scattered
            }
        );
        same!(&WEIGH, SnowPair { flake, lit });
        same!(
            &WEIGH,
            HaloStrip {
                at,
                size,
                side,
                columns,
                first
            }
        );
        same!(
            &WEIGH,
            HaloLevel {
                columns,
                rows,
                side,
                coarser_columns,
                run_px,
                first_run,
                border,
                kernel,
                farthest
            }
        );
        same!(
            &WEIGH,
            Halo {
                size,
                overscan,
                patches,
                longest_m,
                knots,
                count,
                runs,
                strips,
                levels
            }
        );
    }

    #[test]
    #[should_panic(expected = "Solid")]
    fn fields_in_another_order_are_found() {
        #[derive(Clone, Copy, Debug, Default, ShaderType)]
        struct Solid {
            direction: Vec3f,
            half_length_m: f32,
            centre_m: Vec3f,
            radius_m: f32,
        }
        same!(
            &CENTRE,
            Solid {
                direction,
                half_length_m,
                centre_m,
                radius_m
            }
        );
    }
}
