//! Renders what the methods look at, and writes down what is true of it.

use rodsight_bench::{Limit, edge_sigma_px, limit};
use rodsight_geometry::{
    Camera, Cylinder, Eye, Image, Line3, MountedCamera, Rig, Samples, StereoPair,
};
use rodsight_render::{CpuRenderer, Renderer, Truth, develop};
use rodsight_scene::Scene;
use rodsight_solver::Roi;

use super::draft::Trial;
use crate::asked::Failure;

/// A pair and the truth of it.
pub(crate) struct Shot {
    /// With the rig as the solver is told.
    pub(crate) pair: StereoPair,
    /// The rod of the truth record, its grasp as the axis' reference point.
    pub(crate) target: Cylinder,
    pub(crate) limit: Option<Limit>,
    /// Of the four limbs, root mean square.
    pub(crate) contrast_to_noise: Option<f64>,
}

impl Trial {
    /// Renders the regions alone, by cameras that are windows onto the whole images: the same rays, and the same light but for the
    /// exposure, which is metered in the regions, and the halo, whose width in pixels is that at the middle of the window. What lies
    /// outside stays black.
    pub(crate) fn shoot(&self) -> Result<Shot, Failure> {
        let scene = self.windowed();
        let frame = CpuRenderer.render(&scene, &|_| ())?;
        let developed = develop(&frame, &scene)?;
        let truth = Truth::of(&scene, &frame, developed.gain)
            .ok_or("a scene whose grasp cannot be seen")?;
        let whole = |eye| {
            whole(
                developed.eye(eye),
                &self.scene.rig.eye(eye).camera,
                self.region(eye),
            )
        };
        let [left, right] = Eye::BOTH.map(whole);
        Ok(Shot {
            pair: StereoPair {
                rig: self.believed,
                left,
                right,
            },
            target: Cylinder {
                axis: Line3::new(
                    truth.grasp.point_m.into(),
                    &truth.grasp.axis.direction.into(),
                ),
                radius_m: truth.target().radius_m,
            },
            limit: self.limit(&truth)?,
            contrast_to_noise: contrast(&truth),
        })
    }

    fn region(&self, eye: Eye) -> &Roi {
        &self.regions[eye as usize]
    }

    /// The scene before cameras that see the regions alone.
    pub(crate) fn windowed(&self) -> Scene {
        let through = |eye: Eye| window(self.scene.rig.eye(eye), self.region(eye));
        Scene {
            rig: Rig {
                left: through(Eye::Left),
                right: through(Eye::Right),
            },
            ..self.scene.clone()
        }
    }

    /// That of the pixel's aperture and the lens; the images' alone: what the solver is told wrongly of the cameras is not in it.
    fn limit(&self, truth: &Truth) -> Result<Option<Limit>, Failure> {
        if self.believed != self.scene.rig {
            return Ok(None);
        }
        // Variances go with the edge's spread, alike at every limb.
        let spread = edge_sigma_px(self.scene.lens.psf_sigma_px) / edge_sigma_px(0.0);
        let wider = libm::sqrt(spread);
        Ok(limit(truth)?.map(|sharp| Limit {
            axis_offset_m: wider * sharp.axis_offset_m,
            axis_angle_rad: wider * sharp.axis_angle_rad,
            radius_m: wider * sharp.radius_m,
        }))
    }
}

fn window(mounted: &MountedCamera, region: &Roi) -> MountedCamera {
    let mut i = *mounted.camera.intrinsics();
    i.cx_px -= f64::from(region.x_px);
    i.cy_px -= f64::from(region.y_px);
    (i.width_px, i.height_px) = (region.width_px, region.height_px);
    let camera = Camera::new(i, *mounted.camera.distortion());
    MountedCamera {
        camera: camera.expect("part of a camera is one"),
        ..*mounted
    }
}

/// An image of the camera's size with a part of it in its place.
fn whole(part: &Image, camera: &Camera, region: &Roi) -> Image {
    let i = camera.intrinsics();
    let Samples::U8(from) = part.samples() else {
        unreachable!("the scenes ask for 8 bits");
    };
    let channels = usize::from(part.channels());
    let mut samples = vec![0; channels * i.width_px as usize * i.height_px as usize];
    let row = channels * region.width_px as usize;
    for (y, line) in from.chunks_exact(row).enumerate() {
        let pixel = (region.y_px as usize + y) * i.width_px as usize + region.x_px as usize;
        samples[channels * pixel..][..row].copy_from_slice(line);
    }
    Image::new(
        i.width_px,
        i.height_px,
        part.channels(),
        Samples::U8(samples),
    )
    .expect("as many samples as pixels")
}

fn contrast(truth: &Truth) -> Option<f64> {
    let rod = truth.target();
    let limbs = [&rod.left, &rod.right].map(|eye| eye.contrast_to_noise);
    let limbs: Option<Vec<f64>> = limbs.into_iter().flatten().collect();
    let squares: f64 = limbs?.iter().map(|contrast| contrast * contrast).sum();
    Some(libm::sqrt(squares / 4.0))
}
