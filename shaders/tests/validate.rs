//! Shaders compile on the device, late: here every pass is parsed and validated on the bare machine.

use std::collections::BTreeSet;

use rodsight_shaders::{LIB, PASSES, Part, Pass};

/// The fault of a pass, with its file and line.
fn fault(pass: &Pass) -> Option<String> {
    let source = pass.source();
    let at = |location: Option<naga::SourceLocation>| {
        location
            .and_then(|l| pass.locate(l.line_number as usize))
            .map_or_else(|| "?".to_owned(), |(file, line)| format!("{file}:{line}"))
    };
    let module = match naga::front::wgsl::parse_str(&source) {
        Ok(module) => module,
        Err(error) => {
            return Some(format!(
                "{}: {}",
                at(error.location(&source)),
                error.message()
            ));
        }
    };
    let entries: Vec<&str> = module
        .entry_points
        .iter()
        .map(|e| e.name.as_str())
        .collect();
    if entries != [pass.name] {
        return Some(format!(
            "entry points {entries:?} instead of {:?}",
            pass.name
        ));
    }
    naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::default(),
    )
    .validate(&module)
    .err()
    .map(|error| {
        format!(
            "{}: {}",
            at(error.location(&source)),
            error.emit_to_string(&source)
        )
    })
}

#[test]
fn passes_parse_and_validate() {
    assert!(!PASSES.is_empty(), "no pass was checked");
    let faults: Vec<String> = PASSES
        .iter()
        .filter_map(|pass| fault(pass).map(|fault| format!("{}: {fault}", pass.name)))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Files below a folder of `shaders/`.
fn files(folder: &str) -> BTreeSet<String> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    std::fs::read_dir(path)
        .expect("the folder")
        .map(|entry| {
            format!(
                "{folder}/{}",
                entry.expect("an entry").file_name().display()
            )
        })
        .collect()
}

#[test]
fn files_are_listed_and_listed_files_are_used() {
    let used: BTreeSet<String> = PASSES
        .iter()
        .flat_map(|pass| pass.parts)
        .map(|part| part.file.to_owned())
        .collect();
    let there: BTreeSet<String> = files("lib").union(&files("pass")).cloned().collect();
    assert_eq!(used, there);
    let listed: BTreeSet<String> = LIB.iter().map(|part| part.file.to_owned()).collect();
    assert_eq!(listed, files("lib"));
}

/// A library function begins with the name of its file, and a library file binds nothing.
#[test]
fn library_functions_are_pure_and_carry_the_name_of_their_file() {
    let mut functions = 0;
    for part in LIB {
        let prefix = part
            .file
            .trim_start_matches("lib/")
            .trim_end_matches(".wgsl");
        assert!(
            !part.text.contains("var<") && !part.text.contains('@'),
            "{}",
            part.file
        );
        for name in part
            .text
            .lines()
            .filter_map(|line| line.strip_prefix("fn "))
        {
            assert!(
                name.starts_with(&format!("{prefix}_")),
                "{}: {name}",
                part.file
            );
            functions += 1;
        }
    }
    assert!(functions > 10, "{functions}");
}

#[test]
fn broken_shaders_are_reported_at_their_file_and_line() {
    const FINE: Part = Part {
        file: "fine.wgsl",
        text: "fn one() -> f32 {\n    return 1.0;\n}\n",
    };
    let broken = |text: &'static str| Part {
        file: "broken.wgsl",
        text,
    };
    let fault_of = |part: Part| {
        let parts: &'static [Part] = Box::leak(Box::new([FINE, part]));
        fault(&Pass {
            name: "main",
            parts,
        })
        .expect("a fault")
    };
    let parse = fault_of(broken(
        "\n@compute @workgroup_size(1)\nfn main() {\n    let x = two();\n}\n",
    ));
    assert!(parse.starts_with("broken.wgsl:4:"), "{parse}");
    // Parses, but returns nothing where it must.
    let valid = fault_of(broken(
        "fn f() -> f32 {\n    if one() > 2.0 {\n        return 1.0;\n    }\n}\n@compute @workgroup_size(1)\nfn main() {}\n",
    ));
    assert!(valid.contains("broken.wgsl"), "{valid}");
    let name = fault_of(broken("@compute @workgroup_size(1)\nfn other() {}\n"));
    assert!(name.contains("other"), "{name}");
}
