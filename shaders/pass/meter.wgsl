// Automatic exposure: of all samples the one of a rank, eleven of its bits at a time, the highest first.

/// What is known of it.
struct Meter {
    /// Its highest bits.
    found: u32,
    /// Its rank among the samples that begin with them.
    rank: u32,
    /// Bits below those that are counted.
    shift: u32,
}

const BITS: u32 = 11u;
const BINS: u32 = 2048u;

@group(1) @binding(0) var<storage, read_write> meter: Meter;
/// How many samples there are of each of the next bits.
@group(1) @binding(1) var<storage, read_write> bins: array<atomic<u32>, BINS>;
