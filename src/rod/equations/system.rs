//! The discrete equations of a rod: balance of internal and external wrench, weighted with the
//! strain of each polynomial (Galerkin), and one equation per tendon.

use nalgebra::{DVector, Vector3};

use super::boundary_conditions::{SolveConditions, TendonConstraint};
use super::contact::{ContactPoint, Touch};
use super::homogenised_cells;
use super::loads::{ConstantLoads, LoadedRod, Loads};
use super::material::{Components, Section};
use super::motion::EndMass;
use super::shape::Shape;
use super::tendon_friction::TendonSliding;
use super::tendon_guide::TendonGuide;
use crate::math::{matrix3, rotation, vectorised};
use crate::rod::discretisation::cell::{COMPONENTS, Node};
use crate::rod::discretisation::grid::Grid;
use crate::rod::params::hysteresis_law::HistoryState;
use crate::rod::params::rod_params::RodParams;
use crate::rod::params::tendon::Tendon;

/// The equations of a rod on one grid; constant during a simulation.
#[derive(Clone, Debug)]
pub(crate) struct RodEquations {
    pub(crate) params: RodParams,
    pub(crate) grid: Grid,
    pub(crate) sections: Vec<Section>,
    pub(crate) masses: Vec<EndMass>,
    /// Constant loads.
    pub(crate) constant_loads: ConstantLoads,
    /// Points that may touch obstacles; none without obstacles.
    pub(crate) contact_points: Vec<ContactPoint>,
    /// For each Gauss point and tendon: where the tendon passes.
    pub(crate) guides: Vec<TendonGuide>,
    /// Path length of each tendon at home, metres.
    pub(crate) home_lengths_m: Vec<f64>,
    /// Tip displacement per unit of each unknown, m per unit; scales step sizes.
    pub(crate) scales: Vec<f64>,
    /// The diagonal of K of the unloaded rod.
    pub(crate) elastic_diagonal: Vec<f64>,
    /// Approximate tip displacement per unit tension of each tendon, m/N.
    pub(crate) reach_m_per_n: Vec<f64>,
}

/// Intermediate results of one evaluation of the residual.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    pub(crate) shape: Shape,
    pub(crate) loads: Loads,
    /// Contacts with obstacles.
    pub(crate) touches: Vec<Touch>,
    /// For each Gauss point and tendon: unit tangent (0 past the tendon's end).
    pub(crate) tangents: Vec<Vector3<f64>>,
    /// For each Gauss point and tendon: length per backbone length (0 past the tendon's end), and
    /// one over it.
    pub(crate) stretches: Vec<f64>,
    inverse_stretches: Vec<f64>,
    /// For each Gauss point and tendon: tension as a share of that at the drive.
    pub(crate) tension_shares: Vec<f64>,
    /// Sliding of the tendons with friction.
    pub(crate) sliding: Vec<TendonSliding>,
    /// Path length of each tendon, metres.
    pub(crate) lengths_m: Vec<f64>,
    /// Tangent stiffness of the history moments at the Gauss points.
    pub(crate) history_tangent: Vec<[[f64; 2]; 2]>,
    /// Room for a field over the Gauss points.
    field: Vec<f64>,
    /// Internal minus external wrench at the Gauss points, body frame.
    pub(crate) imbalance: Vec<Components>,
    /// Axial compliance that weights the balance at each Gauss point, 1/N.
    pub(crate) axial_weight: Vec<f64>,
    /// Whether these weights are frozen. They jump where the spine saturates; with a wrench that is
    /// not a polynomial, the equations could otherwise alternate without a solution.
    pub(crate) weights_frozen: bool,
    /// Equations of balance, then one a tendon.
    pub(crate) residual: Vec<f64>,
}

impl Workspace {
    /// The strain by which the balance at Gauss point `g` weights a wrench.
    pub(crate) fn weighted_strain(&self, g: usize, wrench: &Components) -> Components {
        let mut strain = self.shape.compliance[g].apply(wrench);
        strain[5] = self.axial_weight[g] * wrench[5];
        strain
    }
}

impl RodEquations {
    pub(crate) fn new(params: RodParams) -> RodEquations {
        RodEquations::on(Grid::new(&params), params)
    }

    /// A rod on a grid that was made for it.
    pub(crate) fn on(grid: Grid, params: RodParams) -> RodEquations {
        let sections = if params.resolution.blended {
            homogenised_cells::sections(&params, &grid.boundaries_m)
        } else {
            grid.nodes.iter().map(|node| Section::new(&params, node.position_m)).collect()
        };
        let masses = params
            .masses
            .iter()
            .map(|mass| EndMass {
                end: grid.nearest_end(mass.position_m),
                mass_kg: mass.mass_kg,
                inertia_kg_m2: mass.inertia_kg_m2,
            })
            .collect();
        let mut scales = vec![0.0_f64; grid.unknowns];
        let mut elastic_diagonal = vec![0.0_f64; grid.unknowns];
        let length = params.length_m();
        for (node, section) in grid.nodes.iter().zip(&sections) {
            for (c, scale) in section.scales().into_iter().enumerate() {
                // A curvature along the whole rod moves the tip by up to the square of the length.
                let lever = if c < 3 { length * length } else { length };
                let columns = node.offset[c]..node.offset[c] + grid.modes[c];
                scales[columns.clone()].iter_mut().for_each(|slot| *slot = slot.max(scale * lever));
                let squares = node.basis.iter().map(|basis| node.weight_m * scale * basis * basis);
                elastic_diagonal[columns]
                    .iter_mut()
                    .zip(squares)
                    .for_each(|(slot, square)| *slot += square);
            }
        }
        let guides_at = |node: &Node| {
            params.tendons.iter().map(|tendon| tendon.guide(node.position_m)).collect::<Vec<_>>()
        };
        let guides: Vec<TendonGuide> = grid.nodes.iter().flat_map(guides_at).collect();
        let home_lengths_m = (0..params.tendons.len())
            .map(|i| home_length_m(&params.tendons, &grid, &sections, &guides, i))
            .collect();
        let reach_m_per_n = (0..params.tendons.len())
            .map(|i| reach_m_per_n(&params, &sections, &guides, i))
            .collect();
        let constant_loads = ConstantLoads::new(&params, &grid);
        let contact_points = ContactPoint::all(&params, &grid);
        RodEquations {
            params,
            grid,
            sections,
            masses,
            constant_loads,
            contact_points,
            guides,
            home_lengths_m,
            scales,
            elastic_diagonal,
            reach_m_per_n,
        }
    }

    /// Number of equations: polynomial coefficients, then tensions.
    pub(crate) fn size(&self) -> usize {
        self.grid.unknowns + self.params.tendons.len()
    }

    pub(crate) fn workspace(&self) -> Workspace {
        let base = rotation::exp(&self.params.base_rotation_rad);
        let (nodes, tendons) = (self.grid.nodes.len(), self.params.tendons.len());
        Workspace {
            shape: Shape::new(&self.grid, base, self.params.base_m),
            loads: Loads::new(&self.grid),
            touches: Vec::new(),
            tangents: vec![Vector3::zeros(); nodes * tendons],
            stretches: vec![0.0; nodes * tendons],
            inverse_stretches: vec![0.0; nodes * tendons],
            tension_shares: vec![1.0; nodes * tendons],
            sliding: self.tendons_at_home(),
            lengths_m: vec![0.0; tendons],
            history_tangent: vec![[[0.0; 2]; 2]; nodes],
            field: vec![0.0; COMPONENTS * nodes],
            imbalance: vec![[0.0; COMPONENTS]; nodes],
            axial_weight: vec![0.0; nodes],
            weights_frozen: false,
            residual: vec![0.0; self.size()],
        }
    }

    /// Virgin histories.
    pub(crate) fn virgin_histories(&self) -> Vec<Vec<HistoryState>> {
        self.params
            .moment_laws
            .iter()
            .map(|_| vec![HistoryState::default(); self.grid.nodes.len()])
            .collect()
    }

    /// Evaluates the equations at `unknowns`.
    pub(crate) fn evaluate(
        &self,
        unknowns: &[f64],
        conditions: &SolveConditions,
        workspace: &mut Workspace,
    ) {
        vectorised!(self.evaluate_all(unknowns, conditions, workspace));
    }

    #[inline(always)]
    fn evaluate_all(
        &self,
        unknowns: &[f64],
        conditions: &SolveConditions,
        workspace: &mut Workspace,
    ) {
        workspace.shape.update(&self.grid, &self.sections, &unknowns[..self.grid.unknowns]);
        if !workspace.weights_frozen {
            let axial = workspace.shape.compliance.iter().map(|compliance| compliance.diagonal[3]);
            workspace
                .axial_weight
                .iter_mut()
                .zip(axial)
                .for_each(|(weight, compliance)| *weight = compliance);
        }
        self.balance(unknowns, conditions, workspace);
    }

    /// Evaluates the equations for the shape and the weights in `workspace`.
    #[inline(always)]
    pub(crate) fn balance(
        &self,
        unknowns: &[f64],
        conditions: &SolveConditions,
        workspace: &mut Workspace,
    ) {
        let tensions = &unknowns[self.grid.unknowns..];
        // Order: tension shares need the paths, loads need the contacts.
        self.update_tendons(workspace);
        self.update_tension_shares(tensions, conditions, workspace);
        self.update_touches(conditions, workspace);
        let Workspace { loads, shape, touches, .. } = &mut *workspace;
        let rod = LoadedRod {
            params: &self.params,
            grid: &self.grid,
            sections: &self.sections,
            masses: &self.masses,
            constant_loads: &self.constant_loads,
            touches,
        };
        loads.update(&rod, shape, conditions);
        workspace.residual.fill(0.0);
        let points = self.grid.basis.points;
        for (g, node) in self.grid.nodes.iter().enumerate() {
            let imbalance = self.imbalance(g, tensions, conditions, workspace);
            let strain = workspace.weighted_strain(g, &imbalance);
            (0..COMPONENTS)
                .for_each(|c| workspace.field[c * points + g] = node.weight_m * strain[c]);
            workspace.imbalance[g] = imbalance;
        }
        self.grid.basis.test(&workspace.field, &mut workspace.residual);
        for (i, constraint) in conditions.constraints.iter().enumerate() {
            workspace.residual[self.grid.unknowns + i] = match *constraint {
                TendonConstraint::Length(_) if conditions.taut[i] => {
                    self.overstretch_m(i, constraint, tensions[i], workspace)
                }
                // A slack tendon has no tension.
                TendonConstraint::Length(_) => tensions[i],
                TendonConstraint::Tension(tension_n) => tensions[i] - tension_n,
            };
        }
    }

    /// Excess length of tendon `i` over what its drive and its own stretch allow, metres; negative
    /// when slack.
    pub(crate) fn overstretch_m(
        &self,
        i: usize,
        constraint: &TendonConstraint,
        tension_n: f64,
        workspace: &Workspace,
    ) -> f64 {
        let tendon = &self.params.tendons[i];
        let pull = if let TendonConstraint::Length(pull) = *constraint { pull } else { 0.0 };
        workspace.lengths_m[i] + pull
            - self.home_lengths_m[i]
            - tendon.compliance_at(pull) * tension_n
    }

    /// Internal minus external wrench at Gauss point `g`, body frame.
    #[inline(always)]
    fn imbalance(
        &self,
        g: usize,
        tensions: &[f64],
        conditions: &SolveConditions,
        workspace: &mut Workspace,
    ) -> Components {
        let section = &self.sections[g];
        let strain = workspace.shape.strain[g];
        let mut total = workspace.shape.wrench[g];
        // The terms of the balance in docs/method/rod.md: first the viscous wrench …
        let motion = conditions.motion;
        if motion.rate > 0.0 {
            for c in 0..COMPONENTS {
                total[c] +=
                    section.viscosity[c] * (strain[c] * motion.rate + motion.strain_v[g][c]);
            }
        }
        // … then the moments with a memory …
        workspace.history_tangent[g] = [[0.0; 2]; 2];
        for (law, states) in self.params.moment_laws.iter().zip(conditions.histories) {
            if !law.acts_at(self.grid.nodes[g].position_m) {
                continue;
            }
            let bend = section.bending(&strain);
            let history = if conditions.at_rest {
                law.settled(&states[g], bend, section.bending_n_m2, conditions.rested_s)
            } else {
                law.moment(&states[g], bend, section.bending_n_m2)
            };
            for a in 0..2 {
                total[a] += history.moment_nm[a];
                for b in 0..2 {
                    workspace.history_tangent[g][a][b] += history.tangent_n_m2[a][b];
                }
            }
        }
        // … then the tendons …
        for (i, &tension) in tensions.iter().enumerate() {
            if tension != 0.0 {
                let pull = self.tendon_wrench(g, i, workspace);
                let here_n = tension * workspace.tension_shares[g * tensions.len() + i];
                for c in 0..COMPONENTS {
                    total[c] += here_n * pull[c];
                }
            }
        }
        // … less what the loads beyond the cross-section put on it.
        let r = &workspace.shape.node_r[g];
        let moment = matrix3::transpose_times(r, &workspace.loads.moment[g]);
        let force = matrix3::transpose_times(r, &workspace.loads.force[g]);
        for a in 0..3 {
            total[a] -= moment[a];
            total[a + 3] -= force[a];
        }
        total
    }

    /// Wrench of a unit tension of tendon `i` on the cross-section at `g`: (r × t, t), zero past
    /// the tendon's end. It is also d length / d strain (Rucker & Webster 2011, in variational
    /// form).
    #[inline(always)]
    pub(crate) fn tendon_wrench(&self, g: usize, i: usize, workspace: &Workspace) -> Components {
        let t = &workspace.tangents[g * self.params.tendons.len() + i];
        let [x, y] = self.guides[g * self.params.tendons.len() + i].offset_m;
        [y * t.z, -x * t.z, x * t.y - y * t.x, t.x, t.y, t.z]
    }

    /// The stiffness at Gauss point `g` that taut tendons add: Σ tension · ∂²length/∂strain².
    #[inline(always)]
    pub(crate) fn tendon_stiffness(
        &self,
        g: usize,
        tensions: &[f64],
        workspace: &Workspace,
    ) -> [Components; COMPONENTS] {
        let mut total = [[0.0; COMPONENTS]; COMPONENTS];
        for (i, &tension) in tensions.iter().enumerate() {
            let k = g * tensions.len() + i;
            let stretch = workspace.stretches[k];
            if tension != 0.0 && stretch != 0.0 {
                let here_n = tension * workspace.tension_shares[k];
                self.guides[k].add_stiffness(&workspace.tangents[k], stretch, here_n, &mut total);
            }
        }
        total
    }

    /// Path tangents and lengths of all tendons: a = v + u × r + r′ a length of backbone.
    #[inline(always)]
    fn update_tendons(&self, workspace: &mut Workspace) {
        let count = self.params.tendons.len();
        if count == 0 {
            return;
        }
        let points = self.guides.chunks_exact(count).zip(&workspace.shape.strain);
        let each = workspace
            .tangents
            .chunks_exact_mut(count)
            .zip(workspace.stretches.chunks_exact_mut(count));
        for ((guides, strain), (paths, squares)) in points.zip(each) {
            for ((guide, path), square) in guides.iter().zip(paths).zip(squares) {
                *path = if guide.present { guide.path(strain) } else { Vector3::zeros() };
                *square = path.norm_squared();
            }
        }
        // Square roots and quotients in one pass, for vector instructions.
        for (stretch, inverse) in
            workspace.stretches.iter_mut().zip(&mut workspace.inverse_stretches)
        {
            *stretch = stretch.sqrt();
            *inverse = if *stretch > 0.0 { 1.0 / *stretch } else { 0.0 };
        }
        let tangents = workspace.tangents.iter_mut().zip(&workspace.inverse_stretches);
        tangents.for_each(|(tangent, &inverse)| *tangent *= inverse);
        workspace.lengths_m.fill(0.0);
        for (node, stretches) in self.grid.nodes.iter().zip(workspace.stretches.chunks_exact(count))
        {
            workspace
                .lengths_m
                .iter_mut()
                .zip(stretches)
                .for_each(|(length, stretch)| *length += node.weight_m * stretch);
        }
    }

    /// Adds the weak form of a strain-like vector at Gauss point `g` to the balance equations.
    pub(crate) fn project(&self, g: usize, value: &Components, out: &mut [f64]) {
        let node = &self.grid.nodes[g];
        for c in 0..COMPONENTS {
            let scaled = node.weight_m * value[c];
            let rows = &mut out[node.offset[c]..node.offset[c] + self.grid.modes[c]];
            for (slot, basis) in rows.iter_mut().zip(&node.basis) {
                *slot += scaled * basis;
            }
        }
    }

    /// Size of a step of the unknowns as a tip displacement, metres. Once every section of the
    /// spine is saturated, axial forces move the tip no more than without sections.
    pub(crate) fn size_of_step_m(&self, step: &[f64], workspace: &Workspace) -> f64 {
        let length = self.params.length_m();
        // The axial scale follows saturation; all others are fixed.
        let axial = length * workspace.axial_weight.iter().copied().fold(0.0, f64::max);
        let (per_element, axial_modes) =
            (self.grid.modes.iter().sum::<usize>(), self.grid.modes[5]);
        let mut largest = 0.0_f64;
        for (element_step, scales) in step.chunks(per_element).zip(self.scales.chunks(per_element))
        {
            let (others, forces) = element_step.split_at(per_element - axial_modes);
            largest = others
                .iter()
                .zip(scales)
                .map(|(x, scale)| (x * scale).abs())
                .fold(largest, f64::max);
            largest = forces.iter().map(|x| (x * axial).abs()).fold(largest, f64::max);
        }
        // `f64::max` ignores NaN, which must not look small.
        if step.iter().all(|x| x.is_finite()) { largest } else { f64::NAN }
    }

    /// Inner product of two steps of the unknowns in the norm of tip displacements, m².
    pub(crate) fn product_m2(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        a.iter().zip(b.iter()).zip(&self.scales).map(|((x, y), scale)| x * y * scale * scale).sum()
    }

    /// Path lengths of the tendons on a shape, metres.
    pub(crate) fn lengths_m(&self, shape: &Shape) -> Vec<f64> {
        let count = self.params.tendons.len();
        let mut lengths_m = vec![0.0; count];
        for (g, node) in self.grid.nodes.iter().enumerate() {
            for (length_m, guide) in lengths_m.iter_mut().zip(&self.guides[g * count..]) {
                if guide.present {
                    *length_m += node.weight_m * guide.path(&shape.strain[g]).norm();
                }
            }
        }
        lengths_m
    }
}

/// Approximate tip displacement per unit tension of tendon `i`, m/N: from bending and from axial
/// shortening.
fn reach_m_per_n(
    params: &RodParams,
    sections: &[Section],
    guides: &[TendonGuide],
    i: usize,
) -> f64 {
    let length = params.length_m();
    let passing = sections.iter().zip(guides.iter().skip(i).step_by(params.tendons.len()));
    let of = |(section, guide): (&Section, &TendonGuide)| {
        let ([x, y], scales) = (guide.offset_m, section.scales());
        // A constant curvature κ moves the tip by κ L²/2.
        0.5 * section.max_turning_compliance() * x.hypot(y) * length * length + scales[5] * length
    };
    passing.filter(|(_, guide)| guide.present).map(of).fold(0.0, f64::max)
}

/// Path length of tendon `i` on the rod at home, metres.
fn home_length_m(
    tendons: &[Tendon],
    grid: &Grid,
    sections: &[Section],
    guides: &[TendonGuide],
    i: usize,
) -> f64 {
    let along = grid.nodes.iter().zip(sections).zip(guides.iter().skip(i).step_by(tendons.len()));
    let passing = along.filter(|(_, guide)| guide.present);
    // As long as its part of the rod: exact, where the quadrature would round.
    if passing
        .clone()
        .all(|((_, section), guide)| guide.slope == [0.0; 2] && section.home == [0.0; 3])
    {
        return tendons[i].end_m - tendons[i].start_m;
    }
    let stretch = |((node, section), guide): ((&Node, &Section), &TendonGuide)| {
        let [x, y, z] = section.home;
        node.weight_m * guide.path(&[x, y, z, 0.0, 0.0, 1.0]).norm()
    };
    passing.map(stretch).sum()
}
