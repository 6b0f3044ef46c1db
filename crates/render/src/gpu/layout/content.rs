//! What stands in the water; see `content.wgsl`.

use encase::ShaderType;

use super::{Solid, Vec2f, Vec3f};

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Arc {
    pub(in crate::gpu) centre_m: Vec3f,
    pub(in crate::gpu) curvature_per_m: f32,
    pub(in crate::gpu) direction: Vec3f,
    pub(in crate::gpu) towards: Vec3f,
    pub(in crate::gpu) side: Vec3f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Finish {
    pub(in crate::gpu) stripe: Vec3f,
    pub(in crate::gpu) period_m: f32,
    pub(in crate::gpu) share: f32,
    pub(in crate::gpu) starts: f32,
    pub(in crate::gpu) contrast: f32,
    pub(in crate::gpu) scale_m: f32,
    pub(in crate::gpu) seed: u32,
    pub(in crate::gpu) radius_m: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct SeabedRipples {
    pub(in crate::gpu) wavelength_m: f32,
    pub(in crate::gpu) height_m: f32,
    pub(in crate::gpu) heading: Vec2f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Lump {
    pub(in crate::gpu) centre_m: Vec3f,
    pub(in crate::gpu) is_cube: u32,
    pub(in crate::gpu) to_unit_x: Vec3f,
    pub(in crate::gpu) to_unit_y: Vec3f,
    pub(in crate::gpu) to_unit_z: Vec3f,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Body {
    pub(in crate::gpu) lump: Lump,
    pub(in crate::gpu) side: Solid,
    pub(in crate::gpu) albedo: Vec3f,
    pub(in crate::gpu) instance: u32,
    pub(in crate::gpu) part: u32,
    pub(in crate::gpu) is_side: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Vertex {
    pub(in crate::gpu) position_m: Vec3f,
    pub(in crate::gpu) u: f32,
    pub(in crate::gpu) normal: Vec3f,
    pub(in crate::gpu) v: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Triangle {
    pub(in crate::gpu) a: u32,
    pub(in crate::gpu) b: u32,
    pub(in crate::gpu) c: u32,
    pub(in crate::gpu) part: u32,
    pub(in crate::gpu) paint: u32,
    pub(in crate::gpu) curvature_per_m: f32,
    pub(in crate::gpu) texels_per_m: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Paint {
    pub(in crate::gpu) base: Vec3f,
    pub(in crate::gpu) metallic: f32,
    pub(in crate::gpu) roughness: f32,
    pub(in crate::gpu) instance: u32,
    pub(in crate::gpu) first: u32,
    pub(in crate::gpu) levels: u32,
    pub(in crate::gpu) width: u32,
    pub(in crate::gpu) height: u32,
    pub(in crate::gpu) wrap_u: u32,
    pub(in crate::gpu) wrap_v: u32,
}

#[cfg(test)]
mod tests {
    use rodsight_shaders::CENTRE;

    use super::super::tests::{of_shader, same};
    use super::*;

    #[test]
    fn structures_lie_in_memory_as_the_shaders_read_them() {
        same!(
            &CENTRE,
            Arc {
                centre_m,
                curvature_per_m,
                direction,
                towards,
                side
            }
        );
        same!(
            &CENTRE,
            Finish {
                stripe,
                period_m,
                share,
                starts,
                contrast,
                scale_m,
                seed,
                radius_m
            }
        );
        same!(
            &CENTRE,
            SeabedRipples {
                wavelength_m,
                height_m,
                heading
            }
        );
        same!(
            &CENTRE,
            Lump {
                centre_m,
                is_cube,
                to_unit_x,
                to_unit_y,
                to_unit_z
            }
        );
        same!(
            &CENTRE,
            Body {
                lump,
                side,
                albedo,
                instance,
                part,
                is_side
            }
        );
        same!(
            &CENTRE,
            Vertex {
                position_m,
                u,
                normal,
                v
            }
        );
        same!(
            &CENTRE,
            Triangle {
                a,
                b,
                c,
                part,
                paint,
                curvature_per_m,
                texels_per_m
            }
        );
        same!(
            &CENTRE,
            Paint {
                base,
                metallic,
                roughness,
                instance,
                first,
                levels,
                width,
                height,
                wrap_u,
                wrap_v
            }
        );
    }
}
