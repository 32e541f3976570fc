//! Colours: roles by what they are made of, LEDs by hue.

use fibar_core::LedId;
use fibar_core::material::Role;

/// sRGB, 0 to 1.
pub type Colour = [f64; 3];

/// The paper behind the object.
pub const BACKGROUND: Colour = [0.97, 0.97, 0.98];

/// What a role looks like where the plane cuts it; cores are painted by LED instead.
pub fn role_colour(role: Role) -> Colour {
    let [red, green, blue, _] = role.material().colour_srgba;
    [red, green, blue].map(|c| f64::from(c) / 255.0)
}

/// The LED's hue: seven that are told apart on white (after Okabe & Ito 2008), then round again.
pub fn led_colour(led: LedId) -> Colour {
    const HUES: [Colour; 7] = [
        [0.84, 0.15, 0.16],
        [0.00, 0.45, 0.70],
        [0.00, 0.62, 0.45],
        [0.90, 0.62, 0.00],
        [0.55, 0.34, 0.76],
        [0.34, 0.71, 0.91],
        [0.80, 0.47, 0.65],
    ];
    HUES[led.0 as usize % HUES.len()]
}

/// `a` where `share` is 1, `b` where it is 0.
pub fn mix(a: Colour, b: Colour, share: f64) -> Colour {
    std::array::from_fn(|k| a[k] * share + b[k] * (1.0 - share))
}
