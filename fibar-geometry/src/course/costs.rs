//! What a course costs at its nodes: lost light, and soft limits on bend, wall and speed.

use super::nodes::{Node, Pull};
use crate::optics::Absorption;
use crate::room::Room;
use glam::DVec3;

/// Weights and limits of the soft costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest curvature, 1/mm.
    pub curvature: f64,
    /// Kept from walls beyond what the room asks, mm.
    pub wall_margin: f64,
    /// Cost per mm of length and mm² of lacking room.
    pub wall_weight: f64,
    /// Cost per mm of length and unit of squared relative excess of curvature.
    pub bend_weight: f64,
    /// Cost of uneven speed, which light does not see.
    pub speed_weight: f64,
}

/// Lost light `∫a ds` and the sum of what broken limits cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// `∫a ds`.
    pub loss: f64,
    /// Broken limits.
    pub penalty: f64,
}

/// Costs of a course by its nodes; the derivatives are written to `pulls`, one for each node, `pulls` cleared before.
pub fn of_nodes(
    nodes: &[Node],
    absorption: &Absorption,
    room: Option<(&Room, &Watch)>,
    limits: &Limits,
    pulls: &mut Vec<Pull>,
) -> Cost {
    pulls.clear();
    pulls.resize(nodes.len(), Pull::default());
    let mut cost = Cost::default();
    for (node, pull) in nodes.iter().zip(pulls.iter_mut()) {
        let here = of_bend(node, absorption, limits, pull);
        cost.loss += here.loss;
        cost.penalty += here.penalty;
    }
    cost.penalty += of_speed(nodes, limits, pulls);
    if let Some((room, watch)) = room {
        cost.penalty += of_walls(nodes, room, watch, limits, pulls);
    }
    cost
}

/// Lost light `∫a ds` of a course by its nodes.
pub fn loss(nodes: &[Node], absorption: &Absorption) -> f64 {
    nodes.iter().fold(0.0, |sum, Node { velocity: v, acceleration: a, weight, .. }| {
        let speed = v.length().max(1e-9);
        sum + weight * speed * absorption.per_mm(v.cross(*a).length() / (speed * speed * speed))
    })
}

/// Lost light at a node, and the cost of bending too tightly there.
fn of_bend(node: &Node, absorption: &Absorption, limits: &Limits, pull: &mut Pull) -> Cost {
    const SLOWEST: f64 = 1e-9;
    let Node { velocity: v, acceleration: a, weight, .. } = *node;
    let speed = v.length().max(SLOWEST);
    let cross = v.cross(a);
    let area = cross.length();
    let cube = speed * speed * speed;
    let curvature = area / cube;
    let (absorbed, rise) = absorption.with_slope(curvature);
    let excess = (curvature / limits.curvature - 1.0).max(0.0);
    let (bend, bend_rise) =
        (limits.bend_weight * excess * excess, 2.0 * limits.bend_weight * excess / limits.curvature);
    let along = v / speed;
    pull.velocity += weight * (absorbed + bend) * along;
    if area > 0.0 {
        let unit = cross / area;
        let slope = weight * speed * (rise + bend_rise);
        pull.velocity += slope * (a.cross(unit) / cube - 3.0 * curvature / speed * along);
        pull.acceleration += slope * unit.cross(v) / cube;
    }
    Cost { loss: weight * speed * absorbed, penalty: weight * speed * bend }
}

/// Cost of bending too tightly at single places; the derivatives are written to `pulls`, one for each, cleared before.
pub fn of_bends(places: &[Node], limits: &Limits, pulls: &mut Vec<Pull>) -> f64 {
    const STANDS_FOR_MM: f64 = 2.0;
    pulls.clear();
    pulls.resize(places.len(), Pull::default());
    let mut cost = 0.0;
    for (Node { velocity: v, acceleration: a, .. }, pull) in places.iter().zip(pulls) {
        let speed = v.length().max(1e-9);
        let cross = v.cross(*a);
        let (area, cube) = (cross.length(), speed * speed * speed);
        let curvature = area / cube;
        let excess = curvature / limits.curvature - 1.0;
        if excess <= 0.0 {
            continue;
        }
        cost += STANDS_FOR_MM * limits.bend_weight * excess * excess;
        let slope = 2.0 * STANDS_FOR_MM * limits.bend_weight * excess / limits.curvature;
        let unit = cross / area;
        pull.velocity = slope * (a.cross(unit) / cube - 3.0 * curvature / (speed * speed) * *v);
        pull.acceleration = slope * unit.cross(*v) / cube;
    }
    cost
}

/// `Σ w (s − S)²/S²`, S the length: the nodes stay where they can see.
fn of_speed(nodes: &[Node], limits: &Limits, pulls: &mut [Pull]) -> f64 {
    let length = nodes.iter().fold(0.0, |sum, n| sum + n.weight * n.velocity.length()).max(1e-9);
    let square = nodes.iter().fold(0.0, |sum, n| sum + n.weight * n.velocity.length_squared());
    let ratio = square / (length * length);
    for (node, pull) in nodes.iter().zip(pulls) {
        let along = node.velocity.normalize_or_zero();
        let slope = 2.0 * node.weight * (node.velocity / (length * length) - ratio / length * along);
        pull.velocity += limits.speed_weight * slope;
    }
    limits.speed_weight * (ratio - 1.0)
}

/// Where room is watched along a course: at its nodes, and at places between them where it was found lacking.
///
/// The errors of the room's samples, which edges of the body make large, are held while the course is moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Watch {
    /// By how much sampled slack exceeds the exact one at the nodes, mm.
    errors: Vec<f64>,
    between: Vec<Between>,
}

/// A place between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Between {
    /// The node after.
    after: usize,
    /// How far from the node before, 0 to 1.
    share: f64,
    /// As of the nodes, mm.
    error: f64,
}

impl Watch {
    /// Watches the nodes, and the places of these parameters.
    pub fn over(nodes: &[Node], room: &Room, parameters: &[f64]) -> Watch {
        let errors = nodes.iter().map(|node| sampling_error(room, node.position)).collect();
        let between = parameters.iter().map(|parameter| Between::at(nodes, room, *parameter)).collect();
        Watch { errors, between }
    }
}

impl Between {
    fn at(nodes: &[Node], room: &Room, parameter: f64) -> Between {
        let after = nodes.partition_point(|node| node.parameter < parameter).clamp(1, nodes.len() - 1);
        let (before, beyond) = (nodes[after - 1].parameter, nodes[after].parameter);
        let share = ((parameter - before) / (beyond - before)).clamp(0.0, 1.0);
        let place = nodes[after - 1].position.lerp(nodes[after].position, share);
        Between { after, share, error: sampling_error(room, place) }
    }
}

/// By how much sampled slack exceeds the exact one, mm; not looked at where there is plenty.
fn sampling_error(room: &Room, place: DVec3) -> f64 {
    const PLENTY: f64 = 1.5;
    if room.surely_has(place, PLENTY + 1e-9) {
        return 0.0;
    }
    let sampled = room.slack(place).0;
    if sampled > PLENTY { 0.0 } else { sampled - room.exact_slack(place, PLENTY + 1.0) }
}

/// Cost of lacking room.
fn of_walls(nodes: &[Node], room: &Room, watch: &Watch, limits: &Limits, pulls: &mut [Pull]) -> f64 {
    const STANDS_FOR_MM: f64 = 1.0;
    let gates = Gates::of(nodes, room);
    let mut cost = 0.0;
    for (k, error) in watch.errors.iter().enumerate() {
        let node = &nodes[k];
        let speed = node.velocity.length();
        let needed = limits.wall_margin + error;
        let lack = gates.lack(node.position, room, needed, limits.wall_weight * node.weight);
        cost += speed * lack.cost;
        pulls[k].position += speed * lack.slope;
        pulls[k].velocity += lack.cost * node.velocity.normalize_or_zero();
    }
    for Between { after, share, error } in watch.between.iter().copied() {
        let place = nodes[after - 1].position.lerp(nodes[after].position, share);
        let weight = limits.wall_weight * STANDS_FOR_MM;
        let lack = gates.lack(place, room, limits.wall_margin + error, weight);
        pulls[after - 1].position += (1.0 - share) * lack.slope;
        pulls[after].position += share * lack.slope;
        cost += lack.cost;
    }
    cost
}

/// The ends, about which room may lack: as much as the way out to where it counts could make good, 1 mm per mm.
struct Gates {
    ends: [(DVec3, f64); 2],
}

/// What lacking room costs at a place, and its derivative by the place.
struct Lack {
    cost: f64,
    slope: DVec3,
}

impl Gates {
    fn of(nodes: &[Node], room: &Room) -> Gates {
        const SHORTER_THAN_ARC: f64 = 0.15; // mm, by which a bent leg's chord may be
        let (first, last) = (&nodes[0], &nodes[nodes.len() - 1]);
        // The nodes next to the ends are within a fifteenth of a span of them.
        let start = first.position - first.parameter * first.velocity;
        let end = last.position + (1.0 - last.parameter) * last.velocity;
        let reach = [room.exempt_start(), room.exempt_end()].map(|arc| arc - SHORTER_THAN_ARC);
        Gates { ends: [(start, reach[0]), (end, reach[1])] }
    }

    fn lack(&self, place: DVec3, room: &Room, needed: f64, weight: f64) -> Lack {
        if room.surely_has(place, needed) {
            return Lack { cost: 0.0, slope: DVec3::ZERO };
        }
        let (slack, gradient) = room.slack(place);
        let (mut lack, mut slope) = (needed - slack, -gradient);
        if lack <= 0.0 {
            return Lack { cost: 0.0, slope: DVec3::ZERO };
        }
        for (end, reach) in self.ends {
            let way = place - end;
            let length = way.length();
            if length < reach {
                lack -= reach - length;
                slope += way / length.max(1e-9);
            }
        }
        let lack = lack.max(0.0);
        Lack { cost: weight * lack * lack, slope: 2.0 * weight * lack * slope }
    }
}
