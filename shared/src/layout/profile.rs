//! What a campaign measures: mass lines above the suspension modes, or these modes themselves.

/// The profile of a measurement: which band the records are made for, and so how they are taken and solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum TestProfile {
    /// Records of half a second at the full rate; mass lines above the suspension modes.
    #[default]
    MassLine,
    /// Records of forty seconds, decimated; the suspension modes.
    Suspension,
}

impl TestProfile {
    /// Every profile.
    pub const ALL: [Self; 2] = [Self::MassLine, Self::Suspension];

    /// Their names in files, reports and options.
    pub const NAMES: [&'static str; 2] = [Self::MassLine.name(), Self::Suspension.name()];

    /// The name in files, reports and options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::MassLine => "mass-line",
            Self::Suspension => "suspension",
        }
    }

    /// The profile of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_profile_is_read_as_that_profile() {
        for profile in TestProfile::ALL {
            assert_eq!(TestProfile::from_name(profile.name()), Some(profile));
        }
        assert_eq!(TestProfile::from_name("modal"), None);
    }
}
