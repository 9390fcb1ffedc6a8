//! Faults of a recording that are no physics of the robot. They are looked for before any effect
//! is.

pub(crate) mod clock_offset;
pub(crate) mod excluded_rows;
pub(crate) mod mislabelled;
mod time_scan;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::excluded_rows::{PreparedRecording, coarse_model};
    use super::{clock_offset, mislabelled};
    use crate::data::Recording;
    use crate::discovery::fit::candidate::catalogue_candidates;
    use crate::discovery::fit::simulate;
    use crate::discovery::options::Options;
    use crate::discovery::recording::samples::{Samples, white_noise};
    use crate::effects::{EffectSpec, Model};

    /// Commands of two recorded trials, and the tips that a robot with `effects` shows `offset_s`
    /// after each row.
    pub(crate) fn robot(effects: &[EffectSpec], offset_s: f64) -> Option<(Model, Recording)> {
        let model = Model::default();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/twin/nothing.csv");
        let recorded = Recording::read(&file).unwrap();
        let mut part = Recording::new(recorded.actuation, recorded.tendons());
        for row in 0..recorded.trials()[1].1.end {
            part.trial.push(recorded.trial[row]);
            part.time_s.push(recorded.time_s[row]);
            part.commands.push(recorded.commands.row(row));
        }
        part.tip_m = Some(vec![[0.0; 3]; part.len()]);
        let samples = Samples::new(&part.with_tips_later(offset_s));
        let tips_m = simulate::tips(&coarse_model(&model, &Options::default()), effects, &samples)?;
        let mut noise = white_noise(5e-4, 9);
        part.tip_m =
            Some(tips_m.as_chunks::<3>().0.iter().map(|tip| tip.map(|x| x + noise())).collect());
        Some((model, part))
    }

    /// No effect of the catalogue is taken for a mistake or a clock, at twice the size at which it
    /// is sought: whatever a robot lacks, it does not move before its commands.
    #[test]
    fn no_effect_is_a_mistake_or_a_clock() {
        let options = Options::default();
        for candidate in catalogue_candidates(&Model::default()) {
            for values in candidate.variants().iter().take(1) {
                for step in [-2.0, 2.0] {
                    let steps: Vec<f64> = candidate
                        .sizes()
                        .iter()
                        .map(|&size| step * candidate.probe(size))
                        .collect();
                    let Some(effect) = candidate.effect(&candidate.with_sizes(values, &steps))
                    else {
                        continue;
                    };
                    let Some((model, measured)) = robot(&[effect], 0.0) else { continue };
                    let mistake = mislabelled::find(
                        &model,
                        &PreparedRecording::new(&model, &measured, &options),
                        &options,
                    );
                    assert!(mistake.is_none(), "{} {steps:?}: {mistake:?}", candidate.label());
                    let offset = clock_offset::find(&model, &measured, &options);
                    assert!(offset.is_none(), "{} {steps:?}: {offset:?}", candidate.label());
                }
            }
        }
    }
}
