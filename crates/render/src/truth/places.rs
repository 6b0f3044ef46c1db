//! Where along a rod the truth looks: as close as the image asks for, however long the rod.

use rodsight_geometry::{Intrinsics, MountedCamera, Pixel, Vec3, angle_between};

/// Places on any rod, so that the short ones in the image have enough.
const PLACES: usize = 257;
/// Angle between neighbours seen from the camera, rad, so that none step over the image.
const STEP_RAD: f64 = 1.0 / 64.0;
/// A piece becomes at most 2⁴⁰: only where the axis goes through the camera does an angle not become smaller.
const MAX_HALVINGS: u32 = 40;

/// One place: arc length, m, the axis there, and where it is in the image if it is seen.
type Place = (f64, Vec3, Option<Pixel>);

/// A curve along a rod, as one camera sees it.
pub(super) struct Places<'a> {
    pub(super) mounted: &'a MountedCamera,
    /// Point of the axis at an arc length.
    pub(super) axis_at: &'a dyn Fn(f64) -> Vec3,
    /// Where the curve is in the image at an arc length, possibly outside it.
    pub(super) pixel_at: &'a dyn Fn(f64) -> Option<Pixel>,
    /// Greatest distance between neighbours in the image, px.
    pub(super) step_px: f64,
}

impl Places<'_> {
    /// Arc lengths from −half to half, with what is seen there.
    pub(super) fn along(&self, half_m: f64) -> Vec<(f64, Option<Pixel>)> {
        let at = |i: usize| self.place((2.0 * i as f64 / (PLACES - 1) as f64 - 1.0) * half_m);
        let mut from = at(0);
        let mut places = vec![(from.0, from.2)];
        for i in 1..PLACES {
            let to = at(i);
            self.split(&from, &to, MAX_HALVINGS, &mut places);
            from = to;
        }
        places
    }

    fn place(&self, s_m: f64) -> Place {
        (s_m, (self.axis_at)(s_m), (self.pixel_at)(s_m))
    }

    /// The places after `from` up to `to`.
    fn split(
        &self,
        from: &Place,
        to: &Place,
        halvings: u32,
        places: &mut Vec<(f64, Option<Pixel>)>,
    ) {
        if halvings == 0 || self.is_close(from, to) {
            places.push((to.0, to.2));
            return;
        }
        let middle = self.place(0.5 * (from.0 + to.0));
        self.split(from, &middle, halvings - 1, places);
        self.split(&middle, to, halvings - 1, places);
    }

    fn is_close(&self, from: &Place, to: &Place) -> bool {
        let eye_m = self.mounted.rig_from_camera.origin_m();
        let angle_rad = angle_between(&(from.1 - eye_m), &(to.1 - eye_m));
        let size = self.mounted.camera.intrinsics();
        angle_rad <= STEP_RAD
            && match (from.2, to.2) {
                (Some(a), Some(b)) => beside(size, &a, &b) || (a - b).norm() <= self.step_px,
                (None, None) => true,
                // The edge of what the lens sees may be in the image.
                _ => angle_rad * size.fx_px.max(size.fy_px) <= self.step_px,
            }
    }
}

/// Whether two pixels are on the same side of the image, so that a short curve between them is not in it.
pub(super) fn beside(size: &Intrinsics, a: &Pixel, b: &Pixel) -> bool {
    let outside = |a: f64, b: f64, size_px: u32| a.max(b) < 0.0 || a.min(b) > f64::from(size_px);
    outside(a.x, b.x, size.width_px) || outside(a.y, b.y, size.height_px)
}
