//! Colours: roles by what they are made of, LEDs and patterns by hue, shares by a scale.

use fibar_core::material::Role;

/// sRGB, 0 to 1.
pub type Colour = [f64; 3];

/// The paper behind a drawing.
pub const PAPER: Colour = [0.97, 0.97, 0.98];

/// Text and axes.
pub const INK: Colour = [0.13, 0.14, 0.17];

/// Lines that only guide the eye.
pub const FAINT: Colour = [0.82, 0.83, 0.85];

/// A hue per number: seven that are told apart on white (after Okabe & Ito 2008), then round again. LEDs count from 0.
pub fn hue(number: usize) -> Colour {
    const HUES: [Colour; 7] = [
        [0.84, 0.15, 0.16],
        [0.00, 0.45, 0.70],
        [0.00, 0.62, 0.45],
        [0.90, 0.62, 0.00],
        [0.55, 0.34, 0.76],
        [0.34, 0.71, 0.91],
        [0.80, 0.47, 0.65],
    ];
    HUES[number % HUES.len()]
}

/// What a role looks like where a plane cuts it.
pub fn role(role: Role) -> Colour {
    let [red, green, blue, _] = role.material().colour_srgba;
    [red, green, blue].map(|c| f64::from(c) / 255.0)
}

/// Dark violet 0, teal in between, yellow 1; even in brightness (three stops of viridis, van der Walt & Smith 2015).
pub fn scale(share: f64) -> Colour {
    const STOPS: [Colour; 3] = [[0.27, 0.0, 0.33], [0.13, 0.57, 0.55], [0.99, 0.91, 0.14]];
    let position = share.clamp(0.0, 1.0) * 2.0;
    let (low, part) = if position < 1.0 { (0, position) } else { (1, position - 1.0) };
    mix(STOPS[low + 1], STOPS[low], part)
}

/// `a` where `share` is 1, `b` where it is 0.
pub fn mix(a: Colour, b: Colour, share: f64) -> Colour {
    std::array::from_fn(|k| a[k] * share + b[k] * (1.0 - share))
}

/// A colour under light from the viewer: `facing` is 1 where the surface is turned to them, 0 at its rim.
pub fn shade(colour: Colour, facing: f64) -> Colour {
    colour.map(|c| c * (0.35 + 0.65 * facing))
}
