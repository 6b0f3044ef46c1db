//! What a renderer returns.

use rayon::prelude::*;
use rodsight_geometry::{Band, Eye};
use rodsight_scene::{Mode, Scene};

/// Both eyes of one scene, before the sensor.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The left eye.
    pub left: EyeFrame,
    /// The right eye.
    pub right: EyeFrame,
    /// Backend that rendered it.
    pub backend: &'static str,
    /// What it ran on.
    pub adapter: String,
}

impl Frame {
    /// The frame of an eye.
    pub fn eye(&self, eye: Eye) -> &EyeFrame {
        match eye {
            Eye::Left => &self.left,
            Eye::Right => &self.right,
        }
    }
}

/// One eye: shape `[height, width]`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct EyeFrame {
    /// Width, px.
    pub width_px: u32,
    /// Height, px.
    pub height_px: u32,
    /// The pixels.
    pub pixels: Vec<PixelTruth>,
}

impl EyeFrame {
    /// The pixel in a column and row.
    pub fn at(&self, column: u32, row: u32) -> &PixelTruth {
        &self.pixels[row as usize * self.width_px as usize + column as usize]
    }

    /// Share of the pixels that are beyond the model.
    pub fn beyond_model_share(&self) -> f64 {
        let beyond = self.pixels.iter().filter(|pixel| pixel.beyond_model);
        beyond.count() as f64 / self.pixels.len() as f64
    }

    /// Flags what is beyond the model, by its range.
    pub(crate) fn mark_beyond_model(&mut self, scene: &Scene) {
        if scene.mode != Mode::Full {
            return;
        }
        self.pixels.par_iter_mut().for_each(|pixel| {
            let range_m = f64::from(pixel.range_m);
            pixel.beyond_model = range_m.is_finite() && scene.medium.is_beyond_model(range_m);
        });
    }

    /// Takes the light of one band from a frame of the same size.
    pub(crate) fn take_light(&mut self, other: &Self, band: Band) {
        let band = band.index();
        for (mine, theirs) in self.pixels.iter_mut().zip(&other.pixels) {
            mine.radiance[band] = theirs.radiance[band];
            mine.direct[band] = theirs.direct[band];
            mine.forward[band] = theirs.forward[band];
            mine.backscatter[band] = theirs.backscatter[band];
            mine.snow[band] = theirs.snow[band];
            mine.clean[band] = theirs.clean[band];
            mine.transmission[band] = theirs.transmission[band];
        }
    }
}

/// Light and truth of one pixel. Light is the mean over the pixel; geometry is that of the ray through its centre, in the green band
/// where a port parts the bands. Behind a port all radiance is that at the lens, in air: Fresnel's losses at both faces and the
/// widening of the pencil by n² are in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelTruth {
    /// Radiance that reaches the lens, W m⁻² sr⁻¹ per band: `direct + forward + backscatter + snow`.
    pub radiance: [f32; 3],
    /// Light from the surface that was not scattered, W m⁻² sr⁻¹.
    pub direct: [f32; 3],
    /// Light of surfaces here and around that the water scattered forwards, the halo, W m⁻² sr⁻¹; 0 but in mode `full`.
    pub forward: [f32; 3],
    /// Light scattered by the water on its way from lamps and ambient, W m⁻² sr⁻¹.
    pub backscatter: [f32; 3],
    /// Light of marine snow that was not scattered, W m⁻² sr⁻¹; what was is in `forward`.
    pub snow: [f32; 3],
    /// The same surface without water, W m⁻² sr⁻¹.
    pub clean: [f32; 3],
    /// Beam transmission from the surface to the lens, [0, 1]; 0 where there is no surface.
    pub transmission: [f32; 3],
    /// Share of the pixel that marine snow covers, [0, 1]. All geometry is that of the surface behind it.
    pub snow_cover: f32,
    /// Unit normal of the surface in the camera frame, as light sees it (rounded on meshes, rippled on the seabed); zero where there is none.
    pub normal: [f32; 3],
    /// z in the camera frame, m; +∞ where there is no surface.
    pub depth_m: f32,
    /// Distance along the ray in the water, from the camera's centre or the port's outer face, m; +∞ where there is no surface.
    pub range_m: f32,
    /// `u_left − u_right` of this surface point, px; +∞ where there is no surface or the other eye looks away from it.
    pub disparity_px: f32,
    /// 0 nothing, 1 seabed, then one for each rod, each occluder, each prop, the growth on each rod, and one for all stones.
    pub instance: u16,
    /// 0 nothing, 1 seabed, 2 rod, 3 occluder, 4 prop, 5 growth, 6 stone.
    pub material: u16,
    /// The other eye does not see this surface point: hidden or outside its image.
    pub occluded: bool,
    /// In mode `full`: there is a surface, and more water before it than the model is good for, c z > 2.5 in some band.
    pub beyond_model: bool,
}

impl PixelTruth {
    /// No surface, no light.
    pub(crate) const NOTHING: Self = Self {
        radiance: [0.0; 3],
        direct: [0.0; 3],
        forward: [0.0; 3],
        backscatter: [0.0; 3],
        snow: [0.0; 3],
        clean: [0.0; 3],
        transmission: [0.0; 3],
        snow_cover: 0.0,
        normal: [0.0; 3],
        depth_m: f32::INFINITY,
        range_m: f32::INFINITY,
        disparity_px: f32::INFINITY,
        instance: 0,
        material: 0,
        occluded: false,
        beyond_model: false,
    };

    /// Makes the radiance that of its parts; the halo last, as it is known last.
    pub(crate) fn sum_radiance(&mut self) {
        let [direct, back, snow, forward] =
            [self.direct, self.backscatter, self.snow, self.forward];
        self.radiance = core::array::from_fn(|k| direct[k] + back[k] + snow[k] + forward[k]);
    }
}
