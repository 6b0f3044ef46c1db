// Counts an eye's samples.

/// Pixels of a workgroup.
const RUN_PX: u32 = 4096u;

var<workgroup> counts: array<atomic<u32>, BINS>;

@compute @workgroup_size(64)
fn tally(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let first = group.x * RUN_PX;
    let last = min(first + RUN_PX, film.width * film.height);
    for (var pixel = first + lane; pixel < last; pixel += 64u) {
        let bits = bitcast<vec3<u32>>(film_light(pixel) * film.balance);
        // In this order floats are what `f32::total_cmp` says.
        let keys = select(bits ^ vec3<u32>(0x80000000u), ~bits, bits >= vec3<u32>(0x80000000u));
        for (var band = 0u; band < 3u; band++) {
            let begin = keys[band] >> meter.shift;
            if begin >> BITS == meter.found {
                atomicAdd(&counts[begin % BINS], 1u);
            }
        }
    }
    workgroupBarrier();
    for (var bin = lane; bin < BINS; bin += 64u) {
        let count = atomicLoad(&counts[bin]);
        if count > 0u {
            atomicAdd(&bins[bin], count);
        }
    }
}
