//! Parts of the object that must have a number of markers: at least, at most, or both.

use fibar_core::artefact::sites::Sites;
use fibar_plugin::StageError;
use glam::DVec3;

/// A box along the axes of the body's frame, and how many markers belong in it.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// What it is called in messages.
    pub name: String,
    /// Least coordinates, mm; left out, there is no border that way.
    pub low_mm: Option<[f64; 3]>,
    /// Greatest coordinates, mm; left out, there is no border that way.
    pub high_mm: Option<[f64; 3]>,
    /// So many markers at least.
    #[serde(default)]
    pub at_least: u32,
    /// So many at most; left out, any number.
    pub at_most: Option<u32>,
}

impl Region {
    /// Whether a place lies in it, border included.
    pub fn contains(&self, place: DVec3) -> bool {
        self.low_mm.is_none_or(|low| place.cmpge(DVec3::from(low)).all())
            && self.high_mm.is_none_or(|high| place.cmple(DVec3::from(high)).all())
    }

    /// How many of `count` markers are too few or too many.
    fn off(&self, count: usize) -> usize {
        let most = self.at_most.map_or(usize::MAX, |most| most as usize);
        (self.at_least as usize).saturating_sub(count) + count.saturating_sub(most)
    }

    fn wish(&self) -> String {
        match (self.at_least, self.at_most) {
            (least, Some(most)) if least == most => format!("{least}"),
            (0, Some(most)) => format!("at most {most}"),
            (least, Some(most)) => format!("{least} to {most}"),
            (least, None) => format!("at least {least}"),
        }
    }
}

/// What the regions demand of themselves and of the number of markers.
pub fn check(regions: &[Region], markers: Option<u32>) -> Result<(), StageError> {
    for (k, region) in regions.iter().enumerate() {
        let blame = |message: String| Err(StageError::user(message).param(format!("/regions/{k}")));
        if region.at_most.is_some_and(|most| most < region.at_least) {
            return blame(format!("region {:?} cannot have {} markers", region.name, region.wish()));
        }
        if let Some(markers) = markers.filter(|markers| *markers < region.at_least) {
            return blame(format!(
                "region {:?} is to have {} of {markers} markers",
                region.name,
                region.wish()
            ));
        }
        let corners = [region.low_mm.unwrap_or([f64::MIN; 3]), region.high_mm.unwrap_or([f64::MAX; 3])];
        if (0..3).any(|axis| corners[0][axis] > corners[1][axis]) {
            return blame(format!("region {:?} has a low_mm above its high_mm", region.name));
        }
    }
    Ok(())
}

/// How many markers every region has, as markers come and go.
#[derive(Clone)]
pub struct Regions<'a> {
    regions: &'a [Region],
    /// By site: numbers of the regions that it lies in.
    of_site: std::sync::Arc<Vec<Vec<usize>>>,
    counts: Vec<usize>,
}

impl<'a> Regions<'a> {
    /// Without any marker.
    pub fn new(regions: &'a [Region], sites: &Sites) -> Regions<'a> {
        let of = |place: DVec3| (0..regions.len()).filter(|&r| regions[r].contains(place)).collect();
        let of_site = sites.sites.iter().map(|site| of(site.position)).collect::<Vec<_>>();
        Regions { regions, of_site: of_site.into(), counts: vec![0; regions.len()] }
    }

    /// Counts a marker that comes to a site or leaves it.
    pub fn count(&mut self, site: usize, comes: bool) {
        for &region in &self.of_site[site] {
            self.counts[region] = if comes { self.counts[region] + 1 } else { self.counts[region] - 1 };
        }
    }

    /// Whether one more marker at a site would be too many for a region.
    pub fn is_full_at(&self, site: usize) -> bool {
        self.of_site[site]
            .iter()
            .any(|&r| self.regions[r].at_most.is_some_and(|most| self.counts[r] >= most as usize))
    }

    /// How many markers are too few or too many, over all regions.
    pub fn off(&self) -> usize {
        self.regions.iter().zip(&self.counts).map(|(region, count)| region.off(*count)).sum()
    }

    /// An error that names a region with too few markers or too many, if there is one.
    pub fn check(&self) -> Result<(), StageError> {
        let wrong = (0..self.regions.len()).find(|&r| self.regions[r].off(self.counts[r]) > 0);
        let Some(r) = wrong else { return Ok(()) };
        let (region, found) = (&self.regions[r], self.counts[r]);
        let places = self.of_site.iter().filter(|regions| regions.contains(&r)).count();
        let message = format!(
            "region {:?} is to have {} markers, but the best choice found has {found}; {places} candidate places are in it",
            region.name,
            region.wish()
        );
        Err(StageError::user(message).param(format!("/regions/{r}")).hint(
            "make spacing_mm smaller here or in place-visibility, the region larger, or ask for other numbers",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::sites::Site;

    fn region(low_z: f64, at_least: u32, at_most: Option<u32>) -> Region {
        let low_mm = Some([-9.0, -9.0, low_z]);
        Region { name: "head".into(), low_mm, high_mm: None, at_least, at_most }
    }

    /// Regions of five sites at z = 0, 1, 2, 3, 4, with markers at some of them.
    #[track_caller]
    fn check_counts(regions: &[Region], markers: &[usize], off: usize, says: &str) {
        let site =
            |z: i32| Site { position: DVec3::Z * f64::from(z), normal: DVec3::Z, suitability_rad: 1.0 };
        let sites = Sites::new(DVec3::ZERO, (0..5).map(site).collect(), vec![]);
        let mut counted = Regions::new(regions, &sites);
        (0..5).for_each(|site| counted.count(site, true));
        (0..5).filter(|site| !markers.contains(site)).for_each(|site| counted.count(site, false));
        assert_eq!(counted.off(), off);
        let error = counted.check().err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains(says) && error.is_empty() == (off == 0), "{error:?} does not say {says:?}");
    }

    #[test]
    fn too_few_and_too_many_are_told() {
        let two_to_three = || [region(2.0, 2, Some(3))];
        check_counts(&two_to_three(), &[0, 1, 2, 3], 0, "");
        check_counts(
            &two_to_three(),
            &[0, 1, 3],
            1,
            "\"head\" is to have 2 to 3 markers, but the best choice found has 1; 3 candidate",
        );
        check_counts(&[region(1.0, 0, Some(2))], &[1, 2, 3, 4], 2, "at most 2");
        check_counts(&[region(1.0, 4, None)], &[0, 1, 2], 2, "at least 4");
        check_counts(&[region(1.0, 3, None), region(4.0, 1, Some(1))], &[1, 2, 3], 1, "to have 1 markers");
        check_counts(&[], &[], 0, "");
    }

    #[test]
    fn regions_that_contradict_themselves_are_refused() {
        let refused = |region: Region, says: &str| {
            let error = check(&[region], Some(6)).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        refused(region(0.0, 3, Some(2)), "cannot have 3 to 2 markers");
        refused(region(0.0, 7, None), "is to have at least 7 of 6 markers");
        let upside_down = Region { high_mm: Some([9.0, 9.0, -1.0]), ..region(0.0, 1, None) };
        refused(upside_down, "low_mm above its high_mm");
        assert!(check(&[region(0.0, 3, Some(3))], Some(6)).is_ok());
    }
}
