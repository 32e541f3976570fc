//! What became of a mesh: everything the repair changed, counted.

/// Counts, areas mm², volumes mm³, lengths mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fate {
    /// Vertices that shared a place with an earlier one.
    pub vertices_welded: usize,
    /// Triangles with a corner twice.
    pub degenerate_removed: usize,
    /// Triangles that stood twice or back to back.
    pub duplicates_removed: usize,
    /// Vertices of rims that became a near one.
    pub vertices_sewn: usize,
    /// Sides divided where a rim's vertex lay on them.
    pub sides_divided: usize,
    /// Triangles turned to agree with their neighbours.
    pub triangles_turned: usize,
    /// Triangles of inner walls and flaps.
    pub walls_removed: usize,
    /// Holes closed.
    pub holes_closed: usize,
    /// Outlines of sheets that got walls and a flat back.
    pub backs_added: usize,
    /// Area of the caps, walls and backs.
    pub cap_area: f64,
    /// Shells of the closed surface, cavities included.
    pub shells: usize,
    /// Bodies among them.
    pub bodies: usize,
    /// Bodies that were left after what overlaps was united.
    pub bodies_left: usize,
    /// Shells that were inside out.
    pub shells_turned: usize,
    /// Shells that enclosed nothing.
    pub flat_shells_removed: usize,
    /// Pairs of triangles that crossed.
    pub crossings: usize,
    /// Places where a shell passed through itself, taken apart.
    pub tangles_parted: usize,
    /// Such places cut away.
    pub tangles_cut: usize,
    /// Greatest distance that anything of the surface moved.
    pub displacement: f64,
    /// Volume before bodies were united: what they share counts twice.
    pub volume_before: f64,
}

impl Fate {
    /// Name, value and unit of every figure.
    pub fn metrics(&self) -> Vec<(&'static str, f64, &'static str)> {
        let counts = [
            ("repair.vertices_welded", self.vertices_welded),
            ("repair.degenerate_removed", self.degenerate_removed),
            ("repair.duplicates_removed", self.duplicates_removed),
            ("repair.vertices_sewn", self.vertices_sewn),
            ("repair.sides_divided", self.sides_divided),
            ("repair.triangles_turned", self.triangles_turned),
            ("repair.walls_removed", self.walls_removed),
            ("repair.holes_closed", self.holes_closed),
            ("repair.backs_added", self.backs_added),
            ("repair.shells", self.shells),
            ("repair.bodies", self.bodies),
            ("repair.bodies_left", self.bodies_left),
            ("repair.shells_turned", self.shells_turned),
            ("repair.flat_shells_removed", self.flat_shells_removed),
            ("repair.crossings", self.crossings),
            ("repair.tangles_parted", self.tangles_parted),
            ("repair.tangles_cut", self.tangles_cut),
        ];
        let sizes = [
            ("repair.cap_area_mm2", self.cap_area, "mm2"),
            ("repair.displacement_mm", self.displacement, "mm"),
            ("repair.volume_before_mm3", self.volume_before, "mm3"),
        ];
        counts.into_iter().map(|(name, count)| (name, count as f64, "1")).chain(sizes).collect()
    }

    /// What a user should know about, a sentence each; empty if only duplicates of places were welded.
    pub fn changes(&self) -> Vec<String> {
        let counted = [
            (self.degenerate_removed, "triangles without area removed"),
            (self.duplicates_removed, "triangles that stood twice or back to back removed"),
            (self.vertices_sewn, "vertices of rims sewn to a near one"),
            (self.sides_divided, "sides divided where a neighbour's corner lay on them"),
            (self.triangles_turned, "triangles turned to agree with their neighbours"),
            (self.walls_removed, "triangles of inner walls and flaps removed"),
            (self.holes_closed, "holes closed"),
            (self.backs_added, "sheets, seen from one side only, given walls and a flat back"),
            (self.shells_turned, "shells turned that were inside out"),
            (self.flat_shells_removed, "shells removed that enclosed nothing"),
            (self.tangles_parted, "places parted where a shell passed through itself"),
            (self.tangles_cut, "places cut away where a shell passed through itself"),
        ];
        let noted = counted.into_iter().filter(|(count, _)| *count > 0);
        let mut changes: Vec<String> = noted.map(|(count, what)| format!("{count} {what}")).collect();
        if self.bodies_left > 0 && self.bodies_left != self.bodies {
            let [before, after] = [self.bodies, self.bodies_left];
            changes.push(format!("bodies before and after: {before} and {after}; what overlaps was united, what lies within another is part of it"));
        }
        changes
    }
}
