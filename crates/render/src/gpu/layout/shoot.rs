//! The camera behind the lens; see `film.wgsl`, `meter.wgsl` and `chip.wgsl`.

use encase::ShaderType;

use super::{Camera, Vec2f, Vec3f, Vec4f, Vec4i};

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Film {
    pub(in crate::gpu) camera: Camera,
    pub(in crate::gpu) lens: u32,
    pub(in crate::gpu) has_halo: u32,
    pub(in crate::gpu) has_vignetting: u32,
    pub(in crate::gpu) bands: u32,
    pub(in crate::gpu) vignetting: Vec2f,
    pub(in crate::gpu) width: u32,
    pub(in crate::gpu) height: u32,
    pub(in crate::gpu) balance: Vec3f,
    pub(in crate::gpu) reach: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Meter {
    pub(in crate::gpu) found: u32,
    pub(in crate::gpu) rank: u32,
    pub(in crate::gpu) shift: u32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Emva {
    pub(in crate::gpu) full_well_e: f32,
    pub(in crate::gpu) read_noise_e: f32,
    pub(in crate::gpu) dark_e: f32,
    pub(in crate::gpu) prnu: f32,
    pub(in crate::gpu) dsnu_e: f32,
    pub(in crate::gpu) steps: f32,
}

#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(in crate::gpu) struct Chip {
    pub(in crate::gpu) kind: u32,
    pub(in crate::gpu) emva: Emva,
    pub(in crate::gpu) gain: f32,
    pub(in crate::gpu) exposure_low: u32,
    pub(in crate::gpu) exposure_high: u32,
    pub(in crate::gpu) specimen_low: u32,
    pub(in crate::gpu) specimen_high: u32,
    pub(in crate::gpu) stream: u32,
    pub(in crate::gpu) has_pattern: u32,
    pub(in crate::gpu) red_column: u32,
    pub(in crate::gpu) red_row: u32,
    pub(in crate::gpu) sigma: f32,
    pub(in crate::gpu) highest: f32,
    pub(in crate::gpu) dark: f32,
    pub(in crate::gpu) balance: Vec3f,
    pub(in crate::gpu) matrix: [Vec4f; 3],
    pub(in crate::gpu) full_scale: f32,
    pub(in crate::gpu) taps: [[Vec4i; 11]; 3],
}

#[cfg(test)]
mod tests {
    use rodsight_shaders::{SENSE, TALLY};

    use super::super::tests::{of_shader, same};
    use super::*;

    #[test]
    fn structures_lie_in_memory_as_the_shaders_read_them() {
        same!(
            &SENSE,
            Film {
                camera,
                lens,
                has_halo,
                has_vignetting,
                bands,
                vignetting,
                width,
                height,
                balance,
                reach
            }
        );
        same!(&TALLY, Meter { found, rank, shift });
        same!(
            &SENSE,
            Emva {
                full_well_e,
                read_noise_e,
                dark_e,
                prnu,
                dsnu_e,
                steps
            }
        );
        same!(
            &SENSE,
            Chip {
                kind,
                emva,
                gain,
                exposure_low,
                exposure_high,
                specimen_low,
                specimen_high,
                stream,
                has_pattern,
                red_column,
                red_row,
                sigma,
                highest,
                dark,
                balance,
                matrix,
                full_scale,
                taps
            }
        );
    }
}
