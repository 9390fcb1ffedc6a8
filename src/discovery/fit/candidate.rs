//! Candidate effects: which parameters of an effect are fitted, and from which start values.

use std::collections::BTreeSet;

use super::obstacle_hint::ObstacleHint;
use crate::effects::{CATALOGUE, Card, EffectSpec, Model, ModelParameter, Robot, Seek};

/// An effect of the catalogue that may be missing, with its tendon if it acts on one.
#[derive(Clone, Debug)]
pub(crate) struct CandidateEffect {
    pub(crate) card: &'static Card,
    /// How each parameter of the card is determined.
    searches: Vec<ParameterSearch>,
}

/// How a parameter is determined.
#[derive(Clone, Debug, PartialEq)]
enum ParameterSearch {
    /// Fitted in units of `size` from `null`; started from the best value of `scan`, if there are
    /// any.
    Size { null: f64, size: f64, scan: Vec<f64> },
    /// Tried at each value, then fitted; in its logarithm and within `range` if all are positive.
    Shape { tries: Vec<f64>, range: Option<[f64; 2]> },
    /// Fitted from `start`, with this step; without one there is nothing to fit.
    Located { start: Option<f64>, step: f64 },
    /// One of these values.
    Choice(Vec<f64>),
    /// This value.
    Fixed(f64),
}

/// A member of a candidate set: a candidate with the values of its card's parameters, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SetMember {
    /// Index of the candidate.
    pub(crate) candidate: usize,
    pub(crate) values: Vec<f64>,
}

/// Number of positions along the robot that are tried.
const PLACES: usize = 6;

/// Factor by which a positive shape may leave the range of tried values. Farther out it is another
/// effect, or one that cannot be simulated (friction without yield is rigid).
const MAX_SHAPE_FACTOR: f64 = 5.0;

/// Shortest time that is fitted, in steps of the recording: what relaxes faster has all but relaxed
/// in the next row, as less stiffness has.
const MIN_TIME_STEPS: f64 = 2.0;
/// Ratios below this are as implausible as this.
const MIN_RATIO: f64 = 0.01;

/// Bisection steps for the end of a range, and the rounding unit over the probe.
const RANGE_BISECTIONS: usize = 60;
const ROUNDING_SHARE: f64 = 1e-9;

/// The catalogue as candidates for `model`.
pub(crate) fn catalogue_candidates(model: &Model) -> Vec<CandidateEffect> {
    let tendons = model.robot.tendons.angles_deg.len();
    let is_alone = model.robot.tendon_layout().segments.len() == 1;
    let needs_several =
        |card: &Card| card.parameters.iter().any(|one| one.seek == Seek::Segment && one.null > 0.0);
    let sought = CATALOGUE.iter().filter(|card| !(is_alone && needs_several(card)));
    let each = sought.flat_map(|card| {
        let about_one = card.parameters.iter().any(|parameter| parameter.seek == Seek::Tendon);
        // An effect about one tendon is one hypothesis a tendon.
        let each: Vec<usize> = if about_one { (1..=tendons).collect() } else { vec![0] };
        each.into_iter().map(|tendon| CandidateEffect::new(card, model, tendon)).collect::<Vec<_>>()
    });
    each.collect()
}

impl CandidateEffect {
    fn new(card: &'static Card, model: &Model, tendon: usize) -> CandidateEffect {
        let length_m = model.robot.backbone.length_m;
        let segments = model.robot.tendon_layout().segments.len();
        let search = |parameter: &crate::effects::Parameter| match parameter.seek {
            // Where it starts is told later.
            Seek::Size(size) | Seek::Distance(size) => {
                ParameterSearch::Size { null: parameter.null, size, scan: Vec::new() }
            }
            Seek::Located(step) => ParameterSearch::Located { start: None, step },
            Seek::Scanned(size, scan) => {
                ParameterSearch::Size { null: parameter.null, size, scan: scan.to_vec() }
            }
            Seek::Replaces(path, size) => {
                // An earlier effect of the model may have replaced the parameter.
                let last = model.effects.iter().rposition(|effect| effect.card().name == card.name);
                let replaced = last.map(|k| format!("effects[{k}].{}", parameter.name));
                let path = replaced.as_deref().unwrap_or(path);
                let number =
                    ModelParameter::named(model, path).and_then(|number| number.value(model));
                ParameterSearch::Size {
                    null: number.unwrap_or(parameter.null),
                    size,
                    scan: Vec::new(),
                }
            }
            Seek::Shape(tries) => {
                let [min, max] = [f64::min, f64::max]
                    .map(|end| tries.iter().copied().reduce(end).unwrap_or(parameter.null));
                let range = [min / MAX_SHAPE_FACTOR, max * MAX_SHAPE_FACTOR];
                ParameterSearch::Shape {
                    tries: tries.to_vec(),
                    range: (min > 0.0).then_some(range),
                }
            }
            Seek::Place => ParameterSearch::Choice(places(&model.robot, length_m)),
            Seek::Tendon => ParameterSearch::Fixed(tendon as f64),
            Seek::Segment if segments == 1 => ParameterSearch::Fixed(parameter.null),
            Seek::Segment => {
                let first = parameter.null as usize;
                ParameterSearch::Choice((first..=segments).map(|number| number as f64).collect())
            }
            Seek::Flag | Seek::Convention => ParameterSearch::Choice(vec![0.0, 1.0]),
        };
        CandidateEffect { card, searches: card.parameters.iter().map(search).collect() }
    }

    /// Restricts times to those that rows `step_s` apart resolve.
    pub(crate) fn resolve_times(&mut self, step_s: f64) {
        for (parameter, search) in self.card.parameters.iter().zip(&mut self.searches) {
            if let ParameterSearch::Shape { tries, range: Some([min, max]) } = search
                && parameter.unit == "s"
            {
                *min = min.max(MIN_TIME_STEPS * step_s).min(*max);
                tries.iter_mut().for_each(|time_s| *time_s = time_s.max(*min));
                tries.dedup();
            }
        }
    }

    /// What these values cost in score: minus twice the logarithm of the prior density over that
    /// without a change.
    pub(crate) fn implausibility(&self, values: &[f64]) -> f64 {
        let Some(usual) = self.card.usual_change else { return 0.0 };
        let cost = |(search, value): (&ParameterSearch, &f64)| {
            let ParameterSearch::Size { null, .. } = search else { return 0.0 };
            let change =
                if *null > 0.0 { (value / null).max(MIN_RATIO).ln() } else { value - null };
            // Cauchy: a robot may have been changed, so that nothing is out of the question.
            2.0 * (change / usual).powi(2).ln_1p()
        };
        self.searches.iter().zip(values).map(cost).sum()
    }

    /// Index of the parameter that says in which convention the others describe the same law.
    fn convention(&self) -> Option<usize> {
        self.card.parameters.iter().position(|parameter| parameter.seek == Seek::Convention)
    }

    /// Starts the search for something fixed in the world where `hint` says.
    pub(crate) fn start_at(&mut self, hint: &ObstacleHint) {
        for (parameter, search) in self.card.parameters.iter().zip(&mut self.searches) {
            match (parameter.seek, search) {
                (Seek::Distance(_), ParameterSearch::Size { scan, .. }) => {
                    scan.clone_from(&hint.distances_m)
                }
                (_, ParameterSearch::Located { start, .. }) => {
                    *start = match parameter.name {
                        "azimuth_rad" => Some(hint.azimuth_rad),
                        "position_m" => Some(hint.position_m),
                        _ => Some(hint.curvature_1_m),
                    }
                }
                _ => {}
            }
        }
    }

    /// Whether there is anything to start a search from.
    pub(crate) fn has_start(&self) -> bool {
        !self.variants().is_empty()
    }

    /// Name, with the tendon if it acts on one.
    pub(crate) fn label(&self) -> String {
        let both = self.card.parameters.iter().zip(&self.searches);
        let tendon = both.into_iter().find_map(|(parameter, search)| match search {
            ParameterSearch::Fixed(tendon) if parameter.seek == Seek::Tendon => Some(*tendon),
            _ => None,
        });
        tendon.map_or_else(
            || self.card.name.to_owned(),
            |tendon| format!("{} (tendon {tendon})", self.card.name),
        )
    }

    /// Number of parameters that are fitted or chosen, for the penalty.
    pub(crate) fn freedom(&self) -> usize {
        let numbers =
            self.searches.iter().filter(|search| !matches!(search, ParameterSearch::Fixed(_)));
        // Both conventions describe the same law.
        numbers.count() - usize::from(self.convention().is_some())
    }

    /// Indices of the size parameters.
    pub(crate) fn sizes(&self) -> Vec<usize> {
        self.indices(|search| matches!(search, ParameterSearch::Size { .. }))
    }

    /// Whether there are shape or choice parameters beside the sizes.
    pub(crate) fn has_shape(&self) -> bool {
        self.searches.iter().any(|search| {
            matches!(search, ParameterSearch::Shape { .. } | ParameterSearch::Choice(_))
        })
    }

    /// Whether the effect replaces a parameter of the model.
    pub(crate) fn replaces(&self) -> bool {
        self.card.parameters.iter().any(|parameter| matches!(parameter.seek, Seek::Replaces(..)))
    }

    /// Indices of the parameters that a fit moves.
    pub(crate) fn fitted(&self) -> Vec<usize> {
        let is_fitted = |search: &ParameterSearch| {
            use ParameterSearch::{Located, Shape, Size};
            matches!(search, Size { .. } | Shape { .. } | Located { .. })
        };
        self.indices(is_fitted)
    }

    fn indices(&self, is_listed: impl Fn(&ParameterSearch) -> bool) -> Vec<usize> {
        (0..self.searches.len()).filter(|&index| is_listed(&self.searches[index])).collect()
    }

    /// Values without any effect, one for each combination of shapes and choices.
    pub(crate) fn variants(&self) -> Vec<Vec<f64>> {
        // Cartesian product of the tries of all parameters.
        let mut variants = vec![Vec::new()];
        for search in &self.searches {
            let values: &[f64] = match search {
                ParameterSearch::Size { null, .. } => std::slice::from_ref(null),
                ParameterSearch::Fixed(value) => std::slice::from_ref(value),
                ParameterSearch::Located { start, .. } => start.as_slice(),
                ParameterSearch::Shape { tries, .. } | ParameterSearch::Choice(tries) => tries,
            };
            let longer = |shorter: &Vec<f64>| -> Vec<Vec<f64>> {
                values
                    .iter()
                    .map(|&value| shorter.iter().copied().chain([value]).collect())
                    .collect()
            };
            variants = variants.iter().flat_map(longer).collect();
        }
        variants
    }

    /// `values` with all sizes at null.
    pub(crate) fn without_size(&self, values: &[f64]) -> Vec<f64> {
        let null = |(search, value): (&ParameterSearch, &f64)| {
            if let ParameterSearch::Size { null, .. } = search { *null } else { *value }
        };
        self.searches.iter().zip(values).map(null).collect()
    }

    /// Whether small sizes do not predict the response to larger ones, so that a range is scanned.
    pub(crate) fn is_scanned(&self) -> bool {
        !self.scan().is_empty()
    }

    /// Steps from null to each size of the scan.
    pub(crate) fn scan(&self) -> Vec<f64> {
        let steps = |search: &ParameterSearch| match search {
            ParameterSearch::Size { null, scan, .. } => {
                scan.iter().map(|value| value - null).collect()
            }
            _ => Vec::new(),
        };
        self.searches.iter().flat_map(steps).collect()
    }

    /// `values` with one choice replaced by a neighbouring one.
    fn neighbouring_choices(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut neighbours = Vec::new();
        for (index, search) in self.searches.iter().enumerate() {
            let ParameterSearch::Choice(choices) = search else { continue };
            let at = choices.iter().position(|&choice| choice == values[index]).unwrap_or(0);
            for other in [at.checked_sub(1), Some(at + 1)]
                .into_iter()
                .flatten()
                .filter(|&k| k < choices.len())
            {
                let mut beside = values.to_vec();
                beside[index] = choices[other];
                neighbours.push(beside);
            }
        }
        neighbours
    }

    /// A step of parameter `index` with a visible response, in the coordinate of
    /// [`CandidateEffect::moved`].
    pub(crate) fn probe(&self, index: usize) -> f64 {
        match self.searches[index] {
            ParameterSearch::Size { size, .. } => size,
            ParameterSearch::Located { step, .. } => step,
            ParameterSearch::Shape { range: Some(_), .. } => 0.25,
            _ => 0.1,
        }
    }

    /// `values` with parameter `index` moved by `step`: added, or for a positive shape multiplied
    /// by exp(step), within its range.
    pub(crate) fn moved(&self, values: &[f64], index: usize, step: f64) -> Vec<f64> {
        let mut there = values.to_vec();
        match self.searches[index] {
            ParameterSearch::Shape { range: Some([min, max]), .. } => {
                // Times and yield points are steps in the logarithm, so they stay positive.
                there[index] = (values[index] * step.exp()).clamp(min, max);
            }
            _ => there[index] += step,
        }
        there
    }

    /// `values` with each size moved by one of the `steps`.
    pub(crate) fn with_sizes(&self, values: &[f64], steps: &[f64]) -> Vec<f64> {
        let each = self.sizes().into_iter().zip(steps);
        each.fold(values.to_vec(), |at, (size, &step)| self.moved(&at, size, step))
    }

    /// `values` with parameter `index` moved by `step`, at most to the end of the effect's valid
    /// range. The end is found by bisection and rounded.
    pub(crate) fn moved_within(&self, values: &[f64], index: usize, step: f64) -> Vec<f64> {
        let is_in_range = |there: &[f64]| self.effect(there).is_some();
        let there = self.moved(values, index, step);
        if is_in_range(&there) || !is_in_range(values) {
            return there;
        }
        // A range may depend on other parameters, so only the effect itself tells its end.
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..RANGE_BISECTIONS {
            let middle = 0.5 * (inside + outside);
            *(if is_in_range(&self.moved(values, index, middle * step)) {
                &mut inside
            } else {
                &mut outside
            }) = middle;
        }
        let last = self.moved(values, index, inside * step);
        let mut round = last.clone();
        let unit = ROUNDING_SHARE * self.probe(index);
        // Adding 0.0 turns a negative zero into a positive one.
        // Rounding gives an exact zero where bisection ends at 1e-18.
        round[index] = (last[index] / unit).round() * unit + 0.0;
        // Rounding may step over the end.
        if is_in_range(&round) { round } else { last }
    }

    /// Whether a size is at the end of its valid range.
    pub(crate) fn is_at_range_end(&self, values: &[f64]) -> bool {
        let is_out =
            |index: usize, step: f64| self.effect(&self.moved(values, index, step)).is_none();
        // A bound is reached if a thousandth of a usual size further is invalid.
        let small_step = |index: usize| 1e-3 * self.probe(index).abs();
        self.sizes()
            .into_iter()
            .any(|index| is_out(index, small_step(index)) || is_out(index, -small_step(index)))
    }

    /// The step by which [`CandidateEffect::moved`] leads from `values` to `there`.
    pub(crate) fn step(&self, values: &[f64], there: &[f64], index: usize) -> f64 {
        match self.searches[index] {
            ParameterSearch::Shape { range: Some(_), .. } => (there[index] / values[index]).ln(),
            _ => there[index] - values[index],
        }
    }

    /// The effect with these values; none if they are outside its valid range.
    pub(crate) fn effect(&self, values: &[f64]) -> Option<EffectSpec> {
        EffectSpec::from_card(self.card, values)
    }
}

/// Section midpoints (a subset if there are many); evenly spaced positions without sections.
fn places(robot: &Robot, length_m: f64) -> Vec<f64> {
    let sections = robot.rod().sections;
    let count = if sections.is_empty() { PLACES } else { sections.len().min(2 * PLACES) };
    let place = |k: usize| {
        let share = (k as f64 + 0.5) / count as f64;
        // Effects that stand at a place act on sections, so tries fall on their middles.
        let section = sections.get((share * sections.len() as f64) as usize);
        section.map_or(share * length_m, |section| section.start_m + 0.5 * section.length_m)
    };
    (0..count).map(place).collect()
}

/// The members in the default convention, if there is an effect in another one beside the stiffness
/// that both conventions differ in. Beside that stiffness they are the same.
pub(crate) fn in_default_convention(
    candidates: &[CandidateEffect],
    members: &[SetMember],
) -> Option<Vec<SetMember>> {
    let stiffness = stiffness_of(candidates, members)?;
    let convention = |member: &SetMember| candidates[member.candidate].convention();
    let is_other = |member: &SetMember| {
        convention(member).is_some_and(|convention| member.values[convention] != 0.0)
    };
    let other = members.iter().position(is_other)?;
    let mut members = members.to_vec();
    // The first parameter is the share that relaxes.
    members[stiffness].values[0] /= 1.0 - members[other].values[0];
    let index = convention(&members[other])?;
    members[other].values[index] = 0.0;
    Some(members)
}

/// Choices of member `k` beside its own. A convention is none beside the stiffness that both
/// conventions differ in.
pub(crate) fn neighbouring_choices(
    candidates: &[CandidateEffect],
    members: &[SetMember],
    k: usize,
) -> Vec<Vec<f64>> {
    let (candidate, values) = (&candidates[members[k].candidate], &members[k].values);
    let mut choices = candidate.neighbouring_choices(values);
    if let Some(convention) =
        candidate.convention().filter(|_| stiffness_of(candidates, members).is_some())
    {
        choices.retain(|choice| choice[convention] == values[convention]);
    }
    choices
}

fn stiffness_of(candidates: &[CandidateEffect], members: &[SetMember]) -> Option<usize> {
    members.iter().position(|member| candidates[member.candidate].card.name == "bending_stiffness")
}

/// Indices of the candidates of these members.
pub(crate) fn candidate_set(members: &[SetMember]) -> BTreeSet<usize> {
    members.iter().map(|member| member.candidate).collect()
}

/// Effects of these members; none if a value is outside its valid range.
pub(crate) fn effect_specs(
    candidates: &[CandidateEffect],
    members: &[SetMember],
) -> Option<Vec<EffectSpec>> {
    members.iter().map(|member| candidates[member.candidate].effect(&member.values)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(name: &str) -> CandidateEffect {
        let model = Model::default();
        catalogue_candidates(&model)
            .into_iter()
            .find(|candidate| candidate.card.name == name)
            .unwrap()
    }

    #[test]
    fn segments_are_choices_of_robots_that_have_several() {
        let choices = |ends_m: Option<Vec<f64>>, name: &str| -> Vec<ParameterSearch> {
            let mut model = Model::default();
            model.robot.tendons.ends_m = ends_m;
            let all = catalogue_candidates(&model);
            let of = all.into_iter().filter(|candidate| candidate.card.name == name);
            of.map(|candidate| candidate.searches[usize::from(name != "pretension")].clone())
                .collect()
        };
        let two = || Some(vec![0.11, 0.22, 0.11, 0.22]);
        assert_eq!(choices(None, "bending_stiffness"), [ParameterSearch::Fixed(0.0)]);
        assert_eq!(
            choices(two(), "bending_stiffness"),
            [ParameterSearch::Choice(vec![0.0, 1.0, 2.0])]
        );
        assert_eq!(choices(None, "pretension"), []);
        assert_eq!(choices(two(), "pretension"), [ParameterSearch::Choice(vec![1.0, 2.0])]);
    }

    #[test]
    fn a_shape_stays_within_its_range_and_a_step_says_how_far_it_went() {
        let friction = candidate("friction");
        let from = &friction.variants()[0];
        let there = friction.moved(from, 1, -9.0);
        assert_eq!(there[1], 0.1 / MAX_SHAPE_FACTOR);
        assert_eq!(friction.moved(&there, 1, -0.1), there);
        let step = friction.step(from, &there, 1);
        assert!((friction.moved(from, 1, step)[1] - there[1]).abs() < 1e-12 && step > -9.0);
        assert_eq!(friction.step(from, &friction.moved(from, 0, 0.25), 0), 0.25);
    }

    #[test]
    fn times_that_the_rows_do_not_resolve_are_not_fitted() {
        let mut creep = candidate("creep");
        creep.resolve_times(0.5);
        let from = &creep.variants()[0];
        assert_eq!(from[1], 2.0 * 0.5, "0.7 s is shorter than two rows");
        assert_eq!(creep.moved(from, 1, -9.0), *from);
        let mut friction = candidate("friction");
        friction.resolve_times(0.5);
        assert_eq!(friction.variants()[0][1], 0.1, "a yield is no time");
    }

    #[test]
    fn implausible_sizes_cost_and_loads_do_not() {
        let cost = |name: &str, value: f64| candidate(name).implausibility(&[value]);
        assert_eq!([cost("tip_load", 0.4), cost("tendon_radius", 1.0)], [0.0; 2]);
        assert!(cost("tendon_radius", 1.02) < 0.5 && cost("bending_stiffness", 1.2) < 0.7);
        assert!(cost("tendon_radius", 1.5) > 8.0 && cost("bending_stiffness", 1.0 / 11.0) > 8.0);
        let softer = cost("bending_stiffness", 0.5);
        assert!((softer - cost("bending_stiffness", 2.0)).abs() < 1e-12, "a ratio either way");
        assert!(cost("spine_compressibility", 0.0).is_finite());
    }

    #[test]
    fn beside_the_stiffness_there_is_one_convention() {
        let candidates = catalogue_candidates(&Model::default());
        let member = |name: &str, values: &[f64]| SetMember {
            candidate: candidates.iter().position(|one| one.card.name == name).unwrap(),
            values: values.to_vec(),
        };
        let (creep, stiffness) =
            (member("creep", &[0.25, 5.0, 1.0]), member("bending_stiffness", &[0.9]));
        let choices = |members: &[SetMember]| neighbouring_choices(&candidates, members, 0).len();
        assert_eq!(choices(std::slice::from_ref(&creep)), 1);
        assert_eq!(in_default_convention(&candidates, std::slice::from_ref(&creep)), None);
        let both = [creep, stiffness];
        assert_eq!(choices(&both), 0);
        let one = in_default_convention(&candidates, &both).unwrap();
        assert_eq!(one, [member("creep", &[0.25, 5.0, 0.0]), member("bending_stiffness", &[1.2])]);
        assert_eq!(in_default_convention(&candidates, &one), None);
    }

    #[test]
    fn a_size_goes_to_the_end_of_its_range_and_no_farther() {
        let load = candidate("tip_load");
        assert_eq!(load.moved_within(&[0.003], 0, -0.002), load.moved(&[0.003], 0, -0.002));
        assert_eq!(load.moved_within(&[0.003], 0, -0.01), [0.0]);
        assert!(load.moved_within(&[0.003], 0, -0.01)[0].is_sign_positive());
        let tilt = candidate("base_tilt");
        assert_eq!(tilt.moved_within(&[0.01, 0.02], 1, -0.05), tilt.moved(&[0.01, 0.02], 1, -0.05));
    }

    #[test]
    fn places_are_the_middles_of_sections_or_evenly_spaced() {
        let robot = Robot::default();
        let middles: Vec<f64> =
            robot.rod().sections.iter().map(|one| one.start_m + 0.5 * one.length_m).collect();
        assert_eq!((places(&robot, 0.22), middles.len()), (middles, 11));
        let with = |count: usize, length_m: f64| {
            let mut robot = Robot::default();
            (robot.sections.count, robot.sections.length_m) = (count, length_m);
            places(&robot, robot.backbone.length_m)
        };
        let some = with(40, 0.003);
        assert!(
            some.len() == 2 * PLACES
                && some.windows(2).all(|two| two[0] < two[1])
                && some[11] < 0.22,
            "{some:?}"
        );
        let even: Vec<f64> = (0..PLACES).map(|k| (k as f64 + 0.5) / PLACES as f64 * 0.22).collect();
        assert_eq!(with(0, 0.01), even);
    }

    #[test]
    fn the_end_of_a_range_is_known_from_either_side_and_some_ranges_have_none() {
        let at_an_end = |name: &str, values: &[f64]| candidate(name).is_at_range_end(values);
        assert!(at_an_end("tip_load", &[0.0]) && !at_an_end("tip_load", &[0.003]));
        assert!(at_an_end("distributed_mass", &[1e-9]) && !at_an_end("distributed_mass", &[0.2]));
        assert!(!at_an_end("base_tilt", &[0.0, 0.0]));
    }

    #[test]
    fn what_an_effect_of_the_model_has_replaced_is_what_it_is_now() {
        let mut model = Model::default();
        let null = |model: &Model| {
            let found = catalogue_candidates(model)
                .into_iter()
                .find(|candidate| candidate.card.name == "damping")
                .unwrap();
            found.variants()[0][0]
        };
        assert_eq!(null(&model), model.robot.damping_time_s);
        let damping = candidate("damping").effect(&[0.15]).unwrap();
        model.effects.push(damping);
        assert_eq!(null(&model), 0.15);
    }

    #[test]
    fn what_rises_and_falls_is_looked_at_everywhere() {
        let scan = candidate("delay").scan();
        assert!(scan.len() > 10 && scan.is_sorted() && scan[0] > 0.0);
        assert!(candidate("tip_load").scan().is_empty());
    }
}
