// Random numbers by counter: see noise.rs and noise/quantile.rs.

/// The upper half of a product, by halves: WGSL has no integers of 64 bits.
fn noise_mulhi(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u);
}

/// The four words of a counter: Philox4x32-10.
fn noise_words(key: vec2<u32>, counter: vec4<u32>) -> vec4<u32> {
    let factor = vec2<u32>(0xd2511f53u, 0xcd9e8d57u);
    var k = key;
    var c = counter;
    for (var round = 0; round < 10; round++) {
        let high = vec2<u32>(noise_mulhi(c.x, factor.x), noise_mulhi(c.z, factor.y));
        let low = c.xz * factor;
        c = vec4<u32>(high.y ^ c.y ^ k.x, low.y, high.x ^ c.w ^ k.y, low.x);
        k += vec2<u32>(0x9e3779b9u, 0xbb67ae85u);
    }
    return c;
}

/// The standard normal number of a word in one of the outermost four cells of 512: AS 241 between 4.8 and 2.4 standard deviations.
fn noise_tail(word: u32) -> f32 {
    let is_low = word < 0x80000000u;
    // Counted from the nearer end, where f32 has the digits.
    let p = (f32(select(~word, word, is_low)) + 0.5) / 4294967296.0;
    let x = sqrt(-log(p)) - 1.6;
    let above = 1.4234371 + x * (4.6303378 + x * (5.7694972 + x * (3.6478483 + x * (1.2704583
        + x * (0.24178073 + x * (0.022723845 + x * 7.7454501e-4))))));
    let below = 1.0 + x * (2.0531916 + x * (1.6763848 + x * (0.68976733 + x * (0.14810398
        + x * (0.015198667 + x * (5.4759381e-4 + x * 1.0507501e-9))))));
    return select(above / below, -above / below, is_low);
}

/// The standard normal number of a word, by the cubic of its cell, but in the tails.
fn noise_normal(cubic: vec4<f32>, word: u32) -> f32 {
    if min(word, ~word) < 0x2000000u {
        return noise_tail(word);
    }
    let s = (f32(word & 0x7fffffu) + 0.5) / 8388608.0;
    return cubic.x + s * (cubic.y + s * (cubic.z + s * cubic.w));
}

/// A Poisson number: from a standard normal number at a mean of 30 and above, else from uniform ones. `counter.w` counts those.
fn noise_poisson(key: vec2<u32>, mean: f32, normal: f32, counter: vec4<u32>) -> f32 {
    if mean >= 30.0 {
        return max(floor(mean + sqrt(mean) * normal + 0.5), 0.0);
    }
    let limit = exp(-mean);
    var product = 1.0;
    var words = vec4<u32>(0u);
    // No mean below 30 comes to 256 in the age of the universe.
    for (var count = 0u; count < 256u; count++) {
        if (count & 3u) == 0u {
            words = noise_words(key, vec4<u32>(counter.xyz, count >> 2u));
        }
        product *= (f32(words.x) + 0.5) / 4294967296.0;
        if product <= limit {
            return f32(count);
        }
        words = words.yzwx;
    }
    return 256.0;
}
