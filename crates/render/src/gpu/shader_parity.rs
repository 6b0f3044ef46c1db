//! Every function of `shaders/lib` over a grid on the adapter, against its twin in `f64`.

mod rows;

use std::collections::BTreeSet;

use rodsight_shaders::LIB;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::device::{AdapterChoice, Gpu};
use super::tile::bind_group;
use crate::RenderError;

type Twin = dyn Fn(&[f64]) -> Vec<f64>;

/// One function on the grid of its inputs.
struct Row {
    name: &'static str,
    /// WGSL that reads `x(k)` (or `u(k)`, its bits) and gives `y(k, value)`.
    body: &'static str,
    /// The inputs, each row as many.
    inputs: Vec<Vec<f32>>,
    /// The same in `f64`.
    twin: Box<Twin>,
    /// Largest error of a value: relative to it, and absolute.
    relative: f64,
    absolute: f64,
    /// Where the tolerance is from.
    bounded_by: &'static str,
}

const FRAME: &str = "
@group(0) @binding(0) var<storage, read_write> outputs: array<u32>;
@group(0) @binding(1) var<storage, read> inputs: array<u32>;
var<private> row: u32;
fn u(k: u32) -> u32 { return inputs[row * INPUTS + k]; }
fn x(k: u32) -> f32 { return bitcast<f32>(u(k)); }
fn v(k: u32) -> vec3<f32> { return vec3<f32>(x(k), x(k + 1u), x(k + 2u)); }
fn y(k: u32, value: f32) { outputs[row * OUTPUTS + k] = bitcast<u32>(value); }
fn w(k: u32, value: vec3<f32>) { y(k, value.x); y(k + 1u, value.y); y(k + 2u, value.z); }
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    row = id.x;
    if row >= ROWS { return; }
";

/// The function's values on the adapter.
fn run(device: &Gpu, row: &Row, outputs: usize) -> Vec<f32> {
    let (rows, inputs) = (row.inputs.len(), row.inputs[0].len());
    let library: String = LIB.iter().map(|part| part.text).collect();
    let source = format!(
        "{library}const ROWS = {rows}u;\nconst INPUTS = {inputs}u;\nconst OUTPUTS = {outputs}u;\n{FRAME}{}\n}}\n",
        row.body
    );
    let d = &device.device;
    let bytes: Vec<u8> = row
        .inputs
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let given = d.create_buffer_init(&BufferInitDescriptor {
        label: Some("inputs"),
        contents: &bytes,
        usage: wgpu::BufferUsages::STORAGE,
    });
    let buffer = |size, usage| {
        d.create_buffer(&wgpu::BufferDescriptor {
            label: Some(row.name),
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let size = (rows * outputs * 4) as u64;
    let found = buffer(
        size,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let back = buffer(
        size,
        wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
    );
    let values = device.watched(|| {
        let module = d.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(row.name),
            source: wgpu::ShaderSource::Wgsl(source.as_str().into()),
        });
        let pipeline = d.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(row.name),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let group = bind_group(
            d,
            row.name,
            &pipeline.get_bind_group_layout(0),
            &[&found, &given],
        );
        let mut encoder = d.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(rows.div_ceil(64) as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&found, 0, &back, 0, size);
        let submission = device.queue.submit([encoder.finish()]);
        back.map_async(wgpu::MapMode::Read, .., |result| {
            result.expect("it can be mapped");
        });
        device.wait(submission)?;
        let view = back
            .get_mapped_range(..)
            .map_err(|error| device.error(error.to_string()))?;
        let (words, _) = view.as_chunks::<4>();
        Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    });
    values.unwrap_or_else(|error| panic!("{}: {error}", row.name))
}

/// The largest error over its tolerance, and where.
fn worst(row: &Row, actual: &[f32], expected: &[Vec<f64>]) -> (f64, String) {
    let outputs = expected[0].len();
    let mut worst = (0.0, "no difference".to_owned());
    for (i, (actual, expected)) in actual.chunks(outputs).zip(expected).enumerate() {
        for (k, (&a, &e)) in actual.iter().zip(expected).enumerate() {
            let error = (f64::from(a) - e).abs();
            let off = match error / (row.relative * e.abs() + row.absolute) {
                _ if error == 0.0 => 0.0,
                off if off.is_nan() => f64::INFINITY,
                off => off,
            };
            if off > worst.0 {
                let place = format!("output {k} of {:?}: {a} instead of {e}", row.inputs[i]);
                worst = (off, place);
            }
        }
    }
    worst
}

#[test]
fn library_functions_agree_with_their_twins() {
    let device = match Gpu::new(AdapterChoice::HardwareOrSoftware) {
        Ok(device) => device,
        Err(error @ RenderError::NoAdapter { .. })
            if std::env::var("RODSIGHT_REQUIRE_GPU").as_deref() != Ok("1") =>
        {
            println!("SKIPPED: {error}");
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let mut faults = Vec::new();
    let rows = rows::all();
    for row in &rows {
        assert!(
            row.body.contains(&format!("{}(", row.name)),
            "{} is not called",
            row.name
        );
        let expected: Vec<Vec<f64>> = row
            .inputs
            .iter()
            .map(|inputs| (row.twin)(&inputs.iter().map(|v| f64::from(*v)).collect::<Vec<_>>()))
            .collect();
        let actual = run(&device, row, expected[0].len());
        let (off, place) = worst(row, &actual, &expected);
        println!(
            "{:34} {:6} values, {off:.3} of {:.0e} + {:.0e} ({})",
            row.name,
            actual.len(),
            row.relative,
            row.absolute,
            row.bounded_by
        );
        if !(off <= 1.0) {
            faults.push(format!("{}: {off:.3e} of its tolerance: {place}", row.name));
        }
        // A wrong value is found.
        let mut wrong = actual.clone();
        let middle = wrong.len() / 2;
        wrong[middle] += 1e-2 * wrong[middle].abs() + 1e-1;
        assert!(
            worst(row, &wrong, &expected).0 > 1.0,
            "{}: its tolerance passes anything",
            row.name
        );
        wrong[middle] = f32::NAN;
        let (off, _) = worst(row, &wrong, &expected);
        assert!(off > 1.0, "{}: NaN passes", row.name);
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_library_function_has_a_row() {
    let functions: BTreeSet<&str> = LIB
        .iter()
        .flat_map(|part| part.text.lines())
        .filter_map(|line| line.strip_prefix("fn ")?.split('(').next())
        .collect();
    let rows = rows::all();
    let tested: BTreeSet<&str> = rows.iter().map(|row| row.name).collect();
    assert_eq!(tested.len(), rows.len(), "a function has two rows");
    assert_eq!(tested, functions);
}
