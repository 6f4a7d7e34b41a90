//! Fields of a solution and of its light groups, with their errors, from the strengths of the iteration.

use crate::balance::energy_balance::{GroupFields, balance_group};
use crate::context::{BlockEngine, BuiltEngine, SolveContext};
use crate::engines::merged_operator::PatchGroups;
use crate::engines::rays::gather::gather_error::ratio;
use crate::engines::rays::stored_rays::power_normalization::{imbalance, normalize_power};
use crate::errors::closure_error::take_unexplained_fractions;
use crate::errors::consistency;
use crate::errors::direct_error::{self, ErrorSum};
use crate::errors::empty_rows::EmptyRows;
use crate::errors::propagation::{errors_like, propagate_factor_errors};
use crate::iteration::IterationResult;
use crate::operator::IncidentPower;
use crate::pipeline::error_amplification;
use crate::pipeline::group_solve::SolvedColumns;
use crate::right_hand_side::light_groups::SourceGroup;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_math::parallel;
use zonal_scene::{
    Band, Bands, EnergyBalance, Engine, ErrorParts, Fields, LightGroup, SolveStatus, ZoneValues, Zones,
};

/// The fields of all light and of each group. Where nothing leaves the scene, the results have no strengths afterwards: the incident
/// power takes their memory.
pub(crate) fn assemble(
    block: &mut BlockEngine,
    columns: &mut SolvedColumns,
    engine: Engine,
) -> (Fields, Vec<LightGroup>) {
    let SolvedColumns { results, incident, products } = columns;
    let (incident, products) = (incident.take(), std::mem::take(products));
    let BlockEngine { context, built, surroundings } = block;
    let (zones, n) = (context.zones, context.zones.len());
    if let Some(groups) = PatchGroups::of(zones) {
        results.iter_mut().for_each(|r| groups.average(&mut r.strengths));
    }
    // The rows of a solution by rays close, but its power balance does not.
    let options = context.scene.options();
    let may_miss_power = incident.is_some() && options.scattering_orders.is_none();
    let fractions = take_unexplained_fractions(zones, &mut built.closure, surroundings);
    let unclosed = error_amplification::unclosed_fractions(context, &mut built.closure, &fractions);
    // Apply the operator to the solution.
    let IncidentPower { mut columns, mut error, column_errors } =
        incident_power(built, surroundings, results, products, incident);
    columns.iter_mut().chain(&mut error).for_each(|a| a.truncate(n));
    // Compute the fields of each group and their sum.
    let mut assembly = GroupAssembly {
        context,
        surroundings,
        engine,
        // An expansion may undershoot in dark zones. With slopes the mean of a zone keeps its sign, and with it the power.
        min_incident: if built.operator.len() > n { f64::NEG_INFINITY } else { 0.0 },
        normalizes: context.scene.restores_closure(),
        imbalance: vec![Bands::ZERO; n * usize::from(may_miss_power)],
        fields: Fields { incident: parallel::collect(n, |_| Bands::ZERO), ..Fields::default() },
    };
    let mut groups = Vec::new();
    for ((source, result), incident) in context.sources.iter().zip(&*results).zip(columns) {
        groups.push(assembly.add_group(built, source, result, incident));
    }
    let GroupAssembly { mut fields, imbalance, .. } = assembly;
    // Propagate the errors.
    let error_sum = if column_errors.is_empty() { ErrorSum::Linear } else { ErrorSum::Independent };
    let contain_sources = !column_errors.is_empty();
    fields.error = match error {
        Some(mut errors) => {
            let over_measure = |errors: &mut Vec<Bands>| {
                parallel::for_each(errors, |i, e| *e /= zones.response(i).1);
            };
            over_measure(&mut errors);
            for (group, mut own) in groups.iter_mut().zip(column_errors) {
                over_measure(&mut own);
                group.error = errors_like(&group.incident, &own, group.incident_scale);
            }
            errors
        }
        None => propagate_factor_errors(zones, built.operator.as_ref(), &fractions, results, &mut groups),
    };
    if !contain_sources {
        error_amplification::widen_by_reflection(context, built.operator.as_ref(), &mut fields, &mut groups);
    }
    direct_error::propagate_to_groups(context, built.operator.as_ref(), error_sum, &mut fields, &mut groups);
    consistency::widen_by_closure(&fractions, &mut fields);
    let mut empty_rows = EmptyRows::of(context, &fractions);
    fields.radiosity = radiosity(zones, &fields, fractions);
    let sky = context.scene.surroundings().radiosity();
    empty_rows.limit(context.shared_zones(), sky, &mut fields, &mut groups);
    if let Some(unclosed) = unclosed {
        let operator = built.operator.as_ref();
        error_amplification::widen_by_defects(context, operator, &unclosed, &empty_rows, &mut fields);
    }
    if let Some(parts) = &mut built.error_parts {
        add_to_parts(&imbalance, &fields, zones.patches.len(), parts);
    }
    widen_errors(context, surroundings, &groups, imbalance, &mut fields);
    (fields, groups)
}

/// Joins the imbalance of power with the error of the radiosities, of the patches and of the volume zones.
fn add_to_parts(imbalance: &[Bands], fields: &Fields, patches: usize, parts: &mut [ErrorParts; 2]) {
    if imbalance.is_empty() {
        return;
    }
    for (part, range) in parts.iter_mut().zip([0..patches, patches..imbalance.len()]) {
        let [error, level] = range.fold([Bands::ZERO; 2], |[error, level], i| {
            let (e, h) = (imbalance[i], fields.incident[i]);
            [error + e * e, level + h * h]
        });
        let relative = error.zip_map(level, ratio).sqrt().max_element();
        part.radiosities = part.radiosities.hypot(relative);
    }
}

/// Widens the errors of the fields by the residual of the iteration, the imbalance of power, the error of the surroundings and negative fluxes.
fn widen_errors(
    context: &SolveContext,
    surroundings: &SurroundingsExchange,
    groups: &[LightGroup],
    imbalance: Vec<Bands>,
    fields: &mut Fields,
) {
    consistency::widen_by_residual(context.shared_zones(), groups, fields);
    if !imbalance.is_empty() {
        parallel::for_each_pair(&mut fields.error, &imbalance, |e, c| *e = e.hypot(*c));
    }
    add_surroundings_error(context, surroundings, fields);
    if !context.shared_zones().has_negative_source() {
        consistency::widen_by_negative_flux(fields);
    }
}

/// Widens the errors of the fields and of the groups by relative errors of the patches and of the volume zones, which every zone has in proportion to its
/// incident radiation.
pub(crate) fn widen_by_zoning(
    zoning: [Bands; 2],
    fields: &mut Fields,
    groups: &mut [LightGroup],
    patches: usize,
) {
    let share = |i: usize| zoning[usize::from(i >= patches)];
    let Fields { error, incident, .. } = fields;
    parallel::for_each(error, |i, e| *e = e.hypot(share(i) * incident[i]));
    for group in groups.iter_mut().filter(|g| !g.error.is_empty()) {
        let mut own = group.errors(error.len());
        own.iter_mut().enumerate().for_each(|(i, e)| *e = e.hypot(share(i) * group.incident_at(i)));
        group.error = errors_like(&group.incident, &own, group.incident_scale);
    }
}

/// The incident power of the solution: that of the gather, of the iteration (`products`, if all of it converged), or a product of its own. Strengths are lent to
/// the operator, since those of a large scene are not copied, and given back where powers that leave the scene or errors need them.
fn incident_power(
    built: &BuiltEngine,
    surroundings: &SurroundingsExchange,
    results: &mut [IterationResult],
    mut products: Vec<Vec<Bands>>,
    incident: Option<IncidentPower>,
) -> IncidentPower {
    let is_closed = surroundings.is_closed();
    if incident.is_none() && !products.is_empty() && results.iter().all(has_converged) {
        let spare = if is_closed { std::mem::take(&mut results[0].strengths) } else { Vec::new() };
        match built.operator.error_of_power(&products, spare) {
            Ok(error) => {
                if is_closed {
                    results.iter_mut().for_each(|r| r.strengths = Vec::new());
                }
                return IncidentPower { columns: products, error: Some(error), ..Default::default() };
            }
            Err(given_back) if is_closed => results[0].strengths = given_back,
            Err(_) => {}
        }
    }
    let mut strengths: Vec<Vec<Bands>> =
        results.iter_mut().map(|e| std::mem::take(&mut e.strengths)).collect();
    if incident.is_none() && is_closed {
        let spare = products.pop().unwrap_or_default();
        drop(products);
        match built.operator.incident_power_in_place(strengths, spare) {
            Ok(found) => return found,
            Err(given_back) => strengths = given_back,
        }
    }
    let incident = incident.unwrap_or_else(|| built.operator.incident_power(&strengths));
    results.iter_mut().zip(strengths).for_each(|(e, s)| e.strengths = s);
    incident
}

/// True if the iteration of a group converged in all bands.
fn has_converged(result: &IterationResult) -> bool {
    Band::all().all(|b| result.status[b] == SolveStatus::Converged)
}

/// Radiosity of all zones, W/m², in the memory of `out`.
fn radiosity(zones: &Zones, f: &Fields, mut out: Vec<Bands>) -> Vec<Bands> {
    parallel::for_each(&mut out, |i, b| {
        *b = zones.emission(i) + zones.scattered(i, |k| f.incident[k] + f.direct_light(k));
    });
    out
}

/// Adds the error of the incoming radiation to the error of every zone.
fn add_surroundings_error(context: &SolveContext, surroundings: &SurroundingsExchange, f: &mut Fields) {
    let sky = context.scene.surroundings().radiosity();
    if surroundings.error.is_empty() || sky == Bands::ZERO {
        return;
    }
    let zones = context.zones;
    let part = |i| surroundings.incoming(i, sky)[1] / zones.response(i).1;
    f.surroundings_error = parallel::collect(zones.len(), part);
    parallel::for_each_pair(&mut f.error, &f.surroundings_error, |e, part| *e = e.hypot(*part));
}

/// Adds up the fields of the groups.
struct GroupAssembly<'a> {
    context: &'a SolveContext<'a>,
    surroundings: &'a SurroundingsExchange,
    engine: Engine,
    /// Lower bound of the incident field, W/m².
    min_incident: f64,
    /// True if the imbalance of each group is removed.
    normalizes: bool,
    /// Sum over the groups of the share of each zone in the imbalance of power, W/m²; empty for engines whose balance closes.
    imbalance: Vec<Bands>,
    fields: Fields,
}

impl GroupAssembly<'_> {
    /// The group of a source, from the incident power `incident` of its strengths; added to the sum.
    fn add_group(
        &mut self,
        built: &mut BuiltEngine,
        source: &SourceGroup,
        result: &IterationResult,
        mut incident: Vec<Bands>,
    ) -> LightGroup {
        let (scene, zones, direct) = (self.context.scene, self.context.zones, self.context.direct);
        let (own, sky) = (source.direct(direct), source.sky(scene));
        self.to_incident_field(&mut incident, sky);
        let balance = |incident: &[Bands]| {
            let fields = GroupFields { incident, direct: &own, strengths: &result.strengths };
            balance_group(scene, self.context.shared_zones(), source, &fields, self.surroundings, direct)
        };
        let mut energy = balance(&incident);
        // Restore the balance of power.
        if !self.imbalance.is_empty() {
            let change = imbalance(zones, &energy, &incident);
            if self.normalizes && normalize_power(change, &mut incident, scene.options().tolerance) {
                built.closure.summary.record_normalization(change);
                energy = balance(&incident);
            }
            self.imbalance.iter_mut().zip(&incident).for_each(|(c, h)| *c += change.abs() * h);
        }
        // Add to the fields of all light.
        let f = &mut self.fields;
        parallel::for_each_pair(&mut f.incident, &incident, |f, h| *f += h);
        if self.context.shared_zones().any(|i| own.get(i).is_some_and(|d| *d != Bands::ZERO)) {
            f.direct.resize(own.len(), Bands::ZERO);
        }
        own.iter().zip(&mut f.direct).for_each(|(d, f)| *f += d);
        let mut group = light_group(source, result, energy, incident, own, self.engine);
        let error = direct_error::group_error(source, direct);
        if !error.is_empty() {
            f.direct_error.resize(zones.len(), Bands::ZERO);
            f.direct_error.iter_mut().zip(&error).for_each(|(f, e)| *f += e);
            group.direct_error = errors_like(&group.direct, &error, group.direct_scale);
        }
        group
    }

    /// Turns incident powers into incident fields, W/m², with the radiation from surroundings of radiosity `sky`.
    fn to_incident_field(&self, incident: &mut [Bands], sky: Bands) {
        let zones = self.context.zones;
        let least = self.min_incident;
        parallel::for_each(incident, |i, h| {
            let (_, measure) = zones.response(i);
            let [incoming, _] = self.surroundings.incoming(i, sky);
            // `max` would drop a NaN.
            let clamp = |x: f64| if x < least { least } else { x };
            *h = ((*h + incoming) / measure).map(clamp);
        });
    }
}

/// The group of a solution; in single precision for the rays engine, whose tolerance is much larger.
fn light_group(
    source: &SourceGroup,
    result: &IterationResult,
    energy: EnergyBalance,
    incident: Vec<Bands>,
    direct: Vec<Bands>,
    engine: Engine,
) -> LightGroup {
    let stored = |v: Vec<Bands>| match engine {
        Engine::Rays if !v.is_empty() => ZoneValues::to_single_precision(&v),
        _ => (ZoneValues::Double(v), Bands::ONE),
    };
    let ((incident, incident_scale), (direct, direct_scale)) = (stored(incident), stored(direct));
    LightGroup {
        name: source.name.clone(),
        kind: source.kind,
        incident,
        incident_scale,
        direct,
        direct_error: ZoneValues::default(),
        direct_scale,
        energy,
        status: result.status,
        residual: Bands::from_fn(|b| result.residuals[b].last().copied().unwrap_or(0.0)),
        error: ZoneValues::default(),
    }
}
