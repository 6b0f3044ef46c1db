//! The WGSL of the renderer: pure functions in `lib/`, the twins of `f64` functions of the same names in Rust, and the passes that
//! call them in `pass/`.
//!
//! A [`Pass`] is a list of files joined in order, nothing else: no preprocessor, no imports. [`Pass::locate`] takes a line of the
//! joined text back to its file, so that a compiler's message can name it. This crate knows no graphics library.

/// A file of WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name below `shaders/`.
    pub file: &'static str,
    /// Its text, ending in a line break.
    pub text: &'static str,
}

/// A compute shader: files joined in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// The name of its entry point.
    pub name: &'static str,
    /// Its files.
    pub parts: &'static [Part],
}

macro_rules! part {
    ($file:literal) => {
        Part {
            file: $file,
            text: include_str!(concat!("../", $file)),
        }
    };
}

/// Elementary functions.
pub const MATHS: Part = part!("lib/maths.wgsl");
/// Places of samples.
pub const LATTICE: Part = part!("lib/lattice.wgsl");
/// Pixels and rays; needs [`MATHS`].
pub const CAMERA: Part = part!("lib/camera.wgsl");
/// Glass before a camera.
pub const PORT: Part = part!("lib/port.wgsl");
/// Cylinders.
pub const SOLID: Part = part!("lib/solid.wgsl");
/// Axes of rods; needs [`MATHS`].
pub const ARC: Part = part!("lib/arc.wgsl");
/// Stripes and grain; needs [`LATTICE`] and [`ARC`].
pub const FINISH: Part = part!("lib/finish.wgsl");
/// Coats.
pub const GLOSS: Part = part!("lib/gloss.wgsl");
/// Balls and cubes; needs [`SOLID`].
pub const LUMP: Part = part!("lib/lump.wgsl");
/// Triangles; needs [`SOLID`].
pub const TRIANGLES: Part = part!("lib/triangles.wgsl");
/// Places in images.
pub const TEXTURE: Part = part!("lib/texture.wgsl");
/// Boxes.
pub const BVH: Part = part!("lib/bvh.wgsl");
/// The floor's texture and ripples; needs [`MATHS`], [`LATTICE`] and [`SOLID`].
pub const SEABED: Part = part!("lib/seabed.wgsl");
/// Transmission.
pub const MEDIUM: Part = part!("lib/medium.wgsl");
/// Phase functions.
pub const PHASE: Part = part!("lib/phase.wgsl");
/// Lamps.
pub const LIGHT: Part = part!("lib/light.wgsl");
/// The quadrature of the airlight; needs [`MATHS`].
pub const AIRLIGHT: Part = part!("lib/airlight.wgsl");
/// The table of the airlight.
pub const AIRLIGHT_GRID: Part = part!("lib/airlight_grid.wgsl");
/// Shadows in the water; needs [`SOLID`].
pub const SHADOW: Part = part!("lib/shadow.wgsl");
/// Soft shadows; needs [`SOLID`].
pub const PENUMBRA: Part = part!("lib/penumbra.wgsl");
/// Daylight; needs [`MATHS`] and [`MEDIUM`].
pub const DAYLIGHT: Part = part!("lib/daylight.wgsl");
/// Pixels under discs; needs [`MATHS`].
pub const DISC: Part = part!("lib/disc.wgsl");
/// Matt spheres; needs [`MATHS`].
pub const SPHERE: Part = part!("lib/sphere.wgsl");
/// Light scattered forwards; needs [`MATHS`] and [`MEDIUM`].
pub const HALO: Part = part!("lib/halo.wgsl");

/// Random numbers by counter.
pub const NOISE: Part = part!("lib/noise.wgsl");
/// The transfer function of sRGB.
pub const SRGB: Part = part!("lib/srgb.wgsl");
/// Vignetting; needs [`CAMERA`].
pub const LENS: Part = part!("lib/lens.wgsl");
/// Colour filters.
pub const BAYER: Part = part!("lib/bayer.wgsl");
/// Photons to codes; needs [`NOISE`].
pub const EMVA: Part = part!("lib/emva.wgsl");

/// Every file of pure functions.
pub const LIB: &[Part] = &[
    MATHS,
    LATTICE,
    CAMERA,
    PORT,
    SOLID,
    ARC,
    FINISH,
    GLOSS,
    LUMP,
    TRIANGLES,
    TEXTURE,
    BVH,
    SEABED,
    MEDIUM,
    PHASE,
    LIGHT,
    AIRLIGHT,
    AIRLIGHT_GRID,
    SHADOW,
    PENUMBRA,
    DAYLIGHT,
    DISC,
    SPHERE,
    HALO,
    NOISE,
    SRGB,
    LENS,
    BAYER,
    EMVA,
];

const SCENE: Part = part!("pass/scene.wgsl");
const EYE: Part = part!("pass/eye.wgsl");
const CONTENT: Part = part!("pass/content.wgsl");
const WATER: Part = part!("pass/water.wgsl");
const LOOPS: Part = part!("pass/loops.wgsl");
const TILE: Part = part!("pass/tile.wgsl");
const SNOW: Part = part!("pass/snow.wgsl");
const HALO_LEVELS: Part = part!("pass/halo.wgsl");
const HALO_IMAGE: Part = part!("pass/halo_image.wgsl");
const HALO_BLUR: Part = part!("pass/halo_blur.wgsl");
const BEYOND: Part = part!("pass/beyond.wgsl");
const FILM: Part = part!("pass/film.wgsl");
const METER: Part = part!("pass/meter.wgsl");
const CHIP: Part = part!("pass/chip.wgsl");

/// What every pass that casts rays is made of, and more.
macro_rules! casting {
    ($($more:expr),+ $(,)?) => {
        &[
            MATHS,
            LATTICE,
            CAMERA,
            PORT,
            SOLID,
            ARC,
            FINISH,
            GLOSS,
            LUMP,
            TRIANGLES,
            TEXTURE,
            BVH,
            SEABED,
            MEDIUM,
            DAYLIGHT,
            LIGHT,
            SHADOW,
            PENUMBRA,
            HALO,
            SCENE,
            CONTENT,
            EYE,
            $($more),+
        ]
    };
}

/// One ray a pixel.
pub const CENTRE: Pass = Pass {
    name: "centre",
    parts: casting![LOOPS, TILE, part!("pass/centre.wgsl")],
};

/// The light of the water.
pub const BACKSCATTER: Pass = Pass {
    name: "backscatter",
    parts: casting![
        PHASE,
        AIRLIGHT,
        AIRLIGHT_GRID,
        WATER,
        LOOPS,
        TILE,
        part!("pass/backscatter.wgsl"),
    ],
};

/// The list of pixels at edges.
pub const MARK: Pass = Pass {
    name: "mark",
    parts: &[LOOPS, TILE, part!("pass/mark.wgsl")],
};

/// All samples of pixels at edges.
pub const REFINE: Pass = Pass {
    name: "refine",
    parts: casting![
        PHASE,
        AIRLIGHT,
        AIRLIGHT_GRID,
        WATER,
        LOOPS,
        TILE,
        part!("pass/refine.wgsl"),
    ],
};

/// The light of particles of snow.
pub const FLAKES: Pass = Pass {
    name: "light_flakes",
    parts: casting![SPHERE, LOOPS, TILE, SNOW, part!("pass/flakes.wgsl"),],
};

/// Snow before surfaces.
pub const COMPOSE: Pass = Pass {
    name: "compose",
    parts: casting![
        PHASE,
        AIRLIGHT,
        AIRLIGHT_GRID,
        DISC,
        SPHERE,
        WATER,
        LOOPS,
        TILE,
        SNOW,
        part!("pass/compose.wgsl"),
    ],
};

/// The light of a tile's pixels by the widths of the halo.
pub const WEIGH: Pass = Pass {
    name: "weigh",
    parts: &[
        MATHS,
        MEDIUM,
        HALO,
        LOOPS,
        TILE,
        SNOW,
        HALO_LEVELS,
        HALO_IMAGE,
        part!("pass/weigh.wgsl"),
    ],
};

/// The light around the image.
pub const OVERSCAN: Pass = Pass {
    name: "overscan",
    parts: casting![
        LOOPS,
        HALO_LEVELS,
        HALO_IMAGE,
        BEYOND,
        part!("pass/overscan.wgsl"),
    ],
};

/// The light beyond that.
pub const FAR: Pass = Pass {
    name: "far",
    parts: casting![
        LOOPS,
        HALO_LEVELS,
        HALO_IMAGE,
        BEYOND,
        part!("pass/far.wgsl"),
    ],
};

/// Means over cells.
pub const GATHER: Pass = Pass {
    name: "gather",
    parts: &[
        MATHS,
        MEDIUM,
        HALO,
        LOOPS,
        HALO_LEVELS,
        HALO_IMAGE,
        part!("pass/gather.wgsl"),
    ],
};

/// A Gaussian, along rows.
pub const BLUR_ROWS: Pass = Pass {
    name: "blur_rows",
    parts: &[HALO_LEVELS, HALO_BLUR, part!("pass/blur_rows.wgsl")],
};

/// A Gaussian, along columns.
pub const BLUR_COLUMNS: Pass = Pass {
    name: "blur_columns",
    parts: &[
        MATHS,
        MEDIUM,
        HALO,
        HALO_LEVELS,
        HALO_BLUR,
        part!("pass/blur_columns.wgsl"),
    ],
};

/// The light of a tile, for its image.
pub const COLLECT: Pass = Pass {
    name: "collect",
    parts: &[MATHS, CAMERA, FILM, LOOPS, TILE, part!("pass/collect.wgsl")],
};

/// The halo and the lens's vignetting.
pub const THROUGH_LENS: Pass = Pass {
    name: "lens",
    parts: &[MATHS, CAMERA, LENS, FILM, part!("pass/lens.wgsl")],
};

/// The lens's blur, along one direction.
pub const SMEAR: Pass = Pass {
    name: "smear",
    parts: &[MATHS, CAMERA, FILM, part!("pass/smear.wgsl")],
};

/// Counts samples of light.
pub const TALLY: Pass = Pass {
    name: "tally",
    parts: &[MATHS, CAMERA, FILM, METER, part!("pass/tally.wgsl")],
};

/// Finds one by its rank.
pub const RANK: Pass = Pass {
    name: "rank",
    parts: &[METER, part!("pass/rank.wgsl")],
};

/// Light to the converter's codes.
pub const SENSE: Pass = Pass {
    name: "sense",
    parts: &[
        MATHS,
        CAMERA,
        NOISE,
        BAYER,
        EMVA,
        FILM,
        CHIP,
        part!("pass/sense.wgsl"),
    ],
};

/// Codes to the image.
pub const PRINT: Pass = Pass {
    name: "print",
    parts: &[
        MATHS,
        CAMERA,
        NOISE,
        SRGB,
        BAYER,
        EMVA,
        FILM,
        CHIP,
        part!("pass/print.wgsl"),
    ],
};

/// Every pass.
pub const PASSES: &[Pass] = &[
    CENTRE,
    BACKSCATTER,
    MARK,
    REFINE,
    FLAKES,
    COMPOSE,
    WEIGH,
    OVERSCAN,
    FAR,
    GATHER,
    BLUR_ROWS,
    BLUR_COLUMNS,
    COLLECT,
    THROUGH_LENS,
    SMEAR,
    TALLY,
    RANK,
    SENSE,
    PRINT,
];

impl Pass {
    /// The joined text.
    pub fn source(&self) -> String {
        self.parts.iter().map(|part| part.text).collect()
    }

    /// The file and line, counted from 1, of a line of the joined text; `None` beyond its end.
    pub fn locate(&self, line: usize) -> Option<(&'static str, usize)> {
        let mut left = line.checked_sub(1)?;
        for part in self.parts {
            let lines = part.text.lines().count();
            if left < lines {
                return Some((part.file, left + 1));
            }
            left -= lines;
        }
        None
    }
}
