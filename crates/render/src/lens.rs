//! The lens, on the way from radiance to what falls on the sensor: vignetting, then blur. The blur that depends on depth is
//! [`expose`](crate::expose)'s.

pub(crate) mod blur;

use rayon::prelude::*;
use rodsight_geometry::{Camera, Eye, Pixel};
use rodsight_scene::Scene;

use crate::frame::EyeFrame;

/// Wavelengths of the bands, m: of their light in air, behind the port.
const WAVELENGTHS_M: [f64; 3] = [600e-9, 525e-9, 475e-9];

/// What falls on an eye's sensor, as the radiance that would do the same through a perfect lens, W m⁻² sr⁻¹.
pub(crate) fn on_sensor(frame: &EyeFrame, scene: &Scene, eye: Eye) -> Vec<[f32; 3]> {
    let camera = &scene.rig.eye(eye).camera;
    let width = frame.width_px as usize;
    let mut light: Vec<[f32; 3]> = frame.pixels.iter().map(|pixel| pixel.radiance).collect();
    if let Some(falloff) = scene.lens.vignetting {
        light.par_iter_mut().enumerate().for_each(|(index, light)| {
            let (column, row) = (index % width, index / width);
            let pixel = Pixel::new(column as f64 + 0.5, row as f64 + 0.5);
            let share = vignetting(camera, falloff, &pixel) as f32;
            *light = light.map(|v| v * share);
        });
    }
    blur::gaussian(&mut light, width, blur_sigma_px(scene, camera));
    light
}

/// cos⁴θ (1 + v1 r² + v2 r⁴), not below 0.
pub(crate) fn vignetting(camera: &Camera, [v1, v2]: [f64; 2], pixel: &Pixel) -> f64 {
    let i = camera.intrinsics();
    let half_diagonal2 = 0.25 * (f64::from(i.width_px).powi(2) + f64::from(i.height_px).powi(2));
    let r2 = ((pixel.x - i.cx_px).powi(2) + (pixel.y - i.cy_px).powi(2)) / half_diagonal2;
    let cos2 = camera
        .ray(pixel)
        .map_or(0.0, |ray| ray.z * ray.z / ray.norm_squared());
    cos2 * cos2 * (1.0 + r2 * (v1 + r2 * v2)).max(0.0)
}

/// Standard deviation of the blur that is alike over the image, per band: the lens's own, and diffraction as the Gaussian nearest to
/// the core of Airy's pattern, 0.42 λ N (Zhang, Zerubia and Olivo-Marin 2007, Applied Optics 46, 1819: 0.21 λ/NA).
fn blur_sigma_px(scene: &Scene, camera: &Camera) -> [f64; 3] {
    let own_px = scene.lens.psf_sigma_px;
    let Some(aperture) = scene.lens.aperture else {
        return [own_px; 3];
    };
    let pixel_m = aperture.focal_length_m / camera.intrinsics().fx_px;
    WAVELENGTHS_M.map(|wavelength_m| {
        let diffraction_px = 0.42 * wavelength_m * aperture.f_number / pixel_m;
        (own_px * own_px + diffraction_px * diffraction_px).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use rodsight_geometry::{Distortion, Intrinsics};

    use super::*;

    #[test]
    fn vignetting_is_the_fourth_power_of_the_cosine_times_the_polynomial() {
        let intrinsics = Intrinsics {
            width_px: 300,
            height_px: 400,
            fx_px: 100.0,
            fy_px: 100.0,
            cx_px: 150.0,
            cy_px: 200.0,
        };
        let camera = Camera::new(intrinsics, Distortion::None).expect("a pinhole");
        let at = |u, v, polynomial| vignetting(&camera, polynomial, &Pixel::new(u, v));
        assert_eq!(at(150.0, 200.0, [-0.5, 0.1]), 1.0);
        // 100 px off axis at f = 100 px: 45°, r = 100/250.
        assert!((at(250.0, 200.0, [0.0, 0.0]) - 0.25).abs() < 1e-15);
        let expected = 0.25 * (1.0 - 0.3 * 0.16 + 0.05 * 0.0256);
        assert!((at(150.0, 100.0, [-0.3, 0.05]) - expected).abs() < 1e-15);
    }
}
