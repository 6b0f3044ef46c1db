//! Speed by stage: the benchmarks lie in `benches/`, one file a crate. Run them with `cargo bench -p rodsight-benches`.
