// Lists the pixels that one sample cannot stand for, and counts the workgroups that the next pass needs.

struct Indirect {
    x: atomic<u32>,
    y: atomic<u32>,
    z: u32,
    count: atomic<u32>,
    inner_count: atomic<u32>,
}

@group(2) @binding(0) var<storage, read_write> indirect: Indirect;

/// Neighbouring pixels of one rod whose ranges differ by more than this fraction are an edge of it against itself.
const DEPTH_STEP: f32 = 0.02;

/// What lies between two neighbouring pixels.
const EDGE_NONE: u32 = 0u;
/// The light changes, or one smooth piece of a thing meets the next.
const EDGE_INNER: u32 = 1u;
/// Of a thing before another or itself, or of a rod's end.
const EDGE_OUTLINE: u32 = 2u;

fn mark_between(here: u32, there: u32) -> u32 {
    let pixels = tile.width * tile.rows;
    let key = keys[here] & ~KEY_GRAZES;
    let range = bitcast<f32>(keys[2u * pixels + here]);
    let step = abs(range - bitcast<f32>(keys[2u * pixels + there]));
    if key != (keys[there] & ~KEY_GRAZES) || ((key & 0xffffu) >= 2u && step > DEPTH_STEP * range) {
        return EDGE_OUTLINE;
    }
    return select(EDGE_NONE, EDGE_INNER, keys[pixels + here] != keys[pixels + there]);
}

@compute @workgroup_size(8, 8)
fn mark(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile.width || id.y < tile.kept_from || id.y >= tile.kept_to {
        return;
    }
    let pixel = id.y * tile.width + id.x;
    var edge = select(EDGE_NONE, EDGE_OUTLINE, (keys[pixel] & KEY_GRAZES) != 0u);
    for (var row = max(id.y, 1u) - 1u; row < min(id.y + 2u, tile.rows); row++) {
        for (var column = max(id.x, 1u) - 1u; column < min(id.x + 2u, tile.width); column++) {
            edge = max(edge, mark_between(pixel, row * tile.width + column));
        }
    }
    var place = 0u;
    if edge != EDGE_NONE {
        // Outlines from the front of the list, the others from its back.
        let pixels = tile.width * tile.rows;
        var before = 0u;
        if edge == EDGE_OUTLINE {
            before = atomicAdd(&indirect.count, 1u);
            place = before + 1u;
        } else {
            before = atomicAdd(&indirect.inner_count, 1u);
            place = pixels - before;
        }
        edges[place - 1u] = pixel;
        atomicMax(&indirect.x, min(before + 1u, REFINE_ACROSS));
        atomicMax(&indirect.y, before / REFINE_ACROSS + 1u);
    }
    keys[3u * tile.width * tile.rows + pixel] = place;
}
