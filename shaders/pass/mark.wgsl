// Lists the pixels that one sample cannot stand for, and counts the workgroups that the next pass needs.

struct Indirect {
    x: atomic<u32>,
    y: atomic<u32>,
    z: u32,
    count: atomic<u32>,
}

@group(2) @binding(0) var<storage, read_write> indirect: Indirect;

/// Neighbouring pixels of one rod whose ranges differ by more than this fraction are an edge of it against itself.
const DEPTH_STEP: f32 = 0.02;

fn mark_differs(here: u32, there: u32) -> bool {
    let pixels = tile.width * tile.rows;
    let key = keys[here] & ~KEY_LIMB;
    if key != (keys[there] & ~KEY_LIMB) || keys[pixels + here] != keys[pixels + there] {
        return true;
    }
    let range = bitcast<f32>(keys[2u * pixels + here]);
    let step = abs(range - bitcast<f32>(keys[2u * pixels + there]));
    return (key & 0xffffu) >= 2u && step > DEPTH_STEP * range;
}

@compute @workgroup_size(8, 8)
fn mark(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile.width || id.y < tile.kept_from || id.y >= tile.kept_to {
        return;
    }
    let pixel = id.y * tile.width + id.x;
    var is_edge = (keys[pixel] & KEY_LIMB) != 0u;
    for (var row = max(id.y, 1u) - 1u; row < min(id.y + 2u, tile.rows); row++) {
        for (var column = max(id.x, 1u) - 1u; column < min(id.x + 2u, tile.width); column++) {
            is_edge = is_edge || mark_differs(pixel, row * tile.width + column);
        }
    }
    var place = 0u;
    if is_edge {
        let before = atomicAdd(&indirect.count, 1u);
        edges[before] = pixel;
        atomicMax(&indirect.x, min(before + 1u, REFINE_ACROSS));
        atomicMax(&indirect.y, before / REFINE_ACROSS + 1u);
        place = before + 1u;
    }
    keys[3u * tile.width * tile.rows + pixel] = place;
}
