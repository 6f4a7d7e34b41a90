//! Construction of an engine: its operator, and the closure of its rows, measured or restored.

use super::selection::EngineChoice;
use crate::balance::closure::{self, RowClosure};
use crate::balance::least_squares_closure;
use crate::context::{BuiltEngine, SolveContext};
use crate::device::GridPart;
use crate::device::basis::BasisOrder;
use crate::distribution::sum_order::SharedZones;
use crate::engines::bordered_operator::BorderedOperator;
use crate::engines::dense::DenseOperator;
use crate::engines::dense::band_groups::{BandGroups, InteriorPanes};
use crate::engines::dense::image_sums::{ImageSumOperator, ImageSums};
use crate::engines::layered::{LayerStack, LayeredOperator};
use crate::engines::merged_operator::{MergedOperator, PatchGroups};
use crate::engines::rays;
use crate::engines::spectral::SpectralOperator;
use crate::engines::spectral::cpu::Processor;
use crate::engines::spectral::enclosure::BoxEnclosure;
use crate::operator::{AdjustableExchange, ErrorModel};
use crate::right_hand_side::surroundings::{SurroundingsExchange, exact_rows};
use crate::settings::{SolvePurpose, SolveSettings};
use zonal_exchange::pair::{Exchange, PairCounts};
use zonal_scene::{Diagnostic, Engine, Scene, SceneError, ZoneImages};

/// Builds the selected engine, with merged patches where the zones have some. Restoration of closure scales `surroundings` too.
pub(crate) fn build<'a>(
    choice: EngineChoice,
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
) -> Result<BuiltEngine<'a>, SceneError> {
    let built = build_single(choice, context, surroundings)?;
    Ok(match PatchGroups::of(context.zones) {
        Some(groups) => {
            BuiltEngine { operator: Box::new(MergedOperator { operator: built.operator, groups }), ..built }
        }
        None => built,
    })
}

/// As [`build`], with the exchange of the single patches.
fn build_single<'a>(
    choice: EngineChoice,
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
) -> Result<BuiltEngine<'a>, SceneError> {
    match (choice.engine, choice.enclosure, choice.layers) {
        (Engine::Rays, ..) => rays::build::build(context, surroundings),
        (Engine::Spectral, Some((enclosure, order)), _) => {
            let mut built = build_spectral(context, enclosure, order, surroundings);
            built.warnings.extend(choice.note);
            Ok(built)
        }
        (Engine::Layered, _, Some(stack)) => {
            let mut built = build_layered(context, stack, surroundings);
            built.warnings.extend(choice.note);
            Ok(built)
        }
        _ => Ok(build_dense(context, surroundings)),
    }
}

/// Measures the closure of an operator, or restores it if the scene requests that.
fn close_rows(
    operator: &mut dyn ErrorModel,
    scene: &Scene,
    zones: SharedZones,
    surroundings: &mut SurroundingsExchange,
) -> RowClosure {
    let measured = closure::measure(operator, zones, surroundings);
    restore_if_requested(operator, scene, zones, surroundings, measured)
}

/// Restores the measured closure of an operator if the scene requests that.
fn restore_if_requested(
    operator: &mut dyn ErrorModel,
    scene: &Scene,
    zones: SharedZones,
    surroundings: &mut SurroundingsExchange,
    measured: RowClosure,
) -> RowClosure {
    if scene.restores_closure() {
        closure::restore(operator, zones, surroundings, measured)
    } else {
        measured
    }
}

/// The spectral engine; the escaping power is the power that arrives at the openings of the box. For a comparison the rows are those of the tables: what their
/// errors do to the balance is added to the differences.
fn build_spectral<'a>(
    context: &SolveContext<'a>,
    enclosure: BoxEnclosure,
    order: BasisOrder,
    surroundings: &mut SurroundingsExchange,
) -> BuiltEngine<'a> {
    let (scene, zones) = (context.scene, context.zones);
    let (open, outside) = (enclosure.is_open(), enclosure.outside.clone());
    let part = GridPart {
        accuracy: context.settings.purpose.table_accuracy(),
        ..GridPart::new(enclosure.grid, order, context.settings.communicator)
    };
    let device = context.settings.device.unwrap_or(&Processor);
    let mut operator = SpectralOperator::of_part(enclosure, zones, part, device, context.execution());
    if open {
        surroundings.sky = operator.opening_factors();
    }
    if context.settings.purpose == SolvePurpose::Comparison && outside.is_empty() {
        let (closure, counts) = (RowClosure::unmeasured(zones), operator.counts());
        return BuiltEngine::unsolved(Box::new(operator), closure, counts);
    }
    let rows = operator.measure_defect(zones, &surroundings.sky);
    if !outside.is_empty() {
        return build_bordered(context, operator, outside, surroundings);
    }
    let measured = closure::measure_rows(rows, context.shared_zones(), surroundings);
    let closure = restore_if_requested(&mut operator, scene, context.shared_zones(), surroundings, measured);
    let counts = operator.counts();
    BuiltEngine::unsolved(Box::new(operator), closure, counts)
}

/// The spectral engine with patches outside the box.
fn build_bordered<'a>(
    context: &SolveContext<'a>,
    inner: SpectralOperator<'a>,
    outside: Vec<u32>,
    surroundings: &mut SurroundingsExchange,
) -> BuiltEngine<'a> {
    let count = outside.len() as u64;
    let (mut operator, pairs) = BorderedOperator::new(context, inner, outside);
    operator.set_losses(context.zones, surroundings);
    let closure = close_rows(&mut operator, context.scene, context.shared_zones(), surroundings);
    let mut counts = operator.counts();
    counts.push(("patches outside the medium".to_string(), count));
    counts.extend(pair_counts(&pairs).into_iter().filter(|c| c.1 > 0));
    BuiltEngine::unsolved(Box::new(operator), closure, counts)
}

/// The layered engine; the escaping power is the power that arrives at the open ends.
fn build_layered(
    context: &SolveContext,
    stack: LayerStack,
    surroundings: &mut SurroundingsExchange,
) -> BuiltEngine<'static> {
    let open = stack.is_open();
    let mut operator = LayeredOperator::new(stack, context.settings.progress);
    if open {
        surroundings.sky = operator.opening_factors();
    }
    let closure = close_rows(&mut operator, context.scene, context.shared_zones(), surroundings);
    let counts = operator.counts();
    BuiltEngine::unsolved(Box::new(operator), closure, counts)
}

/// The dense engine.
pub(crate) fn build_dense<'a>(
    context: &SolveContext<'a>,
    surroundings: &mut SurroundingsExchange,
) -> BuiltEngine<'a> {
    let (scene, zones) = (context.scene, context.zones);
    let exchange = Exchange::with_settings(scene, zones, context.transport, context.settings.pair_settings);
    let groups = BandGroups::of_scene(scene, InteriorPanes::of(context.transport));
    let sums = ImageSums { exchange: &exchange, images: context.images };
    let panes = zones.panes.len() / context.images.map_or(1, ZoneImages::image_count);
    let (operator, pairs) = DenseOperator::assemble(
        &sums,
        [context.images.map_or(zones.len(), ZoneImages::zone_count), panes],
        groups,
        context.settings.checkpoints,
        context.execution(),
    );
    drop(exchange);
    let mut operator: Box<dyn AdjustableExchange + 'a> = match context.images {
        Some(images) => Box::new(ImageSumOperator::new(operator, images)),
        None => Box::new(operator),
    };
    let closure = close_dense_rows(operator.as_mut(), context, surroundings);
    let mut warnings = Vec::new();
    if pairs.by_volume_method > 0 {
        let text = "the factors of two voxels are those of the 1996 paper, for comparison; the stated errors do not include the errors of these formulas";
        warnings.push(Diagnostic::warning("paper-factors", text));
    }
    let counts = pair_counts(&pairs);
    BuiltEngine { warnings, ..BuiltEngine::unsolved(operator, closure, counts) }
}

/// Completes the losses of the zones, and measures the closure of the rows or restores it.
fn close_dense_rows(
    operator: &mut dyn AdjustableExchange,
    context: &SolveContext,
    surroundings: &mut SurroundingsExchange,
) -> RowClosure {
    let (scene, zones) = (context.scene, context.zones);
    if exact_rows::are_known_later(scene, zones, &context.settings.pair_settings) && context.images.is_none()
    {
        let settings = SolveSettings {
            checkpoints: context.settings.checkpoints,
            pair_settings: context.settings.pair_settings,
            communicator: context.settings.communicator,
            ..SolveSettings::new(context.settings.memory_limit, context.settings.progress)
        };
        let pilot = std::mem::take(surroundings);
        *surroundings = exact_rows::complete(operator, zones, context.transport, pilot, &settings);
    }
    let mut measured = closure::measure(operator, context.shared_zones(), surroundings);
    if exact_rows::are_restored(scene, &context.settings.pair_settings) {
        let restore = match scene.options().restore_closure {
            Some(_) => least_squares_closure::restore_fully,
            None => least_squares_closure::restore,
        };
        restore(operator, context.shared_zones(), surroundings, measured)
    } else {
        least_squares_closure::state_row_errors(operator, zones, surroundings, &mut measured);
        measured
    }
}

/// Names and values of the counters of pairs.
fn pair_counts(c: &PairCounts) -> Vec<(String, u64)> {
    let list = [
        ("aligned pairs", c.aligned),
        ("voxel pairs by a formula of the paper", c.by_volume_method),
        ("pairs with a plate in any position", c.general),
        ("pairs with a cut voxel", c.cut),
        ("pairs with a pane", c.pane),
        ("pairs that face away", c.facing_away),
        ("pairs partly visible", c.partial),
        ("rays between zones", c.rays),
    ];
    list.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}
