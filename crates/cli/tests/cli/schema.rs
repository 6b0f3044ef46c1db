//! `rodsight schema`: the published formats are those of the files.

use serde_json::Value;

use crate::harness::{pair, read_json, rodsight, solve};

/// What of a value is not as its schema says, of the parts of JSON Schema that ours use: references, types, properties,
/// required keys, items, alternatives.
fn faults(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root
            .pointer(reference.trim_start_matches('#'))
            .expect("a reference that resolves");
        return faults(root, target, value, at);
    }
    if let Some(alternatives) = schema["anyOf"]
        .as_array()
        .or_else(|| schema["oneOf"].as_array())
    {
        let fits = alternatives
            .iter()
            .any(|one| faults(root, one, value, at).is_empty());
        return if fits {
            Vec::new()
        } else {
            vec![format!("{at}: none of the alternatives: {value}")]
        };
    }
    let name = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let is = |expected: &Value| expected == name || (expected == "number" && name == "integer");
    let fits = match &schema["type"] {
        Value::Null => true,
        Value::Array(types) => types.iter().any(is),
        one => is(one),
    };
    let mut found = Vec::new();
    if !fits {
        found.push(format!("{at}: expected {}, found {name}", schema["type"]));
    }
    if let (Some(values), items @ Value::Object(_)) = (value.as_array(), &schema["items"]) {
        found.extend(
            values
                .iter()
                .enumerate()
                .flat_map(|(i, v)| faults(root, items, v, &format!("{at}[{i}]"))),
        );
    }
    if let (Some(object), Some(properties)) = (value.as_object(), schema["properties"].as_object())
    {
        for key in schema["required"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
        {
            if !object.contains_key(key) {
                found.push(format!("{at}.{key}: missing"));
            }
        }
        for (key, value) in object {
            match properties.get(key) {
                Some(schema) => found.extend(faults(root, schema, value, &format!("{at}.{key}"))),
                None => found.push(format!("{at}.{key}: not in the schema")),
            }
        }
    }
    found
}

fn schema(format: &str) -> Value {
    rodsight(&["schema", format]).json()
}

#[test]
fn schema_of_every_format_is_a_described_object() {
    for format in ["scene", "rig", "result", "truth", "params", "also"] {
        let schema = schema(format);
        assert!(
            schema["$schema"]
                .as_str()
                .unwrap()
                .contains("json-schema.org"),
            "{format}"
        );
        let properties = schema["properties"].as_object().unwrap();
        assert!(properties.len() > 3, "{format}");
        for (key, property) in properties {
            assert!(
                property["description"].is_string() || property["$ref"].is_string(),
                "{format}: {key}: {property}"
            );
        }
    }
    rodsight(&["schema", "sceen"]).failed(2, &["sceen", "scene"]);
}

#[test]
fn truth_is_as_its_schema_says() {
    let (schema, truth) = (schema("truth"), read_json(&pair().join("truth.json")));
    assert_eq!(
        faults(&schema, &schema, &truth, "truth"),
        Vec::<String>::new()
    );
    // The check itself can fail.
    for (pointer, wrong) in [
        ("/gain", Value::from("much")),
        ("/rods/0/ends_m/1", 3.into()),
        ("/grasp/pick_eye", 1.into()),
    ] {
        let mut truth = truth.clone();
        *truth.pointer_mut(pointer).unwrap() = wrong;
        assert!(
            !faults(&schema, &schema, &truth, "truth").is_empty(),
            "{pointer}"
        );
    }
}

#[test]
fn result_is_as_its_schema_says() {
    let schema = schema("result");
    for more in [&["--json"][..], &["--json", "--pick", "20,250"]] {
        let answer: Value = serde_json::from_str(&solve(more).out).unwrap();
        assert_eq!(
            faults(&schema, &schema, &answer, "result"),
            Vec::<String>::new()
        );
    }
}
