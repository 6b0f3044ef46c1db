//! The exponential of three bands at once.

use crate::Bands;

/// e^x of each band.
pub(crate) fn exp(x: &Bands) -> Bands {
    [libm::exp(x[0]), libm::exp(x[1]), libm::exp(x[2])]
}
