//! Slightly perturbed rods that follow a leading one: derivatives of a whole motion
//! (`docs/method/sensitivities.md`).
//!
//! The leader is solved. Each follower takes the same time steps with the same taut tendons, and at
//! each solve corrects the leader's unknowns by −J⁻¹ (F′ − F): its own residual there and the
//! leader's derivative. For a perturbation of relative size ε the error is of order ε², so that
//! (follower − leader)/ε is the derivative of the discrete motion up to ε (internal
//! differentiation, Bock 1981).

use nalgebra::{DVector, Dyn, LU};

use crate::rod::discretisation::grid::Grid;
use crate::rod::equations::boundary_conditions::{SolveConditions, TendonConstraint};
use crate::rod::equations::motion::Motion;
use crate::rod::equations::system::RodEquations;
use crate::rod::params::loads::TipWrench;
use crate::rod::params::rod_params::RodParams;
use crate::rod::solver::status::SolveStatus;
use crate::rod::state::rates::Rates;
use crate::rod::state::rod::{Drive, Rod};
use crate::rod::state::solve_log::{SolveLog, SolvedStage, SolvedStep};

/// A rod cannot follow the leader: it has other parts, or coincident parts have separated. Holds
/// its number, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("rod {0} has another discretisation than the first rod")]
pub struct NotPerturbable(pub usize);

/// A leading rod (number 0) and its followers (from 1).
#[derive(Clone, Debug)]
pub struct PerturbedRods {
    leader: Rod,
    /// A copy of the leader at the solve that the followers are at.
    followed: Rod,
    followers: Vec<Rod>,
    /// As [`PerturbedRods::lost`] says.
    lost: Vec<bool>,
    leader_derivative: Option<LeaderDerivative>,
}

/// The leader's equations at one of its solutions.
struct LeaderSolution<'a> {
    unknowns: &'a [f64],
    taut: &'a [bool],
    residual: DVector<f64>,
    at_rest: bool,
    /// Contraction of the corrections, once measured.
    contraction: Option<f64>,
}

/// The derivative of the leader's equations at this or an earlier solution.
#[derive(Clone, Debug)]
struct LeaderDerivative {
    factors: LU<f64, Dyn, Dyn>,
    rate: f64,
    taut: Vec<bool>,
    /// Most corrections per rod in the last solve.
    corrections: usize,
}

impl PerturbedRods {
    /// The rod of `params` and, from 1 on, those of `others`.
    ///
    /// # Errors
    /// [`NotPerturbable`] names the first one that cannot follow.
    pub fn new(params: RodParams, others: Vec<RodParams>) -> Result<PerturbedRods, NotPerturbable> {
        let PerturbedRods { leader, .. } = PerturbedRods::alone(params);
        let follower = |(index, changed): (usize, RodParams)| {
            let grid =
                Grid::moved(&leader.system.params, &changed).ok_or(NotPerturbable(index + 1))?;
            Ok(Rod::on(RodEquations::on(grid, changed)))
        };
        let followers: Vec<Rod> =
            others.into_iter().enumerate().map(follower).collect::<Result<_, _>>()?;
        Ok(PerturbedRods {
            followed: leader.clone(),
            leader,
            lost: vec![false; followers.len()],
            followers,
            leader_derivative: None,
        })
    }

    /// A rod without followers.
    pub fn alone(params: RodParams) -> PerturbedRods {
        let leader = Rod::new(params);
        PerturbedRods {
            followed: leader.clone(),
            leader,
            followers: Vec::new(),
            lost: Vec::new(),
            leader_derivative: None,
        }
    }

    /// Whether a rod of `changed` could follow one of `params`.
    pub fn possible(params: &RodParams, changed: &RodParams) -> bool {
        Grid::moved(params, changed).is_some()
    }

    /// The leader.
    pub fn leader(&self) -> &Rod {
        &self.leader
    }

    /// The followers.
    pub fn others(&self) -> &[Rod] {
        &self.followers
    }

    /// Whether each follower has lost its way since [`PerturbedRods::forget_lost`]: its corrections
    /// did not converge, and it went on from where the leader was.
    pub(crate) fn lost(&self) -> &[bool] {
        &self.lost
    }

    /// Takes all followers as on their way.
    pub(crate) fn forget_lost(&mut self) {
        self.lost.fill(false);
    }

    /// All straight, unloaded, at rest, without history.
    pub fn restart(&mut self) {
        self.leader.restart();
        // Every follower has a grid at the initial level.
        let _ = self.match_leader_grid();
        self.all().for_each(Rod::restart);
        self.leader_derivative = None;
    }

    /// Makes the next rest one for good, whatever the parameters say.
    pub(crate) fn rest_for_good(&mut self) {
        self.all().for_each(Rod::rest_for_good);
    }

    /// Replaces the load at the tips from now on; `load` gives a rod's own.
    pub fn set_tip_load(&mut self, load: &dyn Fn(&RodParams) -> TipWrench) {
        self.all().for_each(|rod| rod.set_tip_load(load(rod.params())));
    }

    /// [`Rod::settle`] for all rods; `drives` gives the drives by rod number.
    pub fn settle(&mut self, drives: &dyn Fn(usize) -> Vec<Drive>) -> SolveStatus {
        self.lead(&|number, _| drives(number), &|_| 1.0, |leader| leader.settle(&drives(0)))
    }

    /// [`Rod::advance_with`] for `duration_s(0)`. `drives` gives the drives by rod number and time
    /// from now, seconds. Followers take the same number of steps in their own, slightly different
    /// `duration_s`.
    pub fn advance_with(
        &mut self,
        drives: &dyn Fn(usize, f64) -> Vec<Drive>,
        duration_s: &dyn Fn(usize) -> f64,
    ) -> SolveStatus {
        let own_s = duration_s(0);
        self.lead(drives, &|number| duration_s(number) / own_s, |leader| {
            leader.advance_with(&|t| drives(0, t), own_s)
        })
    }

    /// Brings the followers to the leader's grid; `None` when one of them has no such grid.
    fn match_leader_grid(&mut self) -> Option<()> {
        let PerturbedRods { leader, followed, followers, leader_derivative, .. } = self;
        let level = leader.grid_level.level;
        if followed.grid_level.level == level {
            return Some(());
        }
        *leader_derivative = None;
        *followed = followed.on_grid(level);
        for follower in followers {
            let params = follower.system.params.refined(&leader.grid_level.base, level);
            let grid = Grid::moved(&leader.system.params, &params)?;
            *follower = follower.with_state_on(Rod::on(RodEquations::on(grid, params)), level);
        }
        Some(())
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Rod> {
        [&mut self.leader, &mut self.followed].into_iter().chain(&mut self.followers)
    }

    /// Moves the leader; the followers then take the solves in its log.
    fn lead(
        &mut self,
        drives: &dyn Fn(usize, f64) -> Vec<Drive>,
        scale: &dyn Fn(usize) -> f64,
        movement: impl FnOnce(&mut Rod) -> SolveStatus,
    ) -> SolveStatus {
        if self.followers.is_empty() {
            return movement(&mut self.leader);
        }
        self.leader.log = Some(SolveLog::default());
        let mut start_s = -self.leader.step_size.owed_s;
        let status = movement(&mut self.leader);
        // Followers repeat exactly the solves that were accepted; rejected steps leave no trace.
        for solved in self.leader.log.take().unwrap_or_default().solved {
            let drives_then =
                |number: usize, t: f64| drives(number, f64::max(0.0, start_s * scale(number) + t));
            if self.match_leader_grid().is_none() {
                return SolveStatus::UnderResolved;
            }
            let follows = self.follow(&solved, &drives_then, scale).is_some();
            let PerturbedRods { leader, followed, followers, lost, .. } = self;
            if !follows {
                followed.state.copy_from(&leader.state);
                lost.fill(true);
            }
            // A history that lags by a step is no derivative: it begins anew from the leader's.
            for (follower, _) in followers.iter_mut().zip(lost).filter(|(_, lost)| **lost) {
                follower.state.copy_from(&followed.state);
            }
            if !follows {
                return status;
            }
            start_s += solved.duration_s;
        }
        status
    }

    /// Takes the followers through one step or equilibrium of the leader. Time runs `scale` times
    /// as fast for a follower.
    fn follow(
        &mut self,
        solved: &SolvedStep,
        drives: &dyn Fn(usize, f64) -> Vec<Drive>,
        scale: &dyn Fn(usize) -> f64,
    ) -> Option<()> {
        let PerturbedRods { followed, followers, lost, leader_derivative, .. } = self;
        let at_rest = solved.duration_s.is_infinite();
        for Rod { state, before, .. } in std::iter::once(&mut *followed).chain(&mut *followers) {
            before.copy_from(state);
        }
        for (i, SolvedStage { unknowns, taut }) in solved.stages.iter().enumerate() {
            let share: f64 = followed.tableau.rows[i].iter().sum();
            let prepare = |rod: &mut Rod, number: usize| {
                let duration_s = solved.duration_s * scale(number);
                if at_rest {
                    rod.motion = Motion::rest(&rod.system.grid, &rod.system.masses);
                } else {
                    let Rod { motion, system, tableau, stages, before, .. } = rod;
                    motion.prepare(before, &system.masses, &tableau.rows[i], stages, duration_s);
                }
                rod.constraints(&drives(number, if at_rest { 0.0 } else { share * duration_s }))
            };
            let constraints = prepare(followed, 0)?;
            let mut solution = followed.at_solution(unknowns, taut, &constraints, at_rest);
            followed.adopt(unknowns, taut, i, at_rest);
            let all_constraints: Vec<Vec<TendonConstraint>> = followers
                .iter_mut()
                .enumerate()
                .map(|(index, rod)| prepare(rod, index + 1))
                .collect::<Option<_>>()?;
            // 1. An older derivative serves as long as its corrections are cheaper than a new one.
            let reused = leader_derivative
                .take()
                .filter(|old| old.serves(followed.motion.rate, taut, followers.len()));
            let corrected = reused.and_then(|mut reused| {
                let corrected =
                    reused.correct(followers, &all_constraints, &mut solution, WITH_OLD_FACTORS);
                *leader_derivative = Some(reused);
                corrected.iter().all(Option::is_some).then_some(corrected)
            });
            let corrected = match corrected {
                Some(corrected) => corrected,
                None => {
                    // 2. Else linearise at this solution; old contractions say nothing of the new
                    // factors.
                    solution.contraction = None;
                    let fresh =
                        leader_derivative.insert(followed.linearise(&solution, &constraints));
                    fresh.correct(followers, &all_constraints, &mut solution, WITH_FRESH_FACTORS)
                }
            };
            for ((follower, own), lost) in followers.iter_mut().zip(corrected).zip(&mut *lost) {
                *lost |= own.is_none();
                follower.adopt(own.as_deref().unwrap_or(unknowns), taut, i, at_rest);
            }
        }
        for (number, rod) in std::iter::once(followed).chain(followers).enumerate() {
            if at_rest {
                rod.state.rates = Rates::zero(&rod.system.grid, &rod.system.masses);
            } else {
                rod.state.rates.clone_from(&rod.stages[solved.stages.len() - 1]);
            }
            // After all stages, as in the leader's own step.
            rod.commit_histories(solved.duration_s * scale(number));
        }
        Some(())
    }
}

/// When corrections end.
#[derive(Clone, Copy)]
struct CorrectionLimits {
    /// Allowed remainder as a share of the first correction.
    tolerance: f64,
    max_corrections: usize,
}

/// With a derivative at this solution, whose contraction hardly changes between solves.
const WITH_FRESH_FACTORS: CorrectionLimits =
    CorrectionLimits { tolerance: 1e-5, max_corrections: 30 };
/// With an older one.
const WITH_OLD_FACTORS: CorrectionLimits = CorrectionLimits { tolerance: 1e-7, max_corrections: 8 };
/// Corrections after which a rod takes its own derivative: where a cross-section is about to slip,
/// follower and leader may be on different sides, and the leader's does not converge.
const OWN_FACTORS_AFTER: usize = 5;
/// Non-decreasing corrections below this, in lengths of the rod, are rounding.
const ROUNDING_LENGTHS: f64 = 1e-13;
/// Cost of a new derivative in corrections of one rod.
const DERIVATIVE_COST: usize = 8;

impl LeaderDerivative {
    /// Whether reusing the derivative for this many rods is cheaper than a new one.
    fn serves(&self, rate: f64, taut: &[bool], rods: usize) -> bool {
        self.rate == rate && self.taut == taut && (self.corrections - 1) * rods < DERIVATIVE_COST
    }

    /// The unknowns of each follower at the leader's `solution`; `None` where its corrections do not
    /// converge.
    fn correct(
        &mut self,
        rods: &mut [Rod],
        constraints: &[Vec<TendonConstraint>],
        solution: &mut LeaderSolution,
        limits: CorrectionLimits,
    ) -> Vec<Option<Vec<f64>>> {
        self.corrections = 1;
        let each = rods.iter_mut().zip(constraints).map(|(rod, constraints)| {
            let (unknowns, corrections) =
                rod.corrected(&self.factors, limits, solution, constraints)?;
            self.corrections = self.corrections.max(corrections);
            Some(unknowns)
        });
        each.collect()
    }
}

impl Rod {
    /// The residual at a solution.
    fn at_solution<'a>(
        &mut self,
        unknowns: &'a [f64],
        taut: &'a [bool],
        constraints: &[TendonConstraint],
        at_rest: bool,
    ) -> LeaderSolution<'a> {
        let loads = self.full_loads();
        let Rod { system, solver, state, motion, .. } = self;
        let conditions =
            SolveConditions { taut, ..state.conditions(motion, constraints, &loads, at_rest) };
        system.evaluate(unknowns, &conditions, &mut solver.workspace);
        let residual = DVector::from_column_slice(&solver.workspace.residual);
        LeaderSolution { unknowns, taut, residual, at_rest, contraction: None }
    }

    /// The factorised derivative at `solution`, whose residual has just been evaluated.
    fn linearise(
        &mut self,
        solution: &LeaderSolution,
        constraints: &[TendonConstraint],
    ) -> LeaderDerivative {
        let loads = self.full_loads();
        let Rod { system, solver, state, motion, .. } = self;
        let &LeaderSolution { unknowns, taut, at_rest, .. } = solution;
        let conditions =
            SolveConditions { taut, ..state.conditions(motion, constraints, &loads, at_rest) };
        solver.derivative.update(system, unknowns, &conditions, &solver.workspace);
        let factors = solver.derivative.matrix(system, &conditions).lu();
        LeaderDerivative { factors, rate: motion.rate, taut: taut.to_vec(), corrections: 1 }
    }

    /// This follower's unknowns at the leader's `solution` and the number of corrections, until at
    /// most the allowed share of the first correction remains. The contraction is measured on the
    /// first follower with a nonzero correction; it is nearly zero at the derivative's own solution,
    /// except for drag and rotary inertia, which the derivative omits.
    fn corrected(
        &mut self,
        factors: &LU<f64, Dyn, Dyn>,
        limits: CorrectionLimits,
        solution: &mut LeaderSolution,
        constraints: &[TendonConstraint],
    ) -> Option<(Vec<f64>, usize)> {
        let mut unknowns = solution.unknowns.to_vec();
        let loads = self.full_loads();
        let Rod { system, solver, state, motion, .. } = self;
        let &mut LeaderSolution { taut, at_rest, .. } = solution;
        let conditions =
            SolveConditions { taut, ..state.conditions(motion, constraints, &loads, at_rest) };
        let mut own_factors: Option<LU<f64, Dyn, Dyn>> = None;
        let (mut first_m, mut last_m) = (0.0, f64::NAN);
        for count in 1..=limits.max_corrections {
            // Chord iteration: the factors stay those of the leader or of an earlier solution.
            system.evaluate(&unknowns, &conditions, &mut solver.workspace);
            // The leader's own residual is subtracted: only the difference of both rods is sought.
            let mut step =
                DVector::from_column_slice(&solver.workspace.residual) - &solution.residual;
            if !own_factors.as_ref().unwrap_or(factors).solve_mut(&mut step) {
                return None;
            }
            unknowns.iter_mut().zip(step.iter()).for_each(|(x, dx)| *x -= dx);
            let size_m =
                system.size_of_step_m(&step.as_slice()[..system.grid.unknowns], &solver.workspace);
            // Corrections that no longer shrink are rounding.
            let rounding =
                size_m > 0.3 * last_m && size_m < ROUNDING_LENGTHS * system.params.length_m();
            if size_m == 0.0 || rounding {
                return Some((unknowns, count));
            }
            if count == 1 {
                first_m = size_m;
            } else if solution.contraction.is_none() {
                solution.contraction = Some(size_m / last_m);
            }
            let contraction =
                if count == 1 { solution.contraction.unwrap_or(1.0) } else { size_m / last_m };
            // A linear iteration leaves about its contraction times the last correction.
            if contraction * size_m < limits.tolerance * first_m {
                return Some((unknowns, count));
            }
            if count % OWN_FACTORS_AFTER == 0 {
                // The leader is about to slip where this rod sticks, or the other way round.
                solver.derivative.update(system, &unknowns, &conditions, &solver.workspace);
                own_factors = Some(solver.derivative.matrix(system, &conditions).lu());
            }
            last_m = size_m;
        }
        None
    }

    /// Adopts `unknowns` as the new state.
    fn adopt(&mut self, unknowns: &[f64], taut: &[bool], stage: usize, at_rest: bool) {
        let n = self.system.grid.unknowns;
        self.state.unknowns.copy_from_slice(unknowns);
        self.state.taut.copy_from_slice(taut);
        self.state.shape.update(&self.system.grid, &self.system.sections, &unknowns[..n]);
        if !at_rest {
            self.stages[stage].read(&self.motion, &self.system.masses, &self.state.shape);
        }
    }
}
