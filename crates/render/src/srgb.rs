//! The sRGB transfer function (IEC 61966-2-1).

/// Encoded value in [0, 1] of a linear value; clips to [0, 1].
pub fn srgb_encode(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.0031308 {
        12.92 * x
    } else {
        1.055 * libm::pow(x, 1.0 / 2.4) - 0.055
    }
}

/// Linear value of an encoded one in [0, 1].
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        libm::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

/// d(encoded)/d(linear): how noise on the linear value shows in the encoded one.
pub(crate) fn srgb_slope(linear: f64) -> f64 {
    if linear <= 0.0031308 {
        12.92
    } else {
        1.055 / 2.4 * libm::pow(linear, 1.0 / 2.4 - 1.0)
    }
}
