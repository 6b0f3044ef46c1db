// Finds the bin that holds the rank, and empties all.

const PART: u32 = BINS / 64u;

var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(64)
fn rank(@builtin(local_invocation_index) lane: u32) {
    for (var i = 0u; i < PART; i++) {
        sums[lane] += atomicLoad(&bins[lane * PART + i]);
    }
    workgroupBarrier();
    if lane == 0u {
        var left = meter.rank;
        var part = 0u;
        while part < 63u && left >= sums[part] {
            left -= sums[part];
            part++;
        }
        var bin = part * PART;
        while bin + 1u < BINS && left >= atomicLoad(&bins[bin]) {
            left -= atomicLoad(&bins[bin]);
            bin++;
        }
        meter.found = (meter.found << BITS) | bin;
        meter.rank = left;
        meter.shift -= min(meter.shift, BITS);
    }
    storageBarrier();
    for (var i = 0u; i < PART; i++) {
        atomicStore(&bins[lane * PART + i], 0u);
    }
}
