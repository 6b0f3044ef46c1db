//! No number, however odd, makes the loader panic or lets something into a scene that is no number.

use std::path::PathBuf;

use proptest::prelude::*;
use rodsight_scene::{Scene, SceneFile};

fn paper() -> (PathBuf, String) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/paper.toml");
    let text = std::fs::read_to_string(&path).expect("shipped");
    (path, text)
}

/// Start and end of every number of the file that stands for itself.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let mut spans = Vec::new();
    let mut start = None;
    let mut comment = false;
    let mut quoted = false;
    let mut last = ' ';
    for (at, c) in text.char_indices() {
        match c {
            '\n' => comment = false,
            '#' if !quoted => comment = true,
            '"' if !comment => quoted = !quoted,
            _ => {}
        }
        let part = !comment && !quoted && (c.is_ascii_digit() || c == '.' || c == '-');
        if part && start.is_none() && !(last.is_alphanumeric() || last == '_') {
            start = Some(at);
        }
        if !part && let Some(from) = start.take() {
            spans.push((from, at));
        }
        last = c;
    }
    spans
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn odd_numbers_are_refused_or_harmless(
        which in any::<prop::sample::Index>(),
        odd in prop::sample::select(vec![
            "nan", "inf", "-inf", "0", "-0.0", "-1", "1e300", "-1e300", "1e-300", "5e-324", "1.7e308", "4294967296", "true", "\"x\"", "[]",
        ]),
    ) {
        let (path, text) = paper();
        let spans = numbers(&text);
        prop_assert!(spans.len() > 80, "{}", spans.len());
        let (from, to) = spans[which.index(spans.len())];
        let broken = format!("{}{odd}{}", &text[..from], &text[to..]);
        match Scene::from_toml(&broken, &path) {
            Err(error) => {
                let message = error.to_string();
                prop_assert!(message.contains("paper.toml"), "{}", message);
            }
            Ok(scene) => {
                let resolved = SceneFile::from_scene(&scene).to_toml();
                for bad in ["nan", "inf"] {
                    let found = resolved.lines().find(|line| line.split([' ', ',', '[', ']']).any(|word| word.trim_start_matches('-') == bad));
                    prop_assert!(found.is_none(), "{} became {:?}", &broken[from.saturating_sub(60)..from], found);
                }
                let again = Scene::from_toml(&resolved, &path).expect("a resolved scene loads");
                prop_assert_eq!(format!("{:?}", scene), format!("{:?}", again));
            }
        }
    }
}
