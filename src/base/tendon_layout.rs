//! Which tendons bend which part of a robot, and where they lie around it.

/// Tendons of a robot, sorted by the part of the backbone that they bend.
#[derive(Clone, Debug, PartialEq)]
pub struct TendonLayout {
    /// The segments from base to tip: the tendons that end where the segment ends.
    pub segments: Vec<Vec<PlacedTendon>>,
}

/// A tendon and where it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedTendon {
    /// Its number, from 0.
    pub tendon: usize,
    /// Its angle from x towards y, degrees.
    pub angle_deg: f64,
}

impl TendonLayout {
    /// One segment with `tendons` tendons evenly around it.
    pub fn ring(tendons: usize) -> TendonLayout {
        let place = |tendon: usize| PlacedTendon {
            tendon,
            angle_deg: 360.0 * tendon as f64 / tendons as f64,
        };
        TendonLayout { segments: vec![(0..tendons).map(place).collect()] }
    }

    /// Refuses tendons that cannot bend a segment both ways: tendons only pull.
    ///
    /// # Errors
    /// The number of the segment, from 1, and its tendons in words.
    pub fn check(&self) -> Result<(), String> {
        for (index, tendons) in self.segments.iter().enumerate() {
            if !bends_both_ways(tendons) {
                let angles: Vec<String> =
                    tendons.iter().map(|placed| format!("{}°", placed.angle_deg)).collect();
                let (number, angles) = (index + 1, angles.join(", "));
                return Err(format!("segment {number} with tendons on one side only ({angles})"));
            }
        }
        Ok(())
    }
}

/// Whether some tendon lies on every side: two opposite ones (a robot that bends in a plane), or
/// three and more with gaps below half a turn.
fn bends_both_ways(tendons: &[PlacedTendon]) -> bool {
    let mut angles: Vec<f64> =
        tendons.iter().map(|placed| placed.angle_deg.rem_euclid(360.0)).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let Some(first) = angles.first() else { return false };
    let next = angles.iter().skip(1).copied().chain([first + 360.0]);
    let widest = angles.iter().zip(next).map(|(from, to)| to - from).fold(0.0, f64::max);
    let most = if angles.len() == 2 { 180.0 } else { 180.0 - MARGIN_DEG };
    angles.len() > 1 && widest <= most + 1e-6
}

/// Three and more tendons leave no gap nearer to half a turn than this, degrees.
const MARGIN_DEG: f64 = 5.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(angles: &[f64]) -> Result<(), String> {
        let place = |(tendon, &angle_deg)| PlacedTendon { tendon, angle_deg };
        TendonLayout { segments: vec![angles.iter().enumerate().map(place).collect()] }.check()
    }

    #[test]
    fn tendons_on_every_side_bend_a_robot_and_others_do_not() {
        for good in [
            &[0.0, 180.0][..],
            &[0.0, 120.0, 240.0],
            &[-45.0, 45.0, 135.0, 225.0],
            &[90.0, -30.0, 210.0],
        ] {
            assert_eq!(checked(good), Ok(()), "{good:?}");
        }
        assert_eq!(TendonLayout::ring(6).check(), Ok(()));
        for bad in [&[0.0][..], &[0.0, 90.0], &[0.0, 0.0], &[0.0, 60.0, 120.0]] {
            assert!(checked(bad).unwrap_err().contains("one side"), "{bad:?}");
        }
    }
}
