// Mesa's software driver ends all loops of an invocation after 65535 steps together, without a word: from then on every loop ends
// after its first step. So a pass whose loops are as long as the scene makes them ends with one of two steps.

struct Loops {
    /// Of that one: 2, which no compiler is told.
    steps: u32,
    /// Whether any invocation took fewer. All write the same.
    are_cut: u32,
}

fn loops_are_cut(steps: u32) -> bool {
    var taken = 0u;
    while taken < steps {
        taken++;
    }
    return taken < steps;
}
