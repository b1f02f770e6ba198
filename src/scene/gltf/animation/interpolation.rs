use crate::scene::error::clipped;

/// How values between keys are found (glTF 2.0, appendix C).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the key before.
    Step,
    /// Evenly from key to key, rotations along the shorter arc.
    Linear,
    /// By a cubic spline, whose tangents stand beside each key's value.
    CubicSpline,
}

impl Interpolation {
    /// By its name in the file. What is wrong is told as a phrase.
    pub fn parse(name: Option<&str>) -> Result<Interpolation, String> {
        match name {
            None | Some("LINEAR") => Ok(Interpolation::Linear),
            Some("STEP") => Ok(Interpolation::Step),
            Some("CUBICSPLINE") => Ok(Interpolation::CubicSpline),
            Some(other) => {
                Err(format!("has the interpolation '{}'; it must be STEP, LINEAR or CUBICSPLINE", clipped(other)))
            }
        }
    }

    /// Values that stand at each key.
    pub fn values_of_a_key(self) -> usize {
        if self == Interpolation::CubicSpline { 3 } else { 1 }
    }
}

/// How much the value before, the tangent that leaves it, the value behind and the tangent that arrives there count `share` of the way
/// along a spline (glTF 2.0, appendix C.5). Tangents are per second.
pub fn hermite(share: f64, span: f64) -> [f64; 4] {
    let (t, t2, t3) = (share, share * share, share * share * share);
    [2.0 * t3 - 3.0 * t2 + 1.0, span * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, span * (t3 - t2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_interpolations() {
        assert_eq!(Interpolation::parse(None), Ok(Interpolation::Linear));
        assert!(Interpolation::parse(Some("step")).unwrap_err().contains("'step'"));
    }
}
